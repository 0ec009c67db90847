"""Equation (5): exact convergence, rounding as codes are written, and what stays blocked."""

from __future__ import annotations

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.rover.online_map import unknown_map

COSTS = np.array([[1, 9], [0, 3]])


def test_delays_approach_geometrically() -> None:
    found = unknown_map(COSTS, 5.0, 0.25)
    for n in range(1, 12):
        found.learn((0, 1), 9.0)
        assert found.delays[0, 1] == pytest.approx(9.0 - 4.0 * 0.75**n, rel=1e-12)
    assert found.error(COSTS) == pytest.approx(4.0 * 0.75**11)
    assert found.updates.tolist() == [[0, 11], [0, 0]]


def test_a_rate_of_one_learns_at_once() -> None:
    found = unknown_map(COSTS, 5.0, 1.0)
    found.learn((0, 0), 1.0)
    assert found.codes().tolist() == [[1, 5], [0, 5]]
    assert found.error(COSTS) == 0.0


def test_codes_are_rounded_and_never_block() -> None:
    found = unknown_map(np.ones((1, 4), dtype=np.int64), 1.0, 1.0)
    for column, cost in enumerate((2.51, 2.49, 0.2, 1.0)):
        found.learn((0, column), cost)
    assert found.codes().tolist() == [[3, 2, 1, 1]]


def test_blocked_cells_stay_so() -> None:
    found = unknown_map(COSTS, 5.0, 0.5)
    found.learn((1, 0), 9.0)
    assert found.codes()[1, 0] == 0
    assert found.updates[1, 0] == 0
    assert np.isnan(found.error(COSTS))


@pytest.mark.parametrize(
    ("prior", "rate", "says"), [(5, 0, "learn: 0"), (5, 1.5, "learn"), (0, 1, "prior: 0")]
)
def test_bad_numbers_are_refused(prior: float, rate: float, says: str) -> None:
    with pytest.raises(ParameterError, match=says):
        unknown_map(COSTS, prior, rate)
