"""Planners on grids: who is optimal, how paths are counted, and what has no path."""

from __future__ import annotations

import numpy as np
import pytest

from circuits.errors import ParameterError, UnknownNameError
from system.rover.cost_map import MAPS, CostMap, load_map
from system.rover.planner import PLANNERS, path_cost, plan_path, planner_named
from system.rover.search import dijkstra

OPTIMAL = ("wave", "admissible-a-star", "dijkstra")


def random_map(seed: int) -> CostMap:
    random = np.random.default_rng(seed)
    costs = random.integers(1, 32, random.integers(2, 12, 2))
    costs[random.random(costs.shape) < 0.2] = 0
    return CostMap("random", costs)


def is_a_path(costs: np.ndarray, path: np.ndarray) -> bool:
    steps = np.abs(np.diff(path, axis=0)).max(axis=1, initial=0) if len(path) > 1 else np.array([1])
    return bool((steps == 1).all() and (costs[path[:, 0], path[:, 1]] > 0).all())


@pytest.mark.parametrize("seed", range(25))
@pytest.mark.parametrize("name", [name for name in PLANNERS if name != "paper"])
def test_on_random_maps(name: str, seed: int) -> None:
    park = random_map(seed)
    free = np.argwhere(park.costs > 0)
    start, goal = (tuple(map(int, free[k])) for k in (0, -1))
    reach = dijkstra.distances(park.costs, start)[goal]  # type: ignore[index]
    if not np.isfinite(reach):
        with pytest.raises(ParameterError, match="must be reachable"):
            plan_path(park, start, goal, planner_named(name))  # type: ignore[arg-type]
        return
    plan = plan_path(park, start, goal, planner_named(name))  # type: ignore[arg-type]
    assert is_a_path(park.costs, plan.path)
    assert (tuple(plan.path[0]), tuple(plan.path[-1])) == (start, goal)
    assert plan.optimal_cost == reach + park.costs[goal]
    assert plan.cost == plan.optimal_cost if name in OPTIMAL else plan.cost >= plan.optimal_cost


@pytest.mark.parametrize("name", PLANNERS)
def test_start_is_goal(name: str) -> None:
    plan = plan_path(CostMap("one", np.array([[7]])), (0, 0), (0, 0), planner_named(name))
    assert plan.path.tolist() == [[0, 0]]
    assert (plan.length, plan.cost, plan.regret) == (1, 7, 0)


@pytest.mark.parametrize("name", PLANNERS)
def test_a_wall_is_refused(name: str) -> None:
    wall = CostMap("wall", np.array([[1, 0, 1], [1, 0, 1]]))
    with pytest.raises(
        ParameterError, match=r"^goal: 0,2, must be reachable from 0,0; blocked cells of wall"
    ):
        plan_path(wall, (0, 0), (0, 2), planner_named(name))
    with pytest.raises(ParameterError, match=r"^start: 0,1, must not be blocked"):
        plan_path(wall, (0, 1), (0, 2), planner_named(name))


def test_cost_over_length_is_the_maps_where_it_has_one_cost() -> None:
    # Table I, first row: length 8.5 and cost 25.5 on grass of cost 3
    lawn = load_map("map1-without-road")
    plan = plan_path(lawn, (10, 3), (10, 12), planner_named("wave"))
    assert (plan.length, plan.cost) == (10, 30)
    assert path_cost(lawn.costs, plan.path) == 30


def test_unknown_names_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="planner dijkstr: unknown; did you mean dijkstra"):
        planner_named("dijkstr")


def test_the_discrete_model_plans_on_the_shipped_maps_and_says_where_it_cannot() -> None:
    for name in MAPS:
        park = load_map(name)
        plan = plan_path(park, (5, 3), (15, 16), planner_named("paper"))
        assert is_a_path(park.costs, plan.path)
        assert plan.regret >= 0
    # beside short delays a neuron of a long one fires again and again, and loses what is under way
    slow = np.ones((6, 7), dtype=np.int64)
    slow[:, 3] = 25
    with pytest.raises(ParameterError, match=r"found no path although there is one.*use `planner=wave`"):
        plan_path(CostMap("slow", slow), (3, 0), (3, 6), planner_named("paper"))


def test_shipped_maps_have_routes_to_plan() -> None:
    for name in MAPS:
        costs = load_map(name).costs
        assert np.isfinite(dijkstra.distances(costs, (2, 10))).all()
