"""What kernels do with lanes, against numpy's long double and numbers one by one."""

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.softplus import LIMIT, power_of_lanes, softplus_of_two
from circuits.vectors import vector
from circuits.vectors.vector import WIDTH, rows

load, store, every, select, bits = vector.load, vector.store, vector.every, vector.select, vector.bits
magnitude, larger, smaller = vector.magnitude, vector.larger, vector.smaller
root, inverse_cube_root = vector.root, vector.inverse_cube_root
# a polynomial's fit (8e-14) and a few dozen roundings
LAW = 1e-12


@compiled()
def law(x: F64, out: F64) -> None:
    """Of each row of x three: `ln(1 + e^x)`, its slope, and `e^x`; the first two are made in pairs."""
    for i in range(x.shape[0]):
        pair = i ^ 1
        mine, _, _, other_slope = softplus_of_two(load(x, i), load(x, pair))
        store(out, 3 * i, mine)
        store(out, 3 * pair + 1, other_slope)
        store(out, 3 * i + 2, power_of_lanes(load(x, i)))


@compiled()
def arithmetic(x: F64, out: F64) -> int:
    """A row of each operation on the rows 0 and 1, and which lanes of 0 are below 1 in the bits returned."""
    a, b = load(x, 0), load(x, 1)
    below = (a < b) & ~(a <= -1e9) | (a > 1e9)
    store(out, 0, (2.0 * a + b) / (b - 0.5))
    store(out, 1, select(below, a, b))
    store(out, 2, larger(a, b) - smaller(a, b))
    store(out, 3, root(magnitude(a)) * every(3.0))
    store(out, 4, inverse_cube_root(magnitude(a) + 1e-30))
    return bits(below)


def test_the_laws_powers_and_logarithms_beside_long_double() -> None:
    # neighbours far apart, so that a mixed-up lane shows
    x = np.linspace(-LIMIT, LIMIT, 200 * WIDTH).reshape(WIDTH, -1).T.copy()
    given, out = rows(len(x)), rows(3 * len(x))
    given[:] = x
    law(given, out)
    value, slope, power = out[0::3], out[1::3], out[2::3]
    exact = x.astype(np.longdouble)
    grown = np.exp(-np.abs(exact))
    softplus = np.maximum(exact, 0.0) + np.log1p(grown)
    for ours, true in (
        (value, softplus),
        (slope, np.where(exact >= 0.0, 1.0, grown) / (1.0 + grown)),
        (power, np.exp(exact)),
    ):
        assert np.abs(ours / true - 1.0).max() < LAW


def test_beyond_the_limit_nothing_overflows() -> None:
    given, out = rows(2), rows(6)
    given[:], given[0, 3], given[1, 5] = 0.0, 1e6, -np.inf
    law(given, out)
    assert out[0, 3] == 1e6
    assert np.isfinite(out).all()
    assert out[2, 3] == pytest.approx(np.exp(LIMIT))


def test_each_lane_has_its_own_numbers() -> None:
    given, out = rows(2), rows(5)
    given[:] = np.random.default_rng(3).normal(scale=100.0, size=(2, WIDTH))
    a, b = given.copy()
    below = arithmetic(given, out)
    assert below == sum(1 << k for k in range(WIDTH) if a[k] < b[k])
    np.testing.assert_allclose(out[0], (2.0 * a + b) / (b - 0.5), rtol=1e-15)
    assert (out[1] == np.minimum(a, b)).all()
    assert (out[2] == np.abs(a - b)).all()
    np.testing.assert_allclose(out[3], 3.0 * np.sqrt(np.abs(a)), rtol=1e-15)
    np.testing.assert_allclose(out[4], np.cbrt(1.0 / np.abs(a)), rtol=2e-6)


def test_rows_begin_where_vectors_do() -> None:
    for count in (1, 3, 17):
        assert rows(count).ctypes.data % 64 == 0
        assert rows(count).shape == (count, WIDTH)
