"""Rules: in one object the sentence that states when a value agrees, its number, and the verdict.

A rule is made by a function named for its comparison, `at_least(0.9)` or `within_share(0.1)`. The number in
the sentence is put there from the rule, and the sentence must hold a word of the comparison, so that a rule
cannot say one thing and judge another:

    at_most(0.02, "at most {percent:g} % of full scale")

Fields of a sentence are `limit`, and `percent`, `milli` and `micro`, the limit in these units; the same names
with `of_` before them are the value that `within` is measured from. A value that is missing or is not a
number agrees with no rule. `unjudged` has no verdict.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from string import Formatter
from typing import Protocol

from circuits.errors import ParameterError

Value = float | str | None

_SCALES = {"": 1.0, "percent": 100.0, "milli": 1e3, "micro": 1e6}
_DIRECTIONS = {1: ("better", "more", "above"), -1: ("worse", "fewer", "below")}
_NUMBER = re.compile(r"[0-9]")


class Ends(Protocol):
    """An interval of confidence."""

    @property
    def low(self) -> float:
        """Lower end."""

    @property
    def high(self) -> float:
        """Upper end."""


class Estimated(Protocol):
    """A value with its interval of confidence."""

    @property
    def value(self) -> float:
        """The estimate itself."""

    @property
    def interval(self) -> Ends:
        """Where the true value is expected."""


@dataclass(frozen=True, slots=True)
class Measured:
    """A number that is judged, and what is shown of it where that is more than the number.

    `interval`: its interval of confidence, for rules about intervals. `p`: of the test that its rule asks
    for, that it differs from 0 by more than chance, or by less than a margin.

    value : the number itself.
    """

    value: float
    shown: Value
    interval: Ends | None = None
    p: float = math.nan


Judged = Value | Measured


@dataclass(frozen=True, slots=True)
class Rule:
    """When a value of ours agrees with a paper's.

    Made by the functions of this module; a rule of one's own gives a `test` of ours and the paper's value.

    Attributes
    ----------
    text : str
        The rule as a sentence.
    tolerance : float or None
        Its number, in the unit of the value or as a share or a factor of it; None where it has none.
    test : function or None
        Whether a value agrees with the paper's; None for a rule without a verdict.
    by_p : bool
        Whether it judges the p of a test, which is then one of a family (`system.verdict.family`).
    """

    text: str
    tolerance: float | None
    test: Callable[[Judged, Value], bool] | None = field(
        compare=False
    )  # rules that say the same are the same
    by_p: bool = False

    def holds(self, ours: Judged, paper: Value) -> bool | None:
        """Whether `ours` agrees with `paper` by this rule; None where the rule gives no verdict."""
        return None if self.test is None else bool(self.test(ours, paper))

    def __and__(self, other: Rule) -> Rule:
        """Both rules; the tolerance is that of the first."""

        def test(ours: Judged, paper: Value) -> bool:
            return bool(self.holds(ours, paper)) and bool(other.holds(ours, paper))

        return replace(self, text=f"{self.text}, {other.text}", test=test)

    def beside(self, remark: object) -> Rule:
        """The same rule with `remark` after its sentence."""
        return replace(self, text=f"{self.text}; {remark}")

    def unless(self, spoilt: bool, why: str) -> Rule:  # noqa: FBT001 - a condition, as in a sentence
        """The same rule, which does not hold where `spoilt`, and then says `why`."""
        return replace(self.beside(why), test=_never) if spoilt else self


def unjudged(text: str = "no rule") -> Rule:
    """No rule: the value is shown beside the paper's, without a verdict; `text` is what is said of it."""
    return Rule(text, None, None)


def at_least(limit: float | None = None, text: str | None = None) -> Rule:
    """Ours is a limit or more.

    `limit` is in the unit of the value; the paper's value unless given. `text` is the sentence.
    """
    return _compared(limit, text, ("at least", "or more"), lambda ours, bound: ours >= bound)


def at_most(limit: float | None = None, text: str | None = None) -> Rule:
    """Ours is a limit or less.

    `limit` is in the unit of the value; the paper's value unless given. `text` is the sentence.
    """
    words = ("at most", "no more than")
    return _compared(limit, text, words, lambda ours, bound: ours <= bound)


def above(limit: float | None = None, text: str | None = None) -> Rule:
    """Ours is more than a limit.

    `limit` is in the unit of the value; the paper's value unless given. `text` is the sentence.
    """
    words = ("above", "more than", "longer than", "larger", "rises")
    return _compared(limit, text, words, lambda ours, bound: ours > bound)


def below(limit: float | None = None, text: str | None = None) -> Rule:
    """Ours is less than a limit.

    `limit` is in the unit of the value; the paper's value unless given. `text` is the sentence.
    """
    words = ("below", "less than", "fewer than", "falls", "nearer than", "lowest", "<")
    return _compared(limit, text, words, lambda ours, bound: ours < bound)


def between(low: float, high: float, text: str = "{low:g} to {high:g}") -> Rule:
    """Ours is one of two limits or lies between them.

    Parameters
    ----------
    low, high
        The limits, in the unit of the value.
    text
        The sentence, whose fields are `low` and `high`.
    """
    said = _said(text, (" to ", "between"), _fields("low", low) | _fields("high", high))
    return Rule(said, None, lambda ours, _: low <= number_of(ours) <= high)


def exactly(number: float, text: str = "exactly {limit:g}") -> Rule:
    """Ours is a number that is given.

    `number` is in the unit of the value; `text` is the sentence, whose field is `limit`.
    """
    return Rule(_said(text, ("",), _fields("", number)), 0.0, lambda ours, _: number_of(ours) == number)


def none(text: str = "none") -> Rule:
    """Ours is zero."""
    return replace(exactly(0.0), text=_said(text, ("none", "no "), {}))


def all_of(count: float, text: str = "all") -> Rule:
    """Ours is the whole count."""
    return replace(exactly(count), text=_said(text, ("all", "every"), _fields("", count)))


def equal(text: str = "the same") -> Rule:
    """Ours is the paper's value, a number or words; `text` is the sentence."""
    return Rule(text, None, lambda ours, paper: paper is not None and shown_of(ours) == paper)


def as_many(text: str = "as many") -> Rule:
    """Ours is the paper's count."""
    return replace(equal(text), tolerance=0.0)


def within(tolerance: float, text: str = "within {limit:g}", of: float | None = None) -> Rule:
    """Ours differs from a value by a tolerance at most.

    Parameters
    ----------
    tolerance
        The tolerance, in the unit of the value.
    text
        The sentence, whose field is `limit`.
    of
        The value to compare with, in the same unit; the paper's unless given.
    """
    return _near(tolerance, text, of, lambda ours, true: abs(ours - true) <= tolerance)


def within_share(share: float, text: str = "within {percent:g} %", of: float | None = None) -> Rule:
    """Ours differs from a value by a share of it at most.

    Parameters
    ----------
    share
        The share, 0.1 for 10 %.
    text
        The sentence, whose field is `percent`.
    of
        The value to compare with, in the unit of ours; the paper's unless given.
    """
    return _near(share, text, of, lambda ours, true: abs(ours - true) <= share * abs(true))


def apart_above(other: Estimated, text: str = "above {limit:g}, intervals apart") -> Rule:
    """The whole interval of ours is above that of `other`, whose value the sentence can give."""
    said = _said(text, ("above", "apart"), _fields("", other.value))
    return Rule(said, None, lambda ours, _: _interval_of(ours)[0] > other.interval.high)


def apart_below(other: Estimated, text: str = "below {limit:g}, intervals apart") -> Rule:
    """The whole interval of ours is below that of `other`, whose value the sentence can give."""
    said = _said(text, ("below", "apart"), _fields("", other.value))
    return Rule(said, None, lambda ours, _: _interval_of(ours)[1] < other.interval.low)


def overlapping(other: Ends, text: str = "intervals overlap: {low:.2f}-{high:.2f}") -> Rule:
    """The intervals of ours and of `other` have a value in common; fields are the ends of `other`."""

    def test(ours: Judged, _: Value) -> bool:
        low, high = _interval_of(ours)
        return low <= other.high and other.low <= high

    return Rule(_said(text, ("overlap",), {"low": other.low, "high": other.high}), None, test)


def covering(text: str = "its 95 % interval covers the paper's") -> Rule:
    """The paper's value lies in the interval of confidence of ours."""

    def test(ours: Judged, paper: Value) -> bool:
        low, high = _interval_of(ours)
        return low <= number_of(paper) <= high

    return Rule(_said(text, ("covers",), {}), None, test)


def significant(direction: int, p: float, text: str) -> Rule:
    """Ours is above 0 (direction 1) or below it (-1) by a test with this limit.

    The sentence is `text` with the limit of p after it. That nothing is found says not that nothing is there:
    for that there is `equivalent`.
    """
    said = f"{_said(text, _DIRECTIONS[direction], {})}, p < {p:g}"

    def test(ours: Judged, _: Value) -> bool:
        return _p_of(ours) < p and direction * number_of(ours) > 0.0

    return Rule(said, p, test, by_p=True)


def equivalent(margin: float, p: float, text: str) -> Rule:
    """Ours is no different from what it is compared with, by two one-sided tests with this limit of their p.

    The p of ours, a `Measured`, is the larger one of the tests that it is off by the margin on either side
    (Schuirmann 1987); it is below 5 % where the 90 % interval lies within the margin.

    Parameters
    ----------
    margin
        By how much it may be off and still count as no different, stated beforehand with its reason.
    p
        Limit of the probability.
    text
        The sentence, whose field is `limit`, the margin.
    """
    said = f"{_said(text, ('no different',), _fields('', margin))}, two one-sided tests, p < {p:g}"
    return Rule(said, margin, lambda ours, _: _p_of(ours) < p, by_p=True)


def number_of(ours: Judged) -> float:
    """The number that is judged; not a number where it is missing or is words."""
    value = ours.value if isinstance(ours, Measured) else ours
    return math.nan if value is None or isinstance(value, str) else float(value)


def shown_of(ours: Judged) -> Value:
    """What is shown of a value."""
    return ours.shown if isinstance(ours, Measured) else ours


def _p_of(ours: Judged) -> float:
    """Probability of a measured value's test; not a number where it has none."""
    return ours.p if isinstance(ours, Measured) else math.nan


def _interval_of(ours: Judged) -> tuple[float, float]:
    """Ends of the interval of confidence; not numbers where it has none."""
    known = ours.interval if isinstance(ours, Measured) else None
    return (math.nan, math.nan) if known is None else (known.low, known.high)


def _never(_ours: Judged, _paper: Value) -> bool:
    return False


def _compared(
    limit: float | None, text: str | None, words: tuple[str, ...], compare: Callable[[float, float], bool]
) -> Rule:
    """A rule about a limit, the paper's value without one; the first of `words` is the usual one."""
    usual = f"{words[0]} the paper's" if limit is None else f"{words[0]} {{limit:g}}"

    def test(ours: Judged, paper: Value) -> bool:
        return compare(number_of(ours), number_of(paper) if limit is None else limit)

    said = _said(usual if text is None else text, words, {} if limit is None else _fields("", limit))
    return Rule(said, limit, test)


def _near(tolerance: float, text: str, of: float | None, close: Callable[[float, float], bool]) -> Rule:
    def test(ours: Judged, paper: Value) -> bool:
        return close(number_of(ours), number_of(paper) if of is None else of)

    fields = _fields("", tolerance) | ({} if of is None else _fields("of", of))
    return Rule(_said(text, ("within", "at most"), fields), tolerance, test)


def _fields(name: str, value: float) -> dict[str, float]:
    """A value in all units that a sentence can give it in."""
    found = {"_".join(filter(None, (name, unit))): scale * value for unit, scale in _SCALES.items()}
    return {key or "limit": scaled for key, scaled in found.items()}


def _said(text: str, words: tuple[str, ...], fields: Mapping[str, float]) -> str:
    """The sentence with its numbers; raises `ParameterError` where it could say another rule than it is."""
    word = next((word for word in words if word in text), None)
    if word is None:
        known = ", ".join(words)
        raise ParameterError(f'rule: "{text}", must say what it compares; use one of the words {known}')
    asked = [name for _, name, _, _ in Formatter().parse(text) if name is not None]
    written = fields and not asked and _NUMBER.search(text.partition(word)[2])
    if written or any(name not in fields for name in asked):
        known = ", ".join(fields) or "none"
        raise ParameterError(f'rule: "{text}", must take its number from a field; fields are {known}')
    return text.format(**fields)
