"""Which parameters a section of a netlist can use, and the values of the words that use them.

A section uses its own parameters first, then those of the section that calls it, and so on up to the top
level, as ngspice does. As in SPICE, a parameter may be used before the card that defines it. So a definition
waits until everything that it needs has a value; this is done by a loop, without recursion.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, field

from netlists.read.card import Card, ForeignError, shown
from netlists.read.expression.arithmetic import Expression, ExpressionError, ForeignValueError, Linear
from netlists.read.expression.expression import Functions, bare, linear_of, number_of, parse
from netlists.read.limits import Limits
from netlists.read.note import Notes
from netlists.read.number import MIL_OF_EXPRESSION, read_number

_AGAIN = 8  # how much faster a parsed text is evaluated than read
_A_CARD = 40  # characters of expressions that a card may have on average, beyond the limit
_POWERS = re.compile(r"\b(?:pow|pwr)\s*\(")
_MIL = re.compile(r"[0-9.]mil")
IDENTIFIER = re.compile(r"[a-z_][a-z0-9_.]*")


@dataclass(frozen=True, slots=True)
class Condition:
    """A condition of `.if` or `.elseif`: its `text`, its card, and whether it is to hold or to fail."""

    text: str
    card: Card
    holds: bool = True


Definition = tuple[str, Card]  # text of the value, and where it stands


@dataclass(slots=True)
class Expressions:
    """The expressions of one netlist; a text that occurs again is not parsed again.

    limits: how much arithmetic the netlist may have. cards: number of the netlist's cards: a longer netlist
    may have more arithmetic. read: characters so far; a text that was parsed before counts an eighth.
    functions: the netlist's own functions. parsed: the parsed expression by its text, None until the text has
    come a second time.
    """

    limits: Limits
    cards: int = 0
    read: int = 0
    functions: Functions = field(default_factory=Functions)
    parsed: dict[str, Expression | None] = field(default_factory=dict)  # None until its second time

    def get(self, text: str) -> Expression:
        """Return the parsed expression of `text`.

        Raises
        ------
        ExpressionError
            The text is no expression, or all expressions of the netlist together are too long.
        """
        found = self.parsed.get(text)
        self.read += len(text) if found is None else len(text) // _AGAIN + 1
        most = max(self.limits.arithmetic, _A_CARD * self.cards)
        if self.read > most:
            raise ExpressionError(f"more than {most} characters of expressions, the limit; simplify them")
        if found is None:
            found = parse(text, self.limits, self.functions)
            self.parsed[text] = found if text in self.parsed else None
        return found


@dataclass(slots=True)
class Scope:
    """The parameters of one section of a netlist, with their values.

    Attributes
    ----------
    limits : Limits
        How much arithmetic is allowed.
    parent : Scope or None
        The scope of the section that calls this one; None for the top level.
    values : dict of str to float
        Value of each parameter by name, in the SI unit of what it is used for.
    expressions : Expressions or None
        The parsed expressions of the netlist: those of the parent unless given.
    absent : set of str
        Parameters of this section that have a value in ngspice alone.
    section : object
        The section that it is the scope of; None for the top level.
    """

    limits: Limits
    parent: Scope | None = None
    values: dict[str, float] = field(default_factory=dict)
    expressions: Expressions | None = None  # of the netlist: the parent's unless given
    absent: set[str] = field(default_factory=set)
    section: object = None

    def __post_init__(self) -> None:
        """Share the expressions of the parent."""
        if self.expressions is None:
            self.expressions = Expressions(self.limits) if self.parent is None else self.parent.expressions

    def _parsed(self, text: str) -> Expression:
        expressions = self.expressions or Expressions(self.limits)
        return expressions.get(bare(text))

    def lookup(self, name: str) -> float | None:
        """Return the value of the parameter `name`, here or in the parent; None where there is none.

        Raises `ForeignValueError` for a parameter that has a value in ngspice alone.
        """
        value = self.values.get(name)
        if name in self.absent:
            raise ForeignValueError(f"{name[:40]}: a parameter with a value in ngspice alone; run it there")
        return self.parent.lookup(name) if value is None and self.parent is not None else value

    def of(self, section: object) -> Scope:
        """Return the scope of a section that this one stands in or is called by; the top level's if none."""
        each = self
        while each.parent is not None and each.section is not section:
            each = each.parent
        return each

    def inherited(self, names: Set[str]) -> tuple[tuple[str, float | None], ...]:
        """Values of those of `names` that this scope has from below the top level, in order of their names.

        None for one that has a value in ngspice alone.
        """
        found: dict[str, float | None] = {}
        each = self
        while each.parent is not None:
            found = {**each.values, **dict.fromkeys(each.absent), **found}
            each = each.parent
        return tuple(sorted((n, v) for n, v in found.items() if n in names))

    def number(self, card: Card, what: str, word: str) -> float:
        """Return the finite value of a word: a number, a parameter, or an expression in braces or quotes.

        Parameters
        ----------
        card
            The card that the word is of, for an error's place.
        what
            What the word is of it, for an error's text.
        word
            The word.

        Raises
        ------
        DataError
            The word has no value, or one that is not finite.
        """
        return self._number(card, what, word, read_number(word))

    def parameter(self, card: Card, what: str, word: str) -> float:
        """Return the finite value of a word that a parameter gets, as `number` does but for `mil`."""
        return self._number(card, what, word, read_number(word, MIL_OF_EXPRESSION))

    def _number(self, card: Card, what: str, word: str, value: float | None) -> float:
        if value is None:
            try:
                value = number_of(self._parsed(word), self.lookup)
            except ForeignValueError as error:
                raise card.foreign(f"{what}: {shown(word)}: {error}") from None
            except ExpressionError as error:
                raise card.error(f"{what}: {shown(word)}: {error}") from None
        if not abs(value) < float("inf"):
            raise card.error(f"{what}: {shown(word)}, must be finite; write a smaller number")
        return value

    def linear(self, card: Card, what: str, text: str) -> Linear:
        """Return the value of an expression that may be linear in node voltages.

        `card` and `what` are those of `number`, for an error's place and text. Raises `DataError` where
        `text` is no expression, or its value is not linear and finite.
        """
        if _POWERS.search(text.lower()):
            raise card.foreign(
                f"{what}: pow() or pwr(), which ngspice takes otherwise in a B source; write ^"
            )
        if _MIL.search(text.lower()):
            raise card.foreign(f"{what}: mil in a B source, which ngspice takes in two ways; write it in m")
        try:
            return linear_of(self._parsed(text), self.lookup)
        except ForeignValueError as error:
            raise card.foreign(f"{what}: {error}") from None
        except ExpressionError as error:
            raise card.error(f"{what}: {error}") from None

    def holds(self, conditions: Iterable[Condition]) -> bool:
        """Whether all conditions of `.if` cards are as they must be, in the order in which they stand."""
        return all(bool(self.number(c.card, c.card.name(), c.text)) == c.holds for c in conditions)

    def define(self, definitions: Mapping[str, Definition], notes: Notes | None = None) -> None:
        """Give parameters their values, in the order in which they need one another.

        `definitions` has the text and the card of each parameter by its name. A parameter that has a value
        already keeps it. `notes` takes those that have a value in ngspice alone.

        Raises
        ------
        DataError
            A parameter is defined by itself, or has no finite value.
        """
        waiting = {name: d for name, d in definitions.items() if name not in self.values}
        for name in list(waiting):
            self._define(name, waiting, notes or Notes())

    def _needed(self, text: str) -> list[str]:
        """Names that a text uses, those of the functions that it calls with it."""
        names = dict.fromkeys(IDENTIFIER.findall(text))
        known = self.expressions.functions.known if self.expressions else {}
        waiting = [n for n in names if n in known]
        while waiting:
            inner = [n for n in IDENTIFIER.findall(known[waiting.pop()].text) if n not in names]
            names |= dict.fromkeys(inner)
            waiting += [n for n in inner if n in known]
        return list(names)

    def _define(self, wanted: str, waiting: dict[str, Definition], notes: Notes) -> None:
        stack = [wanted] if wanted in waiting else []
        begun: set[str] = set()
        while stack:
            name = stack[-1]
            text, card = waiting.get(name, ("", None))
            if card is None:
                stack.pop()
                continue
            needed = dict.fromkeys(n for n in self._needed(text) if n in waiting and name not in begun)
            if any(n in begun or n == name for n in needed):
                raise card.error(f".param {shown(name)}: defined by itself; break the cycle")
            begun.add(name)
            if needed:
                stack += needed
                continue
            try:
                self.values[name] = self.parameter(card, f".param {shown(name)}", text)
            except ForeignError as error:
                notes.keep(card, error)
                self.absent.add(name)
            del waiting[name]
            stack.pop()
