"""The sequence holds at all sample numbers at once, so also where a rule stops that looks at the data."""

import math

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.study.statistics.confidence_sequence import (
    StopRule,
    first_stop,
    log_martingale,
    sequence_interval,
    sequence_intervals,
)
from system.study.statistics.interval import Interval, clopper_pearson

YIELDS = (0.5, 0.9, 0.99, 0.999)


@pytest.mark.parametrize("true", YIELDS)
def test_the_true_yield_is_refuted_at_any_time_at_most_as_often_as_said(true: float) -> None:
    passed = np.random.default_rng(1).random((1000, 2000)) < true
    counts, samples = passed.cumsum(axis=1), np.arange(1, 2001)
    ever = (log_martingale(counts, samples, true) >= math.log(20.0)).any(axis=1)
    assert ever.mean() <= 0.07  # 5 % is guaranteed; the standard error of 1,000 experiments is 0.7 %


@pytest.mark.parametrize("true", YIELDS)
def test_the_yield_is_covered_where_a_rule_stopped(true: float) -> None:
    passed = np.random.default_rng(2).random((100, 400)) < true
    rule = StopRule(half_width=0.05, required=true - 0.01)
    stops = [first_stop(each, rule) for each in passed]
    intervals = [
        sequence_interval(int(each.sum()), each.size) if stop is None else stop.interval
        for each, stop in zip(passed, stops, strict=True)
    ]
    assert sum(stop is not None for stop in stops) > 0
    assert np.mean([true in interval for interval in intervals]) >= 0.93


def test_the_martingale_has_mean_one() -> None:
    """E M_n(p) = 1 for the true p, summed over all counts of 30 samples."""
    for p in (0.2, 0.9):
        counts = np.arange(31)
        chance = np.array([math.comb(30, k) * p**k * (1.0 - p) ** (30 - k) for k in counts])
        value = np.exp(log_martingale(counts, np.full(31, 30), p))
        assert (chance * value).sum() == pytest.approx(1.0, rel=1e-12)


def test_ends_are_where_the_martingale_reaches_the_limit() -> None:
    found = sequence_interval(990, 1000)
    ends = log_martingale(np.array([990, 990]), np.array([1000, 1000]), np.array([found.low, found.high]))
    assert ends == pytest.approx(math.log(20.0), abs=1e-9)


def test_it_is_wider_than_an_interval_for_a_fixed_number() -> None:
    fixed, anytime = clopper_pearson(90, 100), sequence_interval(90, 100)
    assert anytime.low < fixed.low < fixed.high < anytime.high


def test_without_samples_nothing_is_known() -> None:
    assert sequence_interval(0, 0) == Interval(0.0, 1.0)


def test_all_or_none_passing_reaches_the_end() -> None:
    assert sequence_interval(50, 50).high == 1.0
    assert sequence_interval(0, 50).low == 0.0


def test_passing_and_failing_mirror() -> None:
    one, other = sequence_interval(13, 50), sequence_interval(37, 50)
    assert (one.low, one.high) == pytest.approx((1.0 - other.high, 1.0 - other.low), abs=1e-12)


def test_a_stop_is_the_first_of_its_kind() -> None:
    passed = np.random.default_rng(3).random(3000) < 0.9
    rule = StopRule(half_width=0.05)
    stop = first_stop(passed, rule)
    assert stop is not None
    assert stop.reason == "the yield's half-width is below 0.05"
    assert stop.interval == sequence_interval(int(passed[: stop.samples].sum()), stop.samples)
    assert stop.interval.half_width < 0.05
    assert first_stop(passed[: stop.samples - 1], rule) is None
    assert first_stop(passed[: stop.samples], rule) == stop, "chunks make no difference"


@pytest.mark.parametrize(("required", "side"), [(0.5, "above"), (0.99, "below")])
def test_a_required_yield_is_decided(required: float, side: str) -> None:
    passed = np.random.default_rng(4).random(2000) < 0.8
    stop = first_stop(passed, StopRule(required=required))
    assert stop is not None
    assert stop.reason == f"the yield is {side} {required:g}"


def test_no_samples_do_not_stop() -> None:
    assert first_stop(np.zeros(0, dtype=np.bool_), StopRule(half_width=0.1)) is None


def test_many_counts_at_once_are_the_same() -> None:
    low, high = sequence_intervals(np.array([3, 7]), np.array([5, 9]))
    assert [Interval(*ends) for ends in zip(low.tolist(), high.tolist(), strict=True)] == [
        sequence_interval(3, 5),
        sequence_interval(7, 9),
    ]


def test_a_rule_needs_a_part_and_proportions() -> None:
    with pytest.raises(ParameterError, match="auto-stop: no rule"):
        StopRule()
    with pytest.raises(ParameterError, match="auto-stop: required 97, must be above 0 and below 1"):
        StopRule(required=97.0)
    with pytest.raises(ParameterError, match="passed: 3, must be from 0 to samples 2"):
        sequence_interval(3, 2)
