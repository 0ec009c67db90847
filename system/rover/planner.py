"""Planners of paths on a cost map, and how the paths that they find are counted.

Length is the number of cells of a path, cost the sum of the map over them, start and goal included in both.
So counted, the paper's map of one cost gives 8.5 cells and 3 x 8.5 = 25.5 (Hwu et al. 2018, Table I, first
row), which says that both run over the same cells; that these are all of them is ours. Leaving one end out
of both would move every path of a pair of places by the same constant and no comparison.

Regret is the cost above that of Dijkstra's path.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from circuits.arrays import I64
from circuits.errors import ParameterError, unknown_name
from system.rover.cost_map import Cell, CostMap, check_cell
from system.rover.search import a_star, dijkstra
from system.rover.wave_planner import plan_discrete, plan_ideal

Planner = Callable[[I64, Cell, Cell], I64 | None]  # costs, start, goal -> path, int64[n, 2]

PLANNERS: Mapping[str, Planner] = {
    "wave": plan_ideal,
    "paper": plan_discrete,
    "a-star": a_star.plan_paper,
    "admissible-a-star": a_star.plan_admissible,
    "dijkstra": dijkstra.plan,
}


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A path on a map, and what it costs.

    Attributes
    ----------
    path : array
        Row and column of each cell, int64[n, 2], start first.
    cost : int
        Sum of the costs of its cells.
    optimal_cost : int
        The lowest cost of any path from start to goal.
    """

    path: I64
    cost: int
    optimal_cost: int

    @property
    def length(self) -> int:
        """Number of cells of the path."""
        return len(self.path)

    @property
    def regret(self) -> int:
        """Cost of the path above the lowest that there is."""
        return self.cost - self.optimal_cost


def planner_named(name: str) -> Planner:
    """Return one of `PLANNERS` by its name; raises `UnknownNameError` for another name."""
    if name not in PLANNERS:
        raise unknown_name("planner", name, PLANNERS)
    return PLANNERS[name]


def plan_path(cost_map: CostMap, start: Cell, goal: Cell, planner: Planner) -> Plan:
    """Plan a path on a map and count what it costs.

    Parameters
    ----------
    cost_map
        The map.
    start, goal
        Row and column of the first and the last cell.
    planner
        What plans (`planner_named`).

    Raises
    ------
    ParameterError
        Start or goal is off the map or blocked, or no way leads from one to the other.
    """
    check_cell(cost_map, start, "start")
    check_cell(cost_map, goal, "goal")
    best = dijkstra.plan(cost_map.costs, start, goal)
    if best is None:
        raise ParameterError(
            f"goal: {goal[0]},{goal[1]}, must be reachable from {start[0]},{start[1]}; blocked cells of"
            f" {cost_map.name} lie between"
        )
    return judge(cost_map.costs, planner(cost_map.costs, start, goal), path_cost(cost_map.costs, best))


def judge(costs: I64, path: I64 | None, optimal_cost: int) -> Plan:
    """Count a path that a planner found; raises `ParameterError` where it found none."""
    if path is None:
        raise ParameterError(
            "planner: found no path although there is one, as the paper's may where neurons fire again"
            " before a long delay has passed; use `planner=wave`"
        )
    return Plan(path, path_cost(costs, path), optimal_cost)


def path_cost(costs: I64, path: I64) -> int:
    """Return the sum of the map's costs over all cells of a path."""
    return int(costs[path[:, 0], path[:, 1]].sum())
