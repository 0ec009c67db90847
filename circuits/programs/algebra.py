"""Known values and expressions together: what is known is computed, the rest becomes an expression."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeGuard

import numpy as np

from circuits.errors import ParameterError

BINARY: Mapping[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow, ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod,
    ast.LShift: operator.lshift, ast.RShift: operator.rshift, ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
}  # fmt: skip
COMPARED: Mapping[type, Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge,
    ast.Eq: operator.eq, ast.NotEq: operator.ne,
}  # fmt: skip


def is_code(value: Any) -> TypeGuard[ast.expr]:
    """Whether a value is an expression, and so not known."""
    return isinstance(value, ast.expr)


def is_number(value: Any) -> bool:
    """Whether a value is a number, known or not."""
    return isinstance(value, ast.expr | bool | int | float | np.generic)


def name_of(name: str) -> ast.Name:
    """A variable, as it is read."""
    return ast.Name(name, ast.Load())


def node(value: Any) -> ast.expr:
    """A number as an expression; raises ParameterError for what is none."""
    if isinstance(value, ast.expr):
        return value
    if isinstance(value, np.generic):
        value = value.item()
    if not isinstance(value, bool | int | float):
        raise ParameterError(f"a kernel's {value!r:.60} is no number")
    return ast.Constant(value)


def flat(shape: Sequence[int], index: Sequence[Any]) -> Any:
    """The place of an element in the flat array."""
    found: Any = 0
    for size, i in zip(shape, index, strict=True):
        found = combined(ast.Add, combined(ast.Mult, found, size), i)
    return found


def combined(op: type[ast.operator], a: Any, b: Any) -> Any:
    """Two numbers under an operator; what a 0, 1 or -1 makes of the other is written as that."""
    if not is_code(a) and not is_code(b):
        return BINARY[op](a, b)
    simple = _SIMPLE.get(op)
    found = None if simple is None else simple(a, b)
    return ast.BinOp(node(a), op(), node(b)) if found is None else found


def _is(value: Any, number: int) -> bool:
    return not is_code(value) and not isinstance(value, bool) and bool(value == number)


def _sum(a: Any, b: Any) -> Any:
    return b if _is(a, 0) else a if _is(b, 0) else None


def _difference(a: Any, b: Any) -> Any:
    return ast.UnaryOp(ast.USub(), b) if _is(a, 0) else a if _is(b, 0) else None


def _product(a: Any, b: Any) -> Any:
    if _is(a, -1):
        return ast.UnaryOp(ast.USub(), b)
    return b if _is(a, 1) else a if _is(b, 1) else None


_SIMPLE: Mapping[type, Callable[[Any, Any], Any]] = {
    ast.Add: _sum, ast.Sub: _difference, ast.Mult: _product,
}  # fmt: skip


def chosen(test: Any, yes: Any, no: Any) -> Any:
    """One of two numbers."""
    if not is_code(test):
        return yes if test else no
    return ast.IfExp(test, node(yes), node(no))


def all_of(tests: Sequence[Any], op: ast.boolop) -> Any:
    """Tests joined by `and` or `or`."""
    every = isinstance(op, ast.And)
    left: list[ast.expr] = []
    for test in tests:
        if is_code(test):
            left.append(test)
        elif bool(test) != every:
            return ast.BoolOp(op, [*left, ast.Constant(bool(test))]) if left else bool(test)
    if not left:
        return every
    return left[0] if len(left) == 1 else ast.BoolOp(op, left)


def compared(op: ast.cmpop, a: Any, b: Any) -> Any:
    """A comparison of two numbers."""
    if is_code(a) or is_code(b):
        return ast.Compare(node(a), [op], [node(b)])
    return bool(COMPARED[type(op)](a, b))


def negated(op: ast.unaryop, value: Any) -> Any:
    """A number with the other sign, or a test the other way: of a mask, a test here, `~` is `not`."""
    if isinstance(op, ast.USub):
        return ast.UnaryOp(ast.USub(), value) if is_code(value) else -value
    return ast.UnaryOp(ast.Not(), value) if is_code(value) else not value
