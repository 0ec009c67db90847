"""Arithmetic of `.param`, of element values and of B sources: recursive descent, never Python's own.

    expression := or [ ? expression : expression ]
    or := and { || and }      and := comparison { && comparison }
    comparison := sum { (< <= > >= == !=) sum }
    sum := product { (+ -) product }
    product := unary { (* / %) unary }
    unary := { + - ! } power        power := atom [ (^ **) unary ]
    atom := number | name | function ( expression , ... ) | v ( node [ , node ] ) | ( expression )

A value is linear in node voltages, `c + sum of g v(node)`: what is not linear is refused where it arises.
`log` is natural, as in ngspice. Text is limited in length, brackets in depth.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from netlists.reader.limits import DEFAULT_LIMITS, Limits
from netlists.reader.number import NUMBER, number_value

_TOKEN = re.compile(
    rf"\s*(?:(?P<number>{NUMBER.pattern})|(?P<name>[a-z_][a-z0-9_.]*)|(?P<mark>\*\*|\|\||&&|[<>=!]=|[-+*/%^<>!?:(),]))",
    re.IGNORECASE,
)
_NODE = re.compile(r"\s*([^\s(),]+)\s*")
_COMPARISONS: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq,
    "!=": operator.ne,
}  # fmt: skip
_FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "abs": (1, abs), "acos": (1, math.acos), "asin": (1, math.asin), "atan": (1, math.atan),
    "ceil": (1, math.ceil), "cos": (1, math.cos), "cosh": (1, math.cosh), "exp": (1, math.exp),
    "floor": (1, math.floor), "int": (1, math.trunc), "ln": (1, math.log), "log": (1, math.log),
    "log10": (1, math.log10), "max": (2, max), "min": (2, min), "nint": (1, round), "pow": (2, math.pow),
    "pwr": (2, lambda x, y: math.copysign(math.pow(abs(x), y), x)), "sgn": (1, lambda x: (x > 0) - (x < 0)),
    "sin": (1, math.sin), "sinh": (1, math.sinh), "sqrt": (1, math.sqrt), "tan": (1, math.tan),
    "tanh": (1, math.tanh),
}  # fmt: skip
CONSTANTS = {"pi": math.pi, "e": math.e, "true": 1.0, "false": 0.0}

Lookup = Callable[[str], "float | None"]


class ExpressionError(ValueError):
    """What is wrong with an expression, without its place in a file."""


@dataclass(frozen=True, slots=True)
class Linear:
    """`constant + sum of slopes[node] v(node)`."""

    constant: float
    slopes: Mapping[str, float] = field(default_factory=dict)


def evaluate(text: str, lookup: Lookup, limits: Limits = DEFAULT_LIMITS) -> float:
    """Value of an expression without node voltages; `lookup` gives a parameter's value, None if unknown.

    Raises `ExpressionError`: not an expression, an unknown name, too long or deep, or not finite.
    """
    found = evaluate_linear(text, lookup, limits)
    if found.slopes:
        raise ExpressionError("a node voltage where a number is needed; write a number or a parameter")
    return found.constant


def evaluate_linear(text: str, lookup: Lookup, limits: Limits = DEFAULT_LIMITS) -> Linear:
    """Value of an expression that is linear in node voltages; errors as of `evaluate`."""
    if len(text) > limits.expression:
        raise ExpressionError(
            f"{len(text)} characters, an expression may have {limits.expression}; shorten it"
        )
    parser = _Parser(text, lookup, limits)
    found = parser.expression()
    parser.expect_end()
    if not all(map(math.isfinite, (found.constant, *found.slopes.values()))):
        raise ExpressionError("its value is not finite; correct it")
    return found


class _Parser:
    """One pass over the text: `position` is behind the word that `kind` and `word` hold."""

    def __init__(self, text: str, lookup: Lookup, limits: Limits) -> None:
        self.text, self.lookup, self.limits = text.strip(), lookup, limits
        self.position = self.depth = 0
        self.kind = self.word = ""
        self.value = 0.0
        self.advance()

    def advance(self) -> None:
        if self.position == len(self.text):
            self.kind = self.word = ""
            return
        match = _TOKEN.match(self.text, self.position)
        if match is None:
            rest = self.text[self.position : self.position + 20]
            raise ExpressionError(
                f"{rest!r} is no part of an expression; use numbers, names and + - * / ^ ( )"
            )
        self.position = match.end()
        self.kind = match.lastgroup or ""
        if match["number"] is not None:
            self.kind, self.value = "number", number_value(match)
        elif match["name"] is not None:
            self.kind = "name"
        else:
            self.kind = "mark"
        self.word = match.group().strip().lower()

    def take(self, *marks: str) -> str:
        """The mark at hand if it is one of `marks`, taken; else empty."""
        if self.kind != "mark" or self.word not in marks:
            return ""
        found = self.word
        self.advance()
        return found

    def expect(self, mark: str) -> None:
        if not self.take(mark):
            raise ExpressionError(f"{self.word or 'the end'} where {mark} is needed; correct the brackets")

    def expect_end(self) -> None:
        if self.kind:
            raise ExpressionError(f"{self.word[:20]} after a whole expression; put an operator between them")

    def expression(self) -> Linear:
        self.depth += 1
        if self.depth > self.limits.expression_depth:
            raise ExpressionError(
                f"more than {self.limits.expression_depth} brackets in one another; use .param for its parts"
            )
        condition = self.either()
        if self.take("?"):
            yes = self.expression()
            self.expect(":")
            no = self.expression()
            condition = yes if _number(condition) else no
        self.depth -= 1
        return condition

    def either(self) -> Linear:
        left = self.both()
        while self.take("||"):
            right = self.both()
            left = Linear(float(bool(_number(left)) or bool(_number(right))))
        return left

    def both(self) -> Linear:
        left = self.comparison()
        while self.take("&&"):
            right = self.comparison()
            left = Linear(float(bool(_number(left)) and bool(_number(right))))
        return left

    def comparison(self) -> Linear:
        left = self.sum()
        while mark := self.take(*_COMPARISONS):
            left = Linear(float(_COMPARISONS[mark](_number(left), _number(self.sum()))))
        return left

    def sum(self) -> Linear:
        left = self.product()
        while mark := self.take("+", "-"):
            left = _add(left, self.product(), 1.0 if mark == "+" else -1.0)
        return left

    def product(self) -> Linear:
        left = self.unary()
        while mark := self.take("*", "/", "%"):
            left = _multiply(left, self.unary(), mark)
        return left

    def unary(self) -> Linear:
        signs = []
        while mark := self.take("+", "-", "!"):
            signs.append(mark)
        value = self.power()
        for mark in reversed(signs):
            if mark == "-":
                value = _scale(value, -1.0)
            elif mark == "!":
                value = Linear(float(not _number(value)))
        return value

    def power(self) -> Linear:
        base = self.atom()
        if not self.take("^", "**"):
            return base
        self.depth += 1  # right-associative: a chain of powers is a depth
        if self.depth > self.limits.expression_depth:
            raise ExpressionError(f"more than {self.limits.expression_depth} powers of powers; shorten it")
        exponent = self.unary()
        self.depth -= 1
        return Linear(_call("pow", math.pow, (_number(base), _number(exponent))))

    def atom(self) -> Linear:
        kind, word, value = self.kind, self.word, self.value
        if self.take("("):
            inside = self.expression()
            self.expect(")")
            return inside
        if kind not in {"number", "name"}:
            raise ExpressionError(f"{word or 'the end'} where a value is needed; complete the expression")
        if kind == "name" and word == "v" and self.text[self.position :].lstrip().startswith("("):
            return self.voltage()
        self.advance()
        if kind == "number":
            return Linear(value)
        return self.function(word) if self.take("(") else self.parameter(word)

    def parameter(self, name: str) -> Linear:
        value = self.lookup(name)
        if value is None:
            value = CONSTANTS.get(name)
        if value is None:
            raise ExpressionError(f"{name[:40]}: unknown parameter; define it in a .param card")
        return Linear(value)

    def function(self, name: str) -> Linear:
        if name not in _FUNCTIONS:
            known = ", ".join(sorted(_FUNCTIONS))
            raise ExpressionError(f"{name[:40]}(): unknown function; known are {known}")
        count, function = _FUNCTIONS[name]
        given = [_number(self.expression())]
        while self.take(","):
            given.append(_number(self.expression()))
        self.expect(")")
        if len(given) != count:
            raise ExpressionError(f"{name}(): {len(given)} arguments, must be {count}")
        return Linear(_call(name, function, tuple(given)))

    def voltage(self) -> Linear:
        """`v(node)` or `v(node, node)`: nodes are not expressions, any characters may be in their names."""
        end = self.text.find(")", self.position)
        start = self.text.find("(", self.position) + 1
        nodes = [part.strip().lower() for part in self.text[start:end].split(",")] if end >= 0 else []
        if not (1 <= len(nodes) <= 2 and all(_NODE.fullmatch(node) for node in nodes)):
            raise ExpressionError("v(): must name one or two nodes, as in v(out) or v(a,b)")
        self.position = end + 1
        self.advance()
        one = Linear(0.0, {nodes[0]: 1.0})
        return one if len(nodes) == 1 else _add(one, Linear(0.0, {nodes[1]: 1.0}), -1.0)


def _number(value: Linear) -> float:
    if value.slopes:
        raise ExpressionError("not linear in one voltage difference")
    return value.constant


def _add(a: Linear, b: Linear, sign: float) -> Linear:
    constant = a.constant + sign * b.constant
    if not (a.slopes or b.slopes):
        return Linear(constant)
    slopes = dict(a.slopes)
    for node, slope in b.slopes.items():
        slopes[node] = slopes.get(node, 0.0) + sign * slope
    return Linear(constant, {node: slope for node, slope in slopes.items() if slope != 0.0})


def _scale(a: Linear, factor: float) -> Linear:
    return Linear(a.constant * factor, {node: slope * factor for node, slope in a.slopes.items()})


def _multiply(a: Linear, b: Linear, mark: str) -> Linear:
    if mark == "*":
        return _scale(b, a.constant) if not a.slopes else _scale(a, _number(b))
    divisor = _number(b)
    if divisor == 0.0:
        raise ExpressionError("a division by zero; correct it")
    if mark == "%":
        return Linear(_call("%", math.fmod, (_number(a), divisor)))
    return Linear(a.constant / divisor, {node: slope / divisor for node, slope in a.slopes.items()})


def _call(name: str, function: Callable[..., float], given: tuple[float, ...]) -> float:
    try:
        return float(function(*given))
    except (ValueError, OverflowError):
        values = ", ".join(f"{x:g}" for x in given)
        raise ExpressionError(f"{name}({values}): outside the function's range; correct it") from None
