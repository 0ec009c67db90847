"""Summaries count every sample, and say nothing of too few."""

import math

import numpy as np
import pytest

from circuits.arrays import F64
from system.study.specification import Verdict
from system.study.statistics.interval import EVERYTHING, Interval, quantile_interval
from system.study.statistics.summary import PROBABILITIES, summarise, summarise_share, summarise_yield


def test_values_of_a_sample() -> None:
    x = np.random.default_rng(2).normal(3.0, 0.5, 500)
    found = summarise(np.concatenate([x, [math.nan, math.nan, math.inf]]), np.random.default_rng(0))
    assert (found.samples, found.defined, found.undefined, found.infinite) == (503, 500, 2, 1)
    assert found.mean.value == pytest.approx(x.mean())
    assert found.sigma.value == pytest.approx(x.std(ddof=1))
    assert [q.p for q in found.quantiles] == list(PROBABILITIES)
    for q in found.quantiles:
        assert q.estimate.value == pytest.approx(np.quantile(x, q.p))
        assert q.estimate.value in q.estimate.interval
    for estimate in (found.mean, found.sigma, found.skew):
        assert estimate.value in estimate.interval
        assert math.isfinite(estimate.interval.half_width)
    assert 0.0 in found.skew.interval
    assert 0.5 in found.sigma.interval


@pytest.mark.parametrize("values", [[], [math.nan], [math.inf, math.nan]])
def test_nothing_defined(values: list[float]) -> None:
    found = summarise(np.array(values), np.random.default_rng(0))
    assert found.defined == 0
    assert found.samples == found.undefined + found.infinite == len(values)
    assert math.isnan(found.mean.value)
    assert math.isnan(found.sigma.value)
    assert math.isnan(found.skew.value)
    assert all(math.isnan(q.estimate.value) for q in found.quantiles)
    assert found.mean.interval == EVERYTHING


def test_one_sample() -> None:
    found = summarise(np.array([2.0]), np.random.default_rng(0))
    assert found.mean.value == 2.0
    assert found.mean.interval == EVERYTHING
    assert math.isnan(found.sigma.value)
    assert found.sigma.interval == Interval(0.0, math.inf)


def test_equal_samples() -> None:
    found = summarise(np.full(60, 1.0409922495256814e-6), np.random.default_rng(0))  # its mean is rounded
    assert found.sigma.value == 0.0
    assert math.isnan(found.skew.value)


def test_tiny_values_keep_their_digits() -> None:
    x = np.random.default_rng(1).normal(3.0, 0.5, 100)
    one = summarise(x, np.random.default_rng(0))
    other = summarise(1e-12 * x, np.random.default_rng(0))
    assert other.skew.value == pytest.approx(one.skew.value)
    assert other.sigma.interval.high == pytest.approx(1e-12 * one.sigma.interval.high)


def test_yield() -> None:
    found = summarise_yield(Verdict(("", "", "", "failed")))
    assert (found.samples, found.passed, found.estimate.value) == (4, 3, 0.75)
    assert found.causes == {"failed": 1}
    assert found.estimate.interval.low == pytest.approx(0.19412, abs=1e-5)  # beta.ppf(0.025, 3, 2)
    assert found.estimate.interval.high == pytest.approx(0.99369, abs=1e-5)


def test_yield_of_no_sample() -> None:
    found = summarise_yield(Verdict(()))
    assert math.isnan(found.estimate.value)
    assert found.estimate.interval == Interval(0.0, 1.0)


def test_no_yes_in_twenty_is_a_share_with_its_exact_interval() -> None:
    found = summarise_share(np.array([0.0] * 20 + [math.nan]))
    assert str(found.share) == "0 of 20 (0 to 17 %)"
    assert (found.samples, found.defined, found.undefined) == (21, 20, 1)
    assert found.mean.interval.high == pytest.approx(1.0 - 0.025 ** (1 / 20))  # Clopper and Pearson's
    assert found.quantiles == ()
    assert (found.sigma.interval, found.skew.interval) == (EVERYTHING, EVERYTHING)


def test_a_share_of_no_sample() -> None:
    found = summarise_share(np.array([math.nan]))
    assert math.isnan(found.mean.value)
    assert str(found.share) == "0 of 0 (0 to 100 %)"


@pytest.mark.parametrize("values", [np.zeros(20), -np.zeros(20), np.full(5, 3.0)])
def test_of_equal_values_no_interval_of_mean_or_spread_is_known(values: F64) -> None:
    found = summarise(values, np.random.default_rng(0))
    assert found.mean.interval == EVERYTHING
    assert found.sigma.interval == Interval(0.0, math.inf)


def test_there_is_no_minus_zero() -> None:
    found = summarise(-np.zeros(200), np.random.default_rng(0))
    ends = [end for q in found.quantiles for end in (q.estimate.interval.low, q.estimate.interval.high)]
    numbers = [found.mean.value, *(q.estimate.value for q in found.quantiles), *ends]
    assert not any(math.copysign(1.0, x) < 0.0 for x in numbers if x == 0.0)
    assert quantile_interval(np.zeros(200), 0.5) == Interval(0.0, 0.0)
    assert str(quantile_interval(np.zeros(200), 0.5)) == "Interval(low=0.0, high=0.0)"
