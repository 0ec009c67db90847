"""Rules: sentence, number and verdict are one thing, and neither can be stated against the others."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.errors import ParameterError
from system.rule import (
    Judged,
    Measured,
    Rule,
    Value,
    above,
    all_of,
    apart_above,
    apart_below,
    as_many,
    at_least,
    at_most,
    below,
    between,
    covering,
    equal,
    equivalent,
    exactly,
    none,
    overlapping,
    significant,
    unjudged,
    within,
    within_share,
)
from system.study.statistics.interval import Estimate, Interval
from system.study.statistics.share import Share

LOW, HIGH = Estimate(1.0, Interval(0.5, 1.5)), Estimate(3.0, Interval(2.0, 4.0))


@dataclass(frozen=True, slots=True)
class Case:
    """A rule, what it says, and values of ours for which it holds and does not; `paper` beside."""

    rule: Rule
    text: str
    good: tuple[Judged, ...]
    bad: tuple[Judged, ...]
    paper: Value = None


def measured(value: float, *, interval: Interval | None = None, p: float = math.nan) -> Measured:
    return Measured(value, value, interval, p)


CASES = (
    Case(at_least(0.9), "at least 0.9", (0.9, 1), (0.89,)),
    Case(at_most(0.02, "at most {percent:g} % of it"), "at most 2 % of it", (0.02, -1.0), (0.021,)),
    Case(above(0.0), "above 0", (1e-9,), (0.0, -1.0)),
    Case(below(1e-3, "less than {milli:g} mV"), "less than 1 mV", (9e-4,), (1e-3,)),
    Case(above(text="longer than the paper's"), "longer than the paper's", (3,), (2.0,), 2.0),
    Case(at_most(), "at most the paper's", (2,), (2.1,), 2.0),
    Case(between(1e-6, 2e-6, "{low_micro:g} to {high_micro:g} us"), "1 to 2 us", (1e-6, 2e-6), (9e-7, 3e-6)),
    Case(exactly(2.0), "exactly 2", (2, 2.0), (2.1,)),
    Case(none("none of them"), "none of them", (0, 0.0), (1,)),
    Case(all_of(3, "all {limit:g}"), "all 3", (3,), (2,)),
    Case(equal(), "the same", ("left",), ("right", None), "left"),
    Case(as_many(), "as many", (3, 3.0), (2,), 3),
    Case(within(0.1), "within 0.1", (1.05, 0.95), (1.11, 0.89), 1.0),
    Case(within(0.1, of=0.0), "within 0.1", (-0.1, 0.1), (0.11, -0.11), 5.0),
    Case(within_share(0.1), "within 10 %", (-1.05,), (-1.11, 1.0), -1.0),
    Case(within_share(0.1, "within {percent:g} % of {of_milli:g} ms", 2e-3), "within 10 % of 2 ms",
         (2.1e-3,), (2.3e-3,)),
    Case(apart_above(LOW), "above 1, intervals apart", (measured(3.0, interval=HIGH.interval),),
         (measured(1.4, interval=Interval(1.2, 1.6)), 3.0)),
    Case(apart_below(HIGH), "below 3, intervals apart", (measured(1.0, interval=LOW.interval),),
         (measured(2.0, interval=Interval(1.5, 2.5)), 1.0)),
    Case(overlapping(LOW.interval), "intervals overlap: 0.50-1.50",
         (measured(2.0, interval=Interval(1.5, 3.0)),), (measured(3.0, interval=HIGH.interval), 1.0)),
    Case(significant(1, 0.05, "better"), "better, p < 0.05", (measured(1.0, p=0.01),),
         (measured(-1.0, p=0.01), measured(1.0, p=0.06), 1.0)),
    Case(significant(-1, 0.05, "worse than it"), "worse than it, p < 0.05", (measured(-1.0, p=0.01),),
         (measured(1.0, p=0.01),)),
    Case(equivalent(0.1, 0.05, "no different by {percent:g} %"),
         "no different by 10 %, two one-sided tests, p < 0.05", (measured(1.0, p=0.01),),
         (measured(1.0, p=0.05), 0.0)),
    Case(covering(), "its 95 % interval covers the paper's", (measured(9.0, interval=HIGH.interval),),
         (measured(2.0, interval=Interval(2.1, 3.0)), 2.0), 2.0),
    Case(above(0.0) & below(1.0), "above 0, below 1", (0.5,), (0.0, 1.0)),
    Case(at_least(1.0).beside("19 of 20"), "at least 1; 19 of 20", (1.0,), (0.9,)),
    Case(at_least(1.0).unless(spoilt=False, why="it is not"), "at least 1", (1.0,), (0.9,)),
    Case(at_least(1.0).unless(spoilt=True, why="it is not"), "at least 1; it is not", (), (1.0,)),
)  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.text)
def test_a_rule_says_and_judges_one_thing(case: Case) -> None:
    assert case.rule.text == case.text
    assert [case.rule.holds(ours, case.paper) for ours in case.good] == [True] * len(case.good)
    assert [case.rule.holds(ours, case.paper) for ours in case.bad] == [False] * len(case.bad)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.text)
def test_what_is_missing_agrees_with_no_rule(case: Case) -> None:
    for nothing in (None, math.nan, Measured(math.nan, "none", Interval(math.nan, math.nan))):
        assert case.rule.holds(nothing, case.paper) is False


@given(st.floats(0.0, 1e3), st.floats(-1e3, 1e3))
def test_one_of_opposite_rules_holds(limit: float, ours: float) -> None:
    assert at_least(limit).holds(ours, None) is not below(limit).holds(ours, None)
    assert at_most(limit).holds(ours, None) is not above(limit).holds(ours, None)
    assert within(limit, of=0.0).holds(ours, None) is between(-limit, limit).holds(ours, None)


def test_without_a_rule_there_is_no_verdict() -> None:
    assert unjudged().holds(1.0, 1.0) is None
    assert unjudged().text == "no rule"


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: above(1.0, "below {limit:g}"), "use one of the words above"),
        (
            lambda: at_most(0.1, "at most 20 %"),
            "must take its number from a field; fields are limit, percent",
        ),
        (lambda: within(0.1, "within {percents:g} %"), "fields are limit"),
        (lambda: within(0.1, "within {of:g}"), "fields are limit"),
        (lambda: significant(1, 0.05, "worse than it"), "use one of the words better"),
        (lambda: equivalent(0.1, 0.05, "no different by 20 %"), "must take its number from a field"),
        (lambda: none("at most a few"), "use one of the words none"),
    ],
)
def test_a_sentence_that_says_another_rule_is_refused(make: object, words: str) -> None:
    assert callable(make)
    with pytest.raises(ParameterError, match=words):
        make()


def test_a_share_is_judged_by_its_value_and_shown_in_words() -> None:
    nearly = Share(19, 20).measured()
    assert nearly.shown == "19 of 20 (75 to 100 %)"
    assert at_least(0.95).holds(nearly, None) is True
    assert apart_above(Share(1, 20)).holds(nearly, None) is True
    assert Share(19, 20).measured(0.95).shown == 0.95
    assert at_most(0.5).holds(Share(0, 0).measured(), None) is False
