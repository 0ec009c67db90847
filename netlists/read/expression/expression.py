"""A parser for the arithmetic of a netlist: of `.param` cards, of element values and of B sources.

The text is parsed by recursive descent and never handed to Python's own `eval`. This is its grammar:

    expression := or [ ? expression : expression ]
    or := and { || and }      and := comparison { && comparison }
    comparison := sum { (< <= > >= == !=) sum }
    sum := product { (+ -) product }
    product := unary { (* / %) unary }
    unary := { + - ! } power        power := atom { (^ **) { + - ! } atom }
    atom := number | name | function ( expression , ... ) | v ( node [ , node ] ) | ( expression )

A value is a number, or linear in node voltages: `c + sum of g v(node)`. What is not linear is refused where
it arises. As in ngspice `log` is the natural logarithm, and `x^y` is |x|^y, from the left. The length of a
text and the depth of its brackets are limited. A text is parsed once, into a function of the parameters'
values.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from netlists.read.expression.arithmetic import (
    FOREIGN_FUNCTIONS,
    FUNCTIONS,
    OPERATORS,
    VOLTAGE,
    Expression,
    ExpressionError,
    ForeignValueError,
    Function,
    Linear,
    Lookup,
    applied,
    called,
    choice,
    constant,
    joined,
    parameter,
    signed,
    voltage,
)
from netlists.read.limits import DEFAULT_LIMITS, Limits
from netlists.read.number import MIL_OF_EXPRESSION, NUMBER, number_value

_TOKEN = re.compile(
    rf"\s*(?:(?P<number>{NUMBER.pattern})|v\s*\((?P<voltage>[^()]*)\)|(?P<name>[a-z_][a-z0-9_.]*)"
    r"|(?P<mark>\*\*|\|\||&&|[<>=!]=|[-+*/%^<>!?:(),]))",
    re.IGNORECASE,
)


class _Token(NamedTuple):
    kind: str  # number, voltage, name or mark; empty at the end
    word: str
    value: float = 0.0


_END = _Token("", "")


def number_of(expression: Expression, lookup: Lookup) -> float:
    """Evaluate a parsed expression whose value must be a finite number.

    `expression` is what `parse` gave; `lookup` gives a parameter's value by name, and None for one that it
    does not know. Raises `ExpressionError` where a name is unknown, the value has a node voltage in it, or
    it is not finite.
    """
    found = expression(lookup)
    if isinstance(found, Linear):
        if found.slopes:
            raise ForeignValueError("a node voltage where a number is needed; write a number or a parameter")
        found = found.constant
    return _finite(found)


def linear_of(expression: Expression, lookup: Lookup) -> Linear:
    """Evaluate a parsed expression whose value may be linear in node voltages.

    `expression` and `lookup` are those of `number_of`. Raises `ExpressionError` where a name is unknown, the
    value is not linear, or a number in it is not finite.
    """
    found = expression(lookup)
    linear = found if isinstance(found, Linear) else Linear(found)
    for number in (linear.constant, *linear.slopes.values()):
        _finite(number)
    return linear


@dataclass(slots=True)
class Functions:
    """The functions of a netlist's own (`.func`); each is parsed once, where it is first called.

    `known`: by name. `calls`: how often they have been called in texts so far.
    """

    known: Mapping[str, Function] = field(default_factory=dict)
    parsed: dict[str, tuple[Expression, int]] = field(
        default_factory=dict
    )  # and its calls, those inside counted
    open: list[str] = field(default_factory=list)

    def body(self, name: str, limits: Limits) -> tuple[Expression, int]:
        """Return the parsed value of a function, and how many calls it makes.

        Raises `ExpressionError` for one that calls itself.
        """
        if name in self.open:
            raise ExpressionError(f"{name[:40]}(): a function that calls itself; break the cycle")
        if name not in self.parsed:
            if len(self.open) == limits.expression_depth:
                raise ExpressionError(
                    f"more than {limits.expression_depth} functions in one another; shorten it"
                )
            self.open.append(name)
            try:
                parser = _Parser(_tokens(bare(self.known[name].text)), limits, self)
                found = parser.expression()
                parser.expect_end()
            finally:
                self.open.pop()
            self.parsed[name] = found, parser.calls
        return self.parsed[name]


def _power(base: float, exponent: float) -> float:
    return math.pow(abs(base), exponent)


def bare(word: str) -> str:
    """Expression inside braces or quotes."""
    text = word.strip()
    while len(text) > 1 and text[0] + text[-1] in {"{}", "''", '""'}:
        text = text[1:-1].strip()
    return text


def parse(text: str, limits: Limits = DEFAULT_LIMITS, functions: Functions | None = None) -> Expression:
    """Parse a text into an expression, which is a function of the parameters' values.

    Parameters
    ----------
    text
        The text, without the braces or quotes around it.
    limits
        How long the text may be, and how deep its brackets.
    functions
        The netlist's own functions; none unless given.

    Raises
    ------
    ExpressionError
        The text is no expression, or is too long or too deep.
    """
    if len(text) > limits.expression:
        raise ExpressionError(
            f"{len(text)} characters, an expression may have {limits.expression}; shorten it"
        )
    parser = _Parser(_tokens(text.strip()), limits, functions or Functions())
    found = parser.expression()
    parser.expect_end()
    return found


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise ExpressionError("its value is not finite; correct it")
    return value


def _tokens(text: str) -> list[_Token]:
    found, end = [], 0
    text = text.replace("{", "(").replace("}", ")")  # braces in an expression are brackets
    for match in _TOKEN.finditer(text):
        if match.start() != end:
            break
        end, kind = match.end(), match.lastgroup or ""
        if kind == "number":
            found.append(_Token(kind, match[kind].lower(), number_value(match, MIL_OF_EXPRESSION)))
        else:
            found.append(_Token(kind, match[kind].lower()))
    if end != len(text):
        rest = text[end : end + 20]
        raise ExpressionError(f"{rest!r} is no part of an expression; use numbers, names and + - * / ^ ( )")
    found.append(_END)
    return found


class _Parser:
    """One pass over the tokens; a run of operators of one rank is one function, whatever its length."""

    def __init__(self, tokens: list[_Token], limits: Limits, functions: Functions) -> None:
        self.tokens, self.limits, self.functions = tokens, limits, functions
        self.position = self.depth = self.calls = 0
        self.token = tokens[0]

    def advance(self) -> None:
        self.position += 1
        self.token = self.tokens[self.position]

    def take(self, *marks: str) -> str:
        """The mark at hand if it is one of `marks`, taken; else empty."""
        kind, word, _ = self.token
        if kind != "mark" or word not in marks:
            return ""
        self.advance()
        return word

    def expect(self, mark: str) -> None:
        if not self.take(mark):
            word = self.token.word or "the end"
            raise ExpressionError(f"{word[:20]} where {mark} is needed; correct the brackets")

    def expect_end(self) -> None:
        if self.token.kind:
            raise ExpressionError(
                f"{self.token.word[:20]} after a whole expression; put an operator between them"
            )

    def deeper(self, what: str, remedy: str) -> None:
        self.depth += 1
        if self.depth > self.limits.expression_depth:
            raise ExpressionError(f"more than {self.limits.expression_depth} {what}; {remedy}")

    def expression(self) -> Expression:
        self.deeper("brackets in one another", "use .param for its parts")
        found = self.operation(0)
        if self.take("?"):
            yes = self.expression()
            self.expect(":")
            found = choice(found, yes, self.expression())
        self.depth -= 1
        return found

    def operation(self, least: int) -> Expression:
        """Operands joined by operators of rank `least` and above."""
        left = self.unary()
        while (rank := self.rank()) >= least:
            operands = []
            while self.rank() == rank:
                apply = OPERATORS[self.token.word][1]
                self.advance()
                operands.append((apply, self.operation(rank + 1)))
            left = joined(left, operands)
        return left

    def rank(self) -> int:
        """Rank of the operator at hand, -1 where there is none."""
        kind, word, _ = self.token
        return OPERATORS[word][0] if kind == "mark" and word in OPERATORS else -1

    def unary(self) -> Expression:
        signs = []
        while mark := self.take("+", "-", "!"):
            signs.append(mark)
        value = self.power()
        return signed(value, [s for s in reversed(signs) if s != "+"]) if signs else value

    def power(self) -> Expression:
        found, powers = self.atom(), 0
        while self.take("^", "**"):
            powers += 1  # from the left, each a call around those before it
            self.deeper("powers of powers", "shorten it")
            found = applied("^", _power, [found, self.signed_atom()])
        self.depth -= powers
        return found

    def signed_atom(self) -> Expression:
        """An atom with its signs, which bind closer than a power behind it."""
        signs = []
        while mark := self.take("+", "-", "!"):
            signs.append(mark)
        value = self.atom()
        return signed(value, [s for s in reversed(signs) if s != "+"]) if signs else value

    def atom(self) -> Expression:
        kind, word, value = self.token
        if self.take("("):
            inside = self.expression()
            self.expect(")")
            return inside
        if kind in {"", "mark"}:
            raise ExpressionError(f"{word or 'the end'} where a value is needed; complete the expression")
        self.advance()
        if kind == "number":
            return constant(value)
        if kind == "voltage":
            return voltage(word)
        return self.function(word) if self.take("(") else parameter(word)

    def function(self, name: str) -> Expression:
        if name == "v":
            raise ExpressionError(VOLTAGE)
        own = self.functions.known.get(name)
        if own is None and name in FOREIGN_FUNCTIONS:
            raise ForeignValueError(f"{name}(): a function of ngspice alone; run it there")
        if own is None and name not in FUNCTIONS:
            known = ", ".join(sorted(FUNCTIONS))
            raise ExpressionError(f"{name[:40]}(): unknown function; known are {known}")
        count = FUNCTIONS[name][0] if own is None else len(own.arguments)
        given = [] if count == 0 and self.token.word == ")" else [self.expression()]
        while self.take(","):
            given.append(self.expression())
        self.expect(")")
        if len(given) != count:
            raise ExpressionError(f"{name}(): {len(given)} arguments, must be {count}")
        if own is None:
            return applied(name, FUNCTIONS[name][1], given)
        body, calls = self.functions.body(name, self.limits)
        self.calls += 1 + calls
        if self.calls > self.limits.function_calls:
            raise ExpressionError(
                f"more than {self.limits.function_calls} calls of .func functions; simplify it"
            )
        return called(body, own.arguments, given)
