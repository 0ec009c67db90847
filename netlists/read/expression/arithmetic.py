"""What the arithmetic of a netlist is made of: numbers, sums of node voltages, and functions of them.

An expression that has been parsed is a function. It takes a lookup, which gives a parameter's value by name,
and returns the expression's value. A value is a number, or linear in node voltages: `c + sum of g v(node)`.
What is not linear is refused where it arises.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

_NODE = re.compile(r"[^\s(),]+")
_MOST_NODES = 64  # of a sum; ours: a source has two, and sums of more would take the square of their number
FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "abs": (1, abs), "acos": (1, math.acos), "acosh": (1, math.acosh), "arctan": (1, math.atan),
    "asin": (1, math.asin), "asinh": (1, math.asinh), "atan": (1, math.atan), "atanh": (1, math.atanh),
    "ceil": (1, math.ceil), "cos": (1, math.cos), "cosh": (1, math.cosh), "exp": (1, math.exp),
    "floor": (1, math.floor), "int": (1, math.trunc), "ln": (1, math.log), "log": (1, math.log),
    "log10": (1, math.log10), "max": (2, max), "min": (2, min), "nint": (1, round), "pow": (2, math.pow),
    "pwr": (2, lambda x, y: math.pow(abs(x), y)), "sgn": (1, lambda x: (x > 0) - (x < 0)),
    "sin": (1, math.sin), "sinh": (1, math.sinh), "sqr": (1, lambda x: x * x), "sqrt": (1, math.sqrt),
    "tan": (1, math.tan), "tanh": (1, math.tanh), "ternary_fcn": (3, lambda c, x, y: x if c else y),
    "u": (1, lambda x: float(x > 0)), "uramp": (1, lambda x: max(x, 0.0)),
}  # fmt: skip
_CONSTANTS = {"pi": math.pi, "e": math.e, "true": 1.0, "false": 0.0}

# what ngspice has beside: of a run, or drawn at random
FOREIGN_NAMES = {"time", "temper", "hertz"}
FOREIGN_FUNCTIONS = {
    "agauss", "aunif", "ddt", "delay", "gauss", "i", "idt", "if", "limit", "pwl", "sdt",
    "stp", "table", "u2", "unif",
}  # fmt: skip

Lookup = Callable[[str], "float | Linear | None"]


class ExpressionError(ValueError):
    """Says what is wrong with an expression; the caller adds the place in the file."""


class ForeignValueError(ExpressionError):
    """Says that an expression has a value in ngspice alone: of a current, of time, or drawn at random."""


@dataclass(frozen=True, slots=True)
class Function:
    """A function of a netlist's own: the names of its `arguments`, and the `text` of its value."""

    arguments: tuple[str, ...]
    text: str


@dataclass(frozen=True, slots=True)
class Linear:
    """A value that is linear in node voltages: `constant + sum of slopes[node] v(node)`.

    constant: the part without voltages, in the unit of the whole expression. slopes: factor of the voltage of
    each node, per V.
    """

    constant: float
    slopes: Mapping[str, float] = field(default_factory=dict)


Value = float | Linear  # a number, or what has node voltages in it
Expression = Callable[[Lookup], Value]  # a parsed text; raises `ExpressionError`
Operator = Callable[[Value, Value], Value]


VOLTAGE = "v(): must name one or two nodes, as in v(out) or v(a,b)"


def constant(value: Value) -> Expression:
    """Make the expression that is always `value`."""

    def same(lookup: Lookup) -> Value:
        return value

    return same


def voltage(inside: str) -> Expression:
    """Make the expression of a node voltage, `v(node)`, or of a difference of two, `v(node, node)`.

    `inside` is the text between the brackets. Nodes are no expressions: a name may have any characters in it.

    Raises
    ------
    ExpressionError
        `inside` does not name one or two nodes.
    """
    nodes = [part.strip() for part in inside.split(",")]
    if not (len(nodes) <= 2 and all(_NODE.fullmatch(node) for node in nodes)):
        raise ExpressionError(VOLTAGE)
    found = Linear(0.0, {nodes[0]: 1.0})
    if len(nodes) == 2:
        found = _sum(found, Linear(0.0, {nodes[1]: 1.0}), -1.0)
    return constant(found)


def parameter(name: str) -> Expression:
    """Make the expression that is the value of the parameter `name`, or of a constant such as `pi`.

    The expression raises `ExpressionError` where its lookup does not know the name.
    """

    def value(lookup: Lookup) -> Value:
        found = lookup(name)
        if found is None:
            found = _CONSTANTS.get(name)
        if found is None and name in FOREIGN_NAMES:
            raise ForeignValueError(
                f"{name}: changes in a run, and a value here is one number; run it in ngspice"
            )
        if found is None:
            raise ExpressionError(f"{name[:40]}: unknown parameter; define it in a .param card")
        return found

    return value


def choice(condition: Expression, yes: Expression, no: Expression) -> Expression:
    """Make the expression `condition ? yes : no`; both `yes` and `no` must have a value."""

    def value(lookup: Lookup) -> Value:
        pair = yes(lookup), no(lookup)
        return pair[0] if _number(condition(lookup)) else pair[1]

    return value


def joined(first: Expression, operands: list[tuple[Operator, Expression]]) -> Expression:
    """Make the expression of operands that operators of one rank join, applied from left to right.

    Parameters
    ----------
    first
        The leftmost operand.
    operands
        Each operator with the operand on its right.
    """

    def value(lookup: Lookup) -> Value:
        found = first(lookup)
        for apply, operand in operands:
            found = apply(found, operand(lookup))
        return found

    return value


def signed(operand: Expression, signs: list[str]) -> Expression:
    """Make the expression of an `operand` with `signs` (`-` or `!`) before it, the one next to it first."""

    def value(lookup: Lookup) -> Value:
        found = operand(lookup)
        for sign in signs:
            found = _product(found, -1.0) if sign == "-" else float(not _number(found))
        return found

    return value


def applied(name: str, function: Callable[..., float], given: list[Expression]) -> Expression:
    """Make the expression of a `function` of numbers, applied to the values of `given`.

    `name` is the function's name for an error's text. The expression raises `ExpressionError` where an
    argument is outside the function's range.
    """

    def value(lookup: Lookup) -> Value:
        return _call(name, function, tuple(_number(each(lookup)) for each in given))

    return value


def called(body: Expression, names: tuple[str, ...], given: list[Expression]) -> Expression:
    """Make the expression of a netlist's own function: its `body` with the values of `given` by `names`."""

    def value(lookup: Lookup) -> Value:
        values = {name: each(lookup) for name, each in zip(names, given, strict=True)}

        def inside(name: str) -> float | Linear | None:
            return values[name] if name in values else lookup(name)

        return body(inside)

    return value


def _number(value: Value) -> float:
    if isinstance(value, Linear):
        if value.slopes:
            raise ForeignValueError(
                "not linear in one voltage difference; write M, R, C and G elements for it"
            )
        return value.constant
    return value


def _sum(a: Value, b: Value, sign: float) -> Linear:
    a, b = (x if isinstance(x, Linear) else Linear(x) for x in (a, b))
    slopes = dict(a.slopes)
    for node, slope in b.slopes.items():
        slopes[node] = slopes.get(node, 0.0) + sign * slope
    if len(slopes) > _MOST_NODES:
        raise ExpressionError(f"more than {_MOST_NODES} node voltages in a sum, the limit; part it")
    return Linear(a.constant + sign * b.constant, {n: slope for n, slope in slopes.items() if slope != 0.0})


def _plus(a: Value, b: Value) -> Value:
    return _sum(a, b, 1.0) if isinstance(a, Linear) or isinstance(b, Linear) else a + b


def _minus(a: Value, b: Value) -> Value:
    return _sum(a, b, -1.0) if isinstance(a, Linear) or isinstance(b, Linear) else a - b


def _product(a: Value, b: Value) -> Value:
    if isinstance(a, Linear) and a.slopes:
        factor = _number(b)
        return Linear(a.constant * factor, {node: slope * factor for node, slope in a.slopes.items()})
    return _product(b, a) if isinstance(b, Linear) and b.slopes else _number(a) * _number(b)


def _quotient(a: Value, b: Value) -> Value:
    divisor = _divisor(b)
    if isinstance(a, Linear):
        return Linear(a.constant / divisor, {node: slope / divisor for node, slope in a.slopes.items()})
    return a / divisor


def _remainder(a: Value, b: Value) -> Value:
    return _call("%", math.fmod, (_number(a), _divisor(b)))


def _divisor(value: Value) -> float:
    divisor = _number(value)
    if divisor == 0.0:
        raise ExpressionError("a division by zero; correct it")
    return divisor


def _comparison(compare: Callable[[float, float], bool]) -> Operator:
    return lambda a, b: float(compare(_number(a), _number(b)))


def _call(name: str, function: Callable[..., float], given: tuple[float, ...]) -> float:
    try:
        return float(function(*given))
    except (ValueError, OverflowError):
        values = ", ".join(f"{x:g}" for x in given)
        raise ExpressionError(f"{name}({values}): outside the function's range; correct it") from None


OPERATORS: dict[str, tuple[int, Operator]] = {  # rank, from the loosest, and what it does
    "||": (0, _comparison(lambda a, b: bool(a) or bool(b))),
    "&&": (1, _comparison(lambda a, b: bool(a) and bool(b))),
    "<": (2, _comparison(operator.lt)), "<=": (2, _comparison(operator.le)),
    ">": (2, _comparison(operator.gt)), ">=": (2, _comparison(operator.ge)),
    "==": (2, _comparison(operator.eq)), "!=": (2, _comparison(operator.ne)),
    "+": (3, _plus), "-": (3, _minus), "*": (4, _product), "/": (4, _quotient), "%": (4, _remainder),
}  # fmt: skip
