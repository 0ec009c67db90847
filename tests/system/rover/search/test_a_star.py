"""The paper's A* as it is read, by hand, and an admissible one against Dijkstra on maps with walls."""

from __future__ import annotations

import numpy as np
import pytest

from system.rover.cost_map import CostMap, load_map
from system.rover.planner import Planner, path_cost, plan_path
from system.rover.search.a_star import plan_admissible, plan_paper


def test_the_papers_a_star_keeps_to_the_straight_way() -> None:
    # It never adds costs up, so that a road beside the straight line is not worth its detour to it.
    park = load_map("map1-road")
    plan = plan_path(park, (2, 10), (19, 10), plan_paper)
    assert plan.length == 18
    assert plan.regret > 0


def test_the_papers_a_star_by_hand() -> None:
    # From (0, 0) to (0, 3). The direct neighbour (0, 1) costs f = 1 + 2 + 9, (1, 1) costs
    # sqrt(2) + sqrt(5) + 1 = 4.65, (1, 0) costs 1 + sqrt(10) + 1 = 5.16; then (1, 2): sqrt(5) + sqrt(2) + 1,
    # which places (0, 3) on the list at f = 3 + 0 + 1.
    costs = np.array([[1, 9, 9, 1], [1, 1, 1, 1]])
    plan = plan_path(CostMap("hand", costs), (0, 0), (0, 3), plan_paper)
    assert plan.path.tolist() == [[0, 0], [1, 1], [1, 2], [0, 3]]


def test_of_equal_costs_the_one_placed_first_is_taken() -> None:
    # (0, 1) and (2, 1) are mirror images; N comes before S in the order of neighbours
    costs = np.array([[9, 1, 9], [1, 0, 1], [9, 1, 9]])
    found = plan_paper(costs, (1, 0), (1, 2))
    assert found is not None
    assert found.tolist() == [[1, 0], [0, 1], [1, 2]]


@pytest.mark.parametrize("planner", [plan_paper, plan_admissible])
def test_a_wall_leaves_no_path(planner: Planner) -> None:
    assert planner(np.array([[1, 0, 1]]), (0, 0), (0, 2)) is None
    lone = planner(np.array([[1]]), (0, 0), (0, 0))
    assert lone is not None
    assert lone.tolist() == [[0, 0]]


def test_the_heuristic_does_not_overestimate_diagonal_ways() -> None:
    # nine diagonal moves cost 9; an octile or Euclidean distance of 12.7 would make it take another way
    costs = np.full((10, 10), 2)
    np.fill_diagonal(costs, 1)
    found = plan_admissible(costs, (0, 0), (9, 9))
    assert found is not None
    assert path_cost(costs, found) == 10
