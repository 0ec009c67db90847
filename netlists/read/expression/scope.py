"""Parameters in reach of a section, and the values of words that use them.

A parameter may be used before the card that defines it, as in SPICE: definitions wait until what they need
has its value, without recursion. A section sees its own parameters, then those of the top level.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from netlists.read.card import Card, shown
from netlists.read.expression.arithmetic import Expression, ExpressionError, Linear
from netlists.read.expression.expression import linear_of, number_of, parse
from netlists.read.limits import Limits
from netlists.read.number import read_number

_AGAIN = 8  # how much faster a parsed text is evaluated than read
_A_CARD = 40  # characters of expressions that a card may have on average, beyond the limit
_IDENTIFIER = re.compile(r"[a-z_][a-z0-9_.]*")
Definition = tuple[str, Card]  # text of the value, and where it stands


@dataclass(slots=True)
class Expressions:
    """Expressions of a netlist of `cards` cards, each text parsed once; `read`: characters so far."""

    limits: Limits
    cards: int = 0
    read: int = 0
    parsed: dict[str, Expression | None] = field(default_factory=dict)  # None until its second time

    def get(self, text: str) -> Expression:
        """Parsed text; raises `ExpressionError`, also where all expressions together are too long."""
        found = self.parsed.get(text)
        self.read += len(text) if found is None else len(text) // _AGAIN + 1
        most = max(self.limits.arithmetic, _A_CARD * self.cards)
        if self.read > most:
            raise ExpressionError(f"more than {most} characters of expressions, the limit; simplify them")
        if found is None:
            found = parse(text, self.limits)
            self.parsed[text] = found if text in self.parsed else None
        return found


@dataclass(slots=True)
class Scope:
    """Values by name; `parent` is the top level's, None for the top level itself."""

    limits: Limits
    parent: Scope | None = None
    values: dict[str, float] = field(default_factory=dict)
    expressions: Expressions | None = None  # of the netlist: the parent's unless given

    def __post_init__(self) -> None:
        """Share the expressions of the parent."""
        if self.expressions is None:
            self.expressions = Expressions(self.limits) if self.parent is None else self.parent.expressions

    def _parsed(self, text: str) -> Expression:
        expressions = self.expressions or Expressions(self.limits)
        return expressions.get(_bare(text))

    def lookup(self, name: str) -> float | None:
        """Value of a parameter, None where there is none."""
        value = self.values.get(name)
        return self.parent.lookup(name) if value is None and self.parent is not None else value

    def number(self, card: Card, what: str, word: str) -> float:
        """Finite value of a word: a number, a parameter, or an expression in braces or quotes."""
        value = read_number(word)
        if value is None:
            try:
                value = number_of(self._parsed(word), self.lookup)
            except ExpressionError as error:
                raise card.error(f"{what}: {shown(word)}: {error}") from None
        if not abs(value) < float("inf"):
            raise card.error(f"{what}: {shown(word)}, must be finite; write a smaller number")
        return value

    def linear(self, card: Card, what: str, text: str) -> Linear:
        """Value of an expression that may be linear in node voltages."""
        try:
            return linear_of(self._parsed(text), self.lookup)
        except ExpressionError as error:
            raise card.error(f"{what}: {error}") from None

    def define(self, definitions: Mapping[str, Definition]) -> None:
        """Evaluate definitions in the order that they need; raises `DataError` for a cycle among them."""
        waiting = {name: d for name, d in definitions.items() if name not in self.values}
        for name in list(waiting):
            self._define(name, waiting)

    def _define(self, wanted: str, waiting: dict[str, Definition]) -> None:
        stack = [wanted] if wanted in waiting else []
        begun: set[str] = set()
        while stack:
            name = stack[-1]
            text, card = waiting.get(name, ("", None))
            if card is None:
                stack.pop()
                continue
            needed = dict.fromkeys(n for n in _IDENTIFIER.findall(text) if n in waiting and name not in begun)
            if any(n in begun or n == name for n in needed):
                raise card.error(f".param {shown(name)}: defined by itself; break the cycle")
            begun.add(name)
            if needed:
                stack += needed
                continue
            self.values[name] = self.number(card, f".param {shown(name)}", text)
            del waiting[name]
            stack.pop()


def _bare(word: str) -> str:
    """Expression inside braces or quotes."""
    text = word.strip()
    while len(text) > 1 and text[0] + text[-1] in {"{}", "''", '""'}:
        text = text[1:-1].strip()
    return text
