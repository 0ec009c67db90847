"""Worst cases of metrics whose failing dies are known, and the yield that they tell."""

import numpy as np
import pytest
from scipy.special import ndtr

from circuits.arrays import F64
from circuits.errors import SolverError
from system.study.search.worst_case import beyond, checked_there, failure_of, worst_cases
from system.study.specification import Limits
from tests.refusals import refusals
from tests.system.study.search.planned import planned

SLOPE = np.array([3.0, 0.0, 4.0, 0.0])  # of length 5


def linear(z: F64) -> F64:
    return np.asarray(10.0 + z @ SLOPE)


def bent(z: F64) -> F64:
    return np.asarray(10.0 + z @ SLOPE + 0.3 * (z @ SLOPE / 5.0) ** 2 + 0.2 * z[:, 1] ** 2)


def test_a_linear_metric_fails_where_its_slope_says() -> None:
    low, high = worst_cases(planned(linear), Limits("delay", -5.0, 20.0, "s"))
    assert (low.side, high.side) == ("below", "above")
    assert (low.distance, high.distance) == (pytest.approx(3.0), pytest.approx(2.0))
    assert high.point == pytest.approx(2.02 * SLOPE / 5.0)
    assert failure_of((low, high)) == pytest.approx(ndtr(-3.0) + ndtr(-2.0))
    assert low.verified
    assert high.value == pytest.approx(20.1)


def test_a_limit_that_no_die_reaches_hides_none_that_some_do() -> None:
    limits = Limits("delay", -5.0, 60.0, "s")
    (low,) = worst_cases(planned(linear), limits)
    assert (low.side, low.distance) == ("below", pytest.approx(3.0))
    assert beyond(limits, (low,)) == ("above",)


def test_a_bent_metric_is_found_where_it_is_and_sampling_there_agrees() -> None:
    """Of 4e5 plain dies the failing share is known to 1.5 % at one standard error."""
    limits, slopes = Limits("delay", -np.inf, 25.0, "s"), planned(bent)
    (case,) = worst_cases(slopes, limits)
    assert case.verified
    assert slopes.runs < 60
    assert bent(case.point[None] / 1.01)[0] == pytest.approx(25.0, abs=0.06)
    plain = float((bent(np.random.default_rng(1).standard_normal((400_000, 4))) > 25.0).mean())
    found = checked_there(slopes, limits, (case,), 2000, 3)
    assert found.interval.low < plain < found.interval.high
    assert found.probability == pytest.approx(plain, rel=0.12)
    assert case.failing == pytest.approx(plain, rel=0.4)


def test_no_dies_are_wasted_on_a_limit_that_is_far_less_likely_to_fail() -> None:
    limits, slopes = Limits("delay", -11.5, 45.0, "s"), planned(linear)  # 4.3 and 7 sigma
    cases = worst_cases(slopes, limits)
    assert [round(case.distance, 2) for case in cases] == [4.3, 7.0]
    found = checked_there(slopes, limits, cases, 400, 3)
    assert found.effective_samples > 60.0  # of two equal halves it is below 50, and there is no estimate
    assert found.interval.low < ndtr(-4.3) < found.interval.high


def test_a_nominal_die_that_fails_has_a_distance_below_zero() -> None:
    limits = Limits("delay", -np.inf, 5.0, "s")
    (case,) = worst_cases(planned(linear), limits)
    assert case.distance == pytest.approx(-1.0)
    assert case.failing == pytest.approx(ndtr(1.0))
    assert case.verified
    with pytest.raises(SolverError, match="the nominal die fails, so failures are not rare"):
        checked_there(planned(linear), limits, (case,), 200, 0)


def vanishing(z: F64) -> F64:
    return np.where(z @ SLOPE > 4.0, np.nan, linear(z))


test_what_has_no_worst_case_is_refused = refusals(
    SolverError,
    lambda given: worst_cases(planned(given[0]), Limits("delay", *given[1], "s")),
    [
        ((linear, (-np.inf, 60.0)), "every die meets it, as far as 8 sigma; give another limit"),
        ((linear, (-np.inf, -60.0)), "no die meets it, as far as 8 sigma"),
        ((lambda z: 10.0 + 0.0 * z[:, 0], (0.0, np.inf)), "nothing that varies moves delay"),
        ((lambda z: np.nan * z[:, 0], (0.0, np.inf)), "delay is not defined on the nominal die"),
        ((lambda z: np.where(z @ SLOPE > 1e-9, np.nan, linear(z)), (-np.inf, 20.0)), "delay has no gradient"),
    ],
    start=".*",
)


def test_a_search_that_leads_where_nothing_is_defined_says_so() -> None:
    with pytest.raises(SolverError, match=r"delay: is not defined at|has no gradient"):
        worst_cases(planned(vanishing), Limits("delay", -np.inf, 20.0, "s"))
