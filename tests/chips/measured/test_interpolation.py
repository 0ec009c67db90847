"""Interpolation between points of tables, against scipy's and against polynomials."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from chips.measured.interpolation import lagrange_weights, monotone_cubic


@pytest.mark.parametrize("points", [3, 5, 7])
def test_the_monotone_cubic_is_scipy_s(points: int) -> None:
    draw = np.random.Generator(np.random.Philox(points))
    for _ in range(30):
        knots = np.sort(draw.normal(size=points))
        table = draw.normal(size=(points, 3))
        table[:, 1] = np.sort(table[:, 1])  # monotone
        table[:, 2] = np.round(table[:, 2])  # flat in places
        peer = PchipInterpolator(knots, table)
        for x in (*knots, *draw.uniform(knots[0] - 0.1, knots[-1] + 0.1, 10)):
            found = np.empty(3)
            monotone_cubic(knots, table, float(x), found)
            # a few dozen roundings, beyond the ends of numbers that grow
            np.testing.assert_allclose(found, peer(x), rtol=1e-11, atol=1e-12)


def test_weights_reproduce_a_polynomial() -> None:
    nodes = (-10.0, 8.0, 27.0)
    values = np.array(nodes) ** 2 - 3.0 * np.array(nodes)
    assert lagrange_weights(nodes, 15.0) @ values == pytest.approx(15.0**2 - 45.0)


def test_weights_are_not_to_be_written_to() -> None:
    with pytest.raises(ValueError, match="read-only"):
        lagrange_weights((0.0, 1.0), 0.5)[0] = 1.0
