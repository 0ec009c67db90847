"""Distances on a grid, against Bellman's equation, and the path that goes with them."""

from __future__ import annotations

import numpy as np
import pytest

from chips.wavefront.axon_graph import NEIGHBOURS
from system.rover.search.dijkstra import distances, plan


@pytest.mark.parametrize("seed", range(5))
def test_bellmans_equation_holds(seed: int) -> None:
    random = np.random.default_rng(seed)
    costs = random.integers(0, 9, (7, 11))
    costs[3, 4] = 1
    found = distances(costs, (3, 4))
    assert found[3, 4] == 0.0
    for r, c in np.argwhere(costs > 0).tolist():
        near = [(r + a, c + b) for a, b in NEIGHBOURS if 0 <= r + a < 7 and 0 <= c + b < 11]
        best = min(found[cell] + costs[cell] for cell in near if costs[cell] > 0) if near else np.inf
        assert (r, c) == (3, 4) or found[r, c] == best
    assert np.isinf(found[costs == 0]).all()


def test_the_path_costs_its_distance() -> None:
    costs = np.random.default_rng(9).integers(1, 32, (15, 9))
    found = plan(costs, (0, 0), (14, 8))
    assert found is not None
    assert costs[found[:-1, 0], found[:-1, 1]].sum() == distances(costs, (0, 0))[14, 8]
    assert plan(np.array([[1, 0, 1]]), (0, 0), (0, 2)) is None
