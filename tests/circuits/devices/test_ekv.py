"""The interpolation of the EKV law for arrays and for kernels, against decimal arithmetic and each other."""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circuits.devices.ekv import (
    argument,
    argument_of_root,
    interpolation,
    law,
    of_weak,
    steepness,
    steepness_of_root,
    weak_over,
)

# roundings of an exponential, a logarithm and a square (1e-16 each) and of the argument itself, which the
# exponential multiplies: |u| / 2 <= 50
TOLERANCE = 3e-14
ARGUMENTS = st.floats(-100.0, 100.0)
compiling = settings(deadline=None)  # the first example compiles


def exact(u: float) -> float:
    """`ln^2(1 + e^(u/2))`, rounded once."""
    with localcontext() as context:
        context.prec = 120
        return float((1 + (Decimal(u) / 2).exp()).ln() ** 2)


@compiling
@given(ARGUMENTS)
def test_both_forms_are_the_interpolation(u: float) -> None:
    assert float(interpolation(u)) == pytest.approx(exact(u), rel=TOLERANCE)
    assert law(u)[0] == pytest.approx(exact(u), rel=TOLERANCE)
    assert float(of_weak(math.exp(u))) == pytest.approx(exact(u), rel=TOLERANCE)
    assert float(weak_over(exact(u))) * exact(u) == pytest.approx(math.exp(u), rel=TOLERANCE)


@compiling
@given(ARGUMENTS)
def test_steepness_is_the_derivative_over_the_value(u: float) -> None:
    value, slope = law(u)
    assert float(steepness(value)) == pytest.approx(slope / value, rel=TOLERANCE)
    assert steepness_of_root(math.sqrt(value)) == pytest.approx(slope / value, rel=TOLERANCE)


@compiling
@given(ARGUMENTS)
def test_both_inverses_return_the_argument(u: float) -> None:
    f = interpolation(u)
    # near 0 the argument is a difference of two numbers of the size of 1
    assert float(argument(f)) == pytest.approx(u, rel=TOLERANCE, abs=1e-14)
    assert argument_of_root(math.sqrt(f)) == pytest.approx(u, rel=TOLERANCE, abs=1e-14)


def test_arrays_keep_their_shape_and_no_current_is_in_weak_inversion() -> None:
    u = np.linspace(-8.0, 8.0, 12).reshape(3, 4)
    f = interpolation(u)
    assert f.shape == argument(f).shape == steepness(f).shape == (3, 4)
    assert float(steepness(0.0)) == 1.0
