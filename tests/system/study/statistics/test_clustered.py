"""The yield of dies with several trials each; how often it covers is `benchmarks/mission_interval.py`."""

import math

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.study.statistics.clustered import clustered_yield, mean_of_shares, narrow
from system.study.statistics.interval import Interval, clopper_pearson
from tests.system.study.statistics.alike import studies


def test_alike_trials_count_as_one_and_independent_ones_each() -> None:
    alike = clustered_yield(np.repeat([1.0, 0.0], [160, 40]), 5)
    assert alike.effective == pytest.approx(200.0, rel=0.01)
    assert alike.correlation == pytest.approx(1.0)
    rng = np.random.default_rng(3)
    free = clustered_yield(rng.binomial(5, 0.8, 2000) / 5, 5)
    assert free.effective == pytest.approx(10_000.0, rel=0.06)
    assert free.correlation == pytest.approx(0.0, abs=0.02)
    exact = clopper_pearson(160, 200)
    assert alike.interval.half_width == pytest.approx(exact.half_width, rel=0.02)
    assert free.interval.half_width < 0.5 * exact.half_width


def test_without_a_failure_each_die_counts_once() -> None:
    found = clustered_yield(np.ones(50), 8)
    assert (found.value, found.effective, found.interval.high) == (1.0, 50.0, 1.0)
    assert found.interval.low <= clopper_pearson(50, 50).low
    assert math.isnan(found.correlation)


@pytest.mark.parametrize(("passed", "dies"), [(3, 3), (24, 24), (0, 5), (17, 20)])
def test_with_one_trial_a_die_the_interval_is_the_exact_one(passed: int, dies: int) -> None:
    found = clustered_yield(np.repeat([1.0, 0.0], [passed, dies - passed]), 1)
    exact = clopper_pearson(passed, dies)
    assert (found.interval.low, found.interval.high) == pytest.approx((exact.low, exact.high))
    assert found.effective == dies


def test_the_mean_of_dies_that_are_all_alike_is_not_known_for_sure() -> None:
    alike = mean_of_shares(np.ones(30))
    assert alike.low == pytest.approx(1.0 - clopper_pearson(0, 30).high)
    assert alike.high == 1.0
    assert mean_of_shares(np.zeros(4), -1.0).low == pytest.approx(-clopper_pearson(0, 4).high)
    assert mean_of_shares(np.array([])) == Interval(0.0, 1.0)
    differ = np.repeat([0.5, 1.0], 15)
    assert 0.6 < mean_of_shares(differ).low < 0.75 < mean_of_shares(differ).high < 0.9


def test_one_die_or_none_says_next_to_nothing() -> None:
    assert clustered_yield(np.array([]), 4).interval.half_width == 0.5
    assert clustered_yield(np.array([0.75]), 4).interval.half_width > 0.4
    with pytest.raises(ParameterError, match="trials: 0"):
        clustered_yield(np.ones(3), 0)


def test_the_interval_covers_the_truth_of_synthetic_studies() -> None:
    """Of 300 studies 94 % are at least 274 with a chance of 0.98 where 95 % are expected."""
    held = [p in clustered_yield(shares, 4).interval for p, shares, _ in studies(range(300), "beta", 60, 4)]
    assert 274 <= sum(held) < 300


def test_a_study_ends_where_the_interval_is_narrow_and_no_earlier_than_after_some_dies() -> None:
    assert not narrow(clustered_yield(np.ones(15), 1), 0.4)
    assert narrow(clustered_yield(np.ones(16), 1), 0.4)
    assert not narrow(clustered_yield(np.ones(16), 1), 0.02)
