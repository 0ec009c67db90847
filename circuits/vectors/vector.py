"""Values of several runs side by side, in the lanes of a vector, for kernels to compute with.

A kernel takes a row of an array, float64[rows, WIDTH], as one value (`load`), computes with it as with a
number, and puts it back (`store`). What it does, it does in all lanes at once: `+ - * /` of two such values
or of one and a number, comparisons, which give a mask, `& | ~` of masks, and `select`. No lane has any
effect on another, so that a lane's bits are the same whatever stands beside it.

WIDTH is twice what the widest vectors hold, so that while one half waits for a result the other goes on.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.compiled import instructions

WIDTH = 16
_BYTES = 64  # of a vector in the processor, which rows are aligned to

Lanes: TypeAlias = Any
"""A number for each lane, in kernels alone."""
Mask: TypeAlias = Any
"""A yes or no for each lane, in kernels alone."""

ir, types = later("llvmlite.ir"), later("numba.core.types")
cgutils = later("numba.core.cgutils")
kinds = later("circuits.vectors.vector_types")


def rows(count: int) -> F64:
    """Room for values of all lanes, float64[count, WIDTH], all 0, at a place where vectors begin."""
    raw = np.zeros(count * WIDTH + _BYTES // 8)
    skip = (-raw.ctypes.data // 8) % (_BYTES // 8)
    return raw[skip : skip + count * WIDTH].reshape(count, WIDTH)


def splat(builder: Any, x: Any, width: int = WIDTH) -> Any:
    """Instructions that put one number into all lanes."""
    nothing = ir.Constant(ir.VectorType(x.type, width), ir.Undefined)
    first = builder.insert_element(nothing, x, ir.IntType(32)(0))
    return builder.shuffle_vector(
        first, nothing, ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
    )


def _row(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """Where a row of an array begins."""
    array, index = args[:2]
    start = context.make_array(signature.args[0])(context, builder, array).data
    place = builder.mul(context.cast(builder, index, signature.args[1], types.int64), ir.IntType(64)(WIDTH))
    return builder.bitcast(builder.gep(start, [place]), kinds.vector().as_pointer())


def _load(typingctx: Any, array: Any, row: Any) -> Any:
    """A row of an array."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        found = builder.load(_row(context, builder, signature, args))
        found.align = 8
        return found

    return kinds.lanes(array, row), codegen


def _store(typingctx: Any, array: Any, row: Any, value: Any) -> Any:
    """Put a value into a row of an array."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        put = builder.store(args[2], _row(context, builder, signature, args))
        put.align = 8
        return context.get_dummy_value()

    return types.void(array, row, kinds.lanes), codegen


def _every(typingctx: Any, x: Any) -> Any:
    """A number in all lanes."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return splat(builder, args[0])

    return kinds.lanes(types.float64), codegen


def _select(typingctx: Any, mask: Any, yes: Any, no: Any) -> Any:
    """What stands in `yes` where the mask says so, else what stands in `no`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(*args)

    return kinds.lanes(kinds.mask, kinds.lanes, kinds.lanes), codegen


def _magnitude(typingctx: Any, x: Any) -> Any:
    """Values without their signs."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        whole = ir.VectorType(ir.IntType(64), WIDTH)
        sign = ir.Constant(whole, [(1 << 63) - 1] * WIDTH)
        return builder.bitcast(builder.and_(builder.bitcast(args[0], whole), sign), kinds.vector())

    return kinds.lanes(kinds.lanes), codegen


def _larger(typingctx: Any, x: Any, y: Any) -> Any:
    """The larger of two values; the second where one is no number."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", *args), *args)

    return kinds.lanes(kinds.lanes, kinds.lanes), codegen


def _smaller(typingctx: Any, x: Any, y: Any) -> Any:
    """The smaller of two values; the second where one is no number."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered("<", *args), *args)

    return kinds.lanes(kinds.lanes, kinds.lanes), codegen


def _root(typingctx: Any, x: Any) -> Any:
    """Square roots."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = ir.FunctionType(kinds.vector(), [kinds.vector()])
        return builder.call(
            cgutils.get_or_insert_function(builder.module, kind, f"llvm.sqrt.v{WIDTH}f64"), args
        )

    return kinds.lanes(kinds.lanes), codegen


def _inverse_cube_root(typingctx: Any, x: Any) -> Any:
    """`x^(-1/3)` of positive normal numbers, to 1e-6 (tested): a guess by the exponent, three of Newton's."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        whole = ir.VectorType(ir.IntType(64), WIDTH)

        def number(value: float) -> Any:
            return ir.Constant(kinds.vector(), [value] * WIDTH)

        shift = ir.Constant(whole, [_HIGH_WORD] * WIDTH)
        high = builder.uitofp(builder.lshr(builder.bitcast(args[0], whole), shift), kinds.vector())
        guess = builder.fsub(number(float(_CUBE_ROOT >> _HIGH_WORD)), builder.fmul(high, number(1.0 / 3.0)))
        y = builder.bitcast(builder.shl(builder.fptoui(guess, whole), shift), kinds.vector())
        for _ in range(3):
            cube = builder.fmul(builder.fmul(y, y), y)
            left = builder.fsub(number(4.0), builder.fmul(args[0], cube))
            y = builder.fmul(builder.fmul(y, number(1.0 / 3.0)), left)
        return y

    return kinds.lanes(kinds.lanes), codegen


def _bits(typingctx: Any, mask: Any) -> Any:
    """A mask as an int64, the bit of lane k being 2^k."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.zext(builder.bitcast(args[0], ir.IntType(WIDTH)), ir.IntType(64))

    return types.int64(kinds.mask), codegen


def _bits_of(typingctx: Any, value: Any) -> Any:
    """Reinterpret a float64 as int64."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), codegen


def _of_bits(typingctx: Any, value: Any) -> Any:
    """Reinterpret an int64 as float64."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.int64), codegen


bits_of, of_bits = instructions(_bits_of, "bits_of"), instructions(_of_bits, "of_bits")

_HIGH_WORD = 20  # bits of the mantissa that a guess at a power does without
_CUBE_ROOT = 0x553EF0FF289DD796  # less a third of a number's bits are nearly those of its inverse cube root


# What the instructions are of one number, where a kernel is worked out for a run that goes alone.


def _load_alone(array: Any, row: int) -> Any:
    return array[row, 0]


def _store_alone(array: Any, row: int, value: float) -> None:
    array[row, 0] = value


def _every_alone(x: float) -> float:
    return x


def _select_alone(mask: bool, yes: float, no: float) -> float:  # noqa: FBT001 - as kernels call it
    return yes if mask else no


def _magnitude_alone(x: float) -> float:
    return abs(x)


def _larger_alone(x: float, y: float) -> float:
    return max(y, x)


def _smaller_alone(x: float, y: float) -> float:
    return min(y, x)


def _root_alone(x: float) -> float:
    return math.sqrt(x)


def _inverse_cube_root_alone(x: float) -> float:
    high = float(bits_of(x) >> _HIGH_WORD)
    y: float = of_bits(int(float(_CUBE_ROOT >> _HIGH_WORD) - high * (1.0 / 3.0)) << _HIGH_WORD)
    for _ in range(3):
        y = (y * (1.0 / 3.0)) * (4.0 - x * ((y * y) * y))
    return y


def _bits_alone(mask: bool) -> int:  # noqa: FBT001 - as kernels call it
    return int(mask)


load, store = instructions(_load, _load_alone), instructions(_store, _store_alone)
every, select = instructions(_every, _every_alone), instructions(_select, _select_alone)
magnitude, root = instructions(_magnitude, _magnitude_alone), instructions(_root, _root_alone)
larger, smaller = instructions(_larger, _larger_alone), instructions(_smaller, _smaller_alone)
inverse_cube_root = instructions(_inverse_cube_root, _inverse_cube_root_alone)
bits = instructions(_bits, _bits_alone)
