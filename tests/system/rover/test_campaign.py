"""Regret over dies: nothing lost on exact delays, less with area, and what lies outside the record."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from chips.wavefront.axon_graph import grid_graph
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.rover.campaign import Case, Outcome, first_failure, lowest_costs, regrets, run_case
from system.rover.cost_map import CostMap, load_map, random_pairs
from system.rover.planner import plan_path, planner_named

PARK = load_map("map1-road-obstacles")
ROUTES = random_pairs(PARK, 6, np.random.default_rng(1))
DIES = [Die("A", k) for k in range(12)]


def outcome(case: Case) -> Outcome:
    return run_case(case, PARK, ROUTES, DIES, np.random.default_rng(0))


def test_lowest_costs_are_the_planners() -> None:
    plans = [plan_path(PARK, tuple(a), tuple(b), planner_named("wave")) for a, b in ROUTES.tolist()]
    assert lowest_costs(PARK, ROUTES).tolist() == [plan.cost for plan in plans]


def test_delays_that_are_costs_have_no_regret() -> None:
    exact = PARK.costs.ravel()[None] * np.array([[1.0], [1e-4]])
    assert not regrets(PARK, grid_graph(20, 20), exact, ROUTES).any()


def test_delays_that_are_alike_take_the_fewest_cells() -> None:
    # a chip that ignores its codes: its paths cost what the shortest ways cost at best
    found = regrets(PARK, grid_graph(20, 20), np.ones((1, 400)), np.array([[[2, 10], [19, 10]]]))
    assert found[0, 0] > 0


def test_area_buys_optimal_paths() -> None:
    found = [outcome(Case(area=area)) for area in (0.5, 2.0, 16.0)]
    spreads = [each.spread for each in found]
    # sigma follows 1 / sqrt(area): V_T0 of the sink is nearly all of it; 12 dies of 50 road cells know each
    # spread to 1 / sqrt(1200) = 3 %
    assert spreads[0] / spreads[2] == pytest.approx(np.sqrt(32.0), rel=0.12)
    assert all(a.regret.value >= b.regret.value for a, b in pairwise(found))
    assert found[-1].regret.value == 0.0
    assert found[-1].optimal.value == 1.0
    assert found[-1].optimal.interval.low < 1.0


def test_estimates_hold_together() -> None:
    found = outcome(Case(area=0.5))
    assert found.regret.interval.low <= found.regret.value <= found.regret.interval.high
    assert found.optimal.value <= found.paths_optimal <= 1.0
    assert found.worst >= found.regret.value
    assert found.outside == 0
    assert found.nominal == 1.0


def test_dies_outside_the_record_are_counted() -> None:
    found = outcome(Case(area=1 / 64))
    assert found.outside == len(DIES)
    assert np.isnan(found.regret.value)
    assert found.nominal == 1.0


def test_the_first_failure_is_found() -> None:
    good = outcome(Case(area=16.0))
    bad = replace(good, paths_optimal=0.9)
    assert first_failure([good, bad], 1.0) is bad
    assert first_failure([good], 1.0) is None


def test_costs_without_a_code_and_walls_are_refused() -> None:
    high = CostMap("high", np.full((8, 8), 32))
    with pytest.raises(ParameterError, match="must be at most 31"):
        run_case(Case(), high, np.array([[[0, 0], [7, 7]]]), DIES, np.random.default_rng(0))
    wall = CostMap("wall", np.array([[1, 0, 1]]))
    with pytest.raises(ParameterError, match=r"^routes\[0\]: no way from \[0, 0\] to \[0, 2\]"):
        lowest_costs(wall, np.array([[[0, 0], [0, 2]]]))
