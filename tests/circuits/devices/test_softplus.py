"""The packed softplus against forty-digit decimal arithmetic."""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.softplus import (
    LIMIT,
    exp_negative,
    inverse_softplus,
    inverse_softplus_of,
    softplus,
    softplus_at,
    softplus_five,
)

# a polynomial's fit (2e-15) and a dozen roundings (1e-16 each)
TOLERANCE = 1e-14
# a polynomial's fit (8e-14) and a few dozen roundings
FIVE_TOLERANCE = 1e-12


@compiled()
def fives(x: F64, value: F64, slope: F64) -> None:
    """Both of 5 n numbers, five at a time."""
    for i in range(0, x.size, 5):
        y = softplus_five(x[i], x[i + 1], x[i + 2], x[i + 3], x[i + 4])
        for k in range(5):
            value[i + k], slope[i + k] = y[k], y[5 + k]


def both(x: F64) -> tuple[F64, F64]:
    value, slope = np.empty_like(x), np.empty_like(x)
    softplus(x, value, slope)
    return value, slope


def exact(x: float) -> tuple[float, float]:
    """ln(1 + e^x) and 1 / (1 + e^-x), rounded once."""
    with localcontext() as context:
        context.prec = 350  # ln(1 + e^-340) keeps its digits
        grown = Decimal(x).exp()
        return float((1 + grown).ln()), float(grown / (1 + grown))


@pytest.mark.parametrize(
    "x", [-LIMIT, -339.7, -100.3, -37.0, -1.0, -1e-3, 0.0, 1e-9, 0.5, 1.0, 20.0, 36.7, 100.3, LIMIT]
)
def test_value_and_slope_in_both_tails(x: float) -> None:
    value, slope = both(np.array([x]))
    assert (value[0], slope[0]) == pytest.approx(exact(x), rel=TOLERANCE, abs=0.0)
    assert softplus_at(x) == pytest.approx(exact(x)[0], rel=TOLERANCE, abs=0.0)


def test_dense_sample_against_the_standard_library() -> None:
    x = np.linspace(-300.0, 300.0, 20011)
    value, slope = both(x)
    reference = [max(a, 0.0) + math.log1p(math.exp(-abs(a))) for a in x]
    np.testing.assert_allclose(value, reference, rtol=TOLERANCE, atol=0.0)
    np.testing.assert_allclose(slope, 1.0 / (1.0 + np.exp(-x)), rtol=TOLERANCE, atol=0.0)


def test_five_numbers_keep_their_lanes_and_their_accuracy() -> None:
    # neighbours far apart, so that a mixed-up lane shows
    x = np.linspace(-LIMIT, LIMIT, 50_005).reshape(5, -1).T.ravel()
    exact_value, exact_slope = both(x)
    value, slope = np.empty_like(x), np.empty_like(x)
    fives(x, value, slope)
    np.testing.assert_allclose(value, exact_value, rtol=FIVE_TOLERANCE, atol=0.0)
    np.testing.assert_allclose(slope, exact_slope, rtol=FIVE_TOLERANCE, atol=0.0)


def test_five_numbers_beyond_the_limit() -> None:
    value, slope = np.empty(5), np.empty(5)
    fives(np.array([-1e6, -LIMIT, 0.0, LIMIT, 1e6]), value, slope)
    assert value[0] == value[1] > 0.0
    assert value[2] == pytest.approx(math.log(2.0), rel=FIVE_TOLERANCE)
    assert value[4] == 1e6
    assert slope[0] < 1e-140
    assert slope[4] == 1.0


def test_beyond_the_limit_nothing_overflows() -> None:
    value, slope = both(np.array([-1e6, -LIMIT, 1e6]))
    assert value[0] == value[1] > 0.0
    assert value[2] == 1e6
    assert slope[2] == 1.0
    assert slope[0] < 1e-140


def test_exponential_of_a_negative() -> None:
    assert exp_negative(0.0) == 1.0
    for a in (123.456, -0.3, -20.0, -LIMIT):
        assert exp_negative(a) == pytest.approx(math.exp(-a), rel=TOLERANCE, abs=0.0)


@given(st.floats(min_value=-200.0, max_value=200.0))
def test_inverse(x: float) -> None:
    # a rounding of y moves x by 1e-16 y / slope, and the slope is at least y / 2 below 0
    y, _ = both(np.array([x]))
    assert inverse_softplus(float(y[0])) == pytest.approx(x, rel=1e-13, abs=1e-12)
    assert inverse_softplus_of(y)[0] == pytest.approx(x, rel=1e-13, abs=1e-12)
