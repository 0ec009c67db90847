"""The grid of zeta, and what is read off between points."""

import numpy as np

from chips.rolls.lumped.grid import edges, integral, interpolated


def test_values_between_points_are_numpys_to_the_last_bit() -> None:
    draw = np.random.default_rng(1000)
    points, values = np.cumsum(draw.uniform(0.0, 1.0, 60)), draw.normal(size=60)
    x = np.sort(np.concatenate((draw.uniform(-1.0, 40.0, 500), points, [-5.0, 100.0])))
    out = np.empty(x.size)
    for count in (60, 2, 1):
        interpolated(x, points[:count], values[:count], out)
        np.testing.assert_array_equal(out, np.interp(x, points[:count], values[:count]))


def test_octaves_are_divided_alike() -> None:
    grid = edges(64)
    width = np.diff(grid)
    assert grid[0] == 1.0
    assert (np.diff(width) >= 0.0).all()
    assert set(np.log2(width / width[0])) <= set(range(8))


def test_an_exponential_is_integrated_exactly() -> None:
    v = np.linspace(0.0, 3.0, 7)[None]
    np.testing.assert_allclose(integral(v, np.exp(-2.0 * v)), -0.5 * np.expm1(-2.0 * v), rtol=1e-12)
