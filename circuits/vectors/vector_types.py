"""The types of `circuits.vectors.vector` as numba knows them, and what their operators are.

This imports numba; it is imported when the first kernel that takes lanes is made.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, ClassVar, final

from llvmlite import ir  # type: ignore[import-untyped]
from numba.core import types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import models, register_model

from circuits.vectors.vector import WIDTH, splat

_FUSED = ("contract",)  # a product and the sum that it goes into are rounded once


@final
class LanesType(types.Type):
    """A number for each lane."""

    def __init__(self) -> None:
        super().__init__(name=f"Lanes{WIDTH}")


@final
class MaskType(types.Type):
    """A yes or no for each lane."""

    def __init__(self) -> None:
        super().__init__(name=f"Mask{WIDTH}")


lanes, mask = LanesType(), MaskType()


def vector() -> Any:
    """How LLVM has a number for each lane."""
    return ir.VectorType(ir.DoubleType(), WIDTH)


def _held_as(kind: Any, element: Any) -> None:
    """Register how LLVM holds a type: a vector of an element a lane."""

    @register_model(kind)
    class _Model(models.PrimitiveModel):
        def __init__(self, dmm: Any, fe_type: Any) -> None:
            super().__init__(dmm, fe_type, ir.VectorType(element, WIDTH))


def _operator(op: Any, result: Any, takes: Sequence[tuple[Any, ...]], build: Callable[..., Any]) -> None:
    """Register an operator and its instructions, for each choice of the types that it takes."""

    @infer_global(op)
    class _Template(ConcreteTemplate):
        cases: ClassVar[Any] = [signature(result, *each) for each in takes]

    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        given = zip(args, sig.args, strict=True)
        return build(builder, *(splat(builder, x) if kind == types.float64 else x for x, kind in given))

    for each in takes:
        lower_builtin(op, *each)(lowered)


def _register() -> None:
    _held_as(LanesType, ir.DoubleType())
    _held_as(MaskType, ir.IntType(1))
    both = [(lanes, lanes), (lanes, types.float64), (types.float64, lanes)]
    for op, name in (
        (operator.add, "fadd"), (operator.sub, "fsub"), (operator.mul, "fmul"), (operator.truediv, "fdiv"),
    ):  # fmt: skip
        _operator(op, lanes, both, partial(_arithmetic, name))
    for op, name in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">=")):
        _operator(op, mask, both[:2], partial(_comparison, name))
    for op, name in ((operator.and_, "and_"), (operator.or_, "or_")):
        _operator(op, mask, [(mask, mask)], partial(_logic, name))
    _operator(operator.invert, mask, [(mask,)], lambda builder, x: builder.not_(x))


def _arithmetic(name: str, builder: Any, x: Any, y: Any) -> Any:
    return getattr(builder, name)(x, y, flags=_FUSED)


def _comparison(name: str, builder: Any, x: Any, y: Any) -> Any:
    return builder.fcmp_ordered(name, x, y)


def _logic(name: str, builder: Any, x: Any, y: Any) -> Any:
    return getattr(builder, name)(x, y)


_register()
