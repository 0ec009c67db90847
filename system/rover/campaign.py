"""What silicon costs a plan: regret of a chip's paths against Dijkstra's, over dies and conditions.

A die's axon delays and the delays of its inputs order the spikes; the path that its pointers give is the
cheapest on those delays, not on the map. Its regret is the true cost above the lowest. For each condition
(bias kind, unit delay, temperature, area of the devices) the same routes are planned on the same dies:

- `regret`: share of the lowest cost, a mean over routes for each die, then over dies; bootstrap interval;
- `optimal`: share of dies on which every route is as cheap as can be; interval of Clopper and Pearson;
- `paths_optimal`: share of all paths that are.

Dies whose silicon lies outside the chip's record are counted and left out. Source of the question: Hwu et al.
2018, IV.B, which takes exact delay lines for granted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from chips.wavefront.axon_graph import AxonGraph, grid_graph
from chips.wavefront.kernel import graph_waves
from chips.wavefront.model import chip_model, dies_delays
from circuits.arrays import F64, I64
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.rover.cost_map import CostMap, check_codes
from system.rover.search import dijkstra
from system.study.statistics.interval import EVERYTHING, Estimate, Interval, clopper_pearson, mean_interval


@dataclass(frozen=True, slots=True)
class Case:
    """A condition: bias kind, unit delay (s), temperature (degC), area of devices over the design's."""

    bias_kind: BiasKind = "gate"
    unit: float = 100e-6
    temperature_c: float = 27.0
    area: float = 1.0

    def __str__(self) -> str:
        return f"{self.bias_kind}, {1e6 * self.unit:g} us, {self.temperature_c:g} degC, area x{self.area:g}"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a condition gave on all dies and routes.

    worst: largest regret of a path, as a share of its lowest cost; nominal: share of paths optimal on the
    nominal die, NaN where that is outside; unit: mean delay of a unit of cost over the dies, s, and spread:
    standard deviation of a cell's delay from its die's mean, relative, both at the map's lowest cost;
    outside: dies left out. Estimates are NaN where all are.

    case : the condition.
    """

    case: Case
    regret: Estimate
    optimal: Estimate
    paths_optimal: float
    worst: float
    nominal: float
    unit: float
    spread: float
    outside: int


def run_case(
    case: Case, cost_map: CostMap, routes: I64, dies: Sequence[Die], random: np.random.Generator
) -> Outcome:
    """Plan all routes on all dies under one condition.

    routes: int64[routes, 2, 2] of (row, column), start and goal; random: of the bootstrap.
    """
    graph, lowest = grid_graph(*cost_map.shape), lowest_costs(cost_map, routes)
    nominal = _cell_delays(case, cost_map, [NOMINAL])
    on_nominal = float((regrets(cost_map, graph, nominal, routes) == 0).mean()) if len(nominal) else math.nan
    table = _cell_delays(case, cost_map, dies)
    if not len(table):
        nothing = Estimate(math.nan, EVERYTHING)
        return Outcome(case, nothing, nothing, math.nan, math.nan, on_nominal, math.nan, math.nan, len(dies))
    share = regrets(cost_map, graph, table, routes) / lowest
    by_die, passed = share.mean(axis=1), int((share == 0.0).all(axis=1).sum())
    unit, spread = _unit(cost_map, table)
    return Outcome(
        case,
        Estimate(float(by_die.mean()), _not_below_zero(mean_interval(by_die, random))),
        Estimate(passed / len(table), clopper_pearson(passed, len(table))),
        float((share == 0.0).mean()),
        float(share.max()),
        on_nominal,
        unit,
        spread,
        len(dies) - len(table),
    )


def _cell_delays(case: Case, cost_map: CostMap, dies: Sequence[Die]) -> F64:
    """Delays of each cell's axon and the input that it reaches, s, on those dies that the record covers.

    float64[dies, cells]. Raises `ParameterError` for a cost without a code, and a unit or area that is none.
    """
    check_codes(cost_map)
    model = chip_model(cost_map.shape, bias_kind=case.bias_kind, unit=case.unit, area=case.area)
    silicon, kept = Silicon(AMI_1500_IDEAL, temperature_c=case.temperature_c), []
    for die in dies:
        with suppress(ParameterError):
            kept.append(dies_delays(model, silicon, cost_map.costs, [die])[0])
    return np.array(kept).reshape(-1, cost_map.costs.size)


def regrets(cost_map: CostMap, graph: AxonGraph, delays: F64, routes: I64) -> I64:
    """Regret of each route on each die, int64[dies, routes], in units of cost.

    graph: the grid of the map; delays: float64[dies, cells], s, inf for blocked cells.
    Raises `ParameterError` where a route has no path.
    """
    lowest = lowest_costs(cost_map, routes)
    edges = delays[:, graph.sources()]
    found = np.empty((len(delays), len(routes)), dtype=np.int64)
    for k, (start, goal) in enumerate(routes.tolist()):
        found[:, k] = _path_costs(cost_map.costs, graph, edges, start, goal) - lowest[k]
    return found


def lowest_costs(cost_map: CostMap, routes: I64) -> I64:
    """Cost of the cheapest path of each route, int64[routes], its goal included.

    Raises `ParameterError` where a route has no path.
    """
    costs = []
    for k, (start, goal) in enumerate(routes.tolist()):
        reached = dijkstra.distances(cost_map.costs, tuple(start))[tuple(goal)]
        if not math.isfinite(reached):
            raise ParameterError(f"routes[{k}]: no way from {start} to {goal}; choose another route")
        costs.append(int(reached) + int(cost_map.costs[tuple(goal)]))
    return np.array(costs, dtype=np.int64)


def first_failure(outcomes: Sequence[Outcome], share: float) -> Outcome | None:
    """The first condition, in the order given, whose share of optimal paths is below `share`."""
    return next((o for o in outcomes if o.paths_optimal < share), None)


def _path_costs(costs: I64, graph: AxonGraph, edges: F64, start: list[int], goal: list[int]) -> I64:
    """True cost of the path that each die's pointers give, int64[dies]."""
    columns, flat = costs.shape[1], costs.ravel()
    first, last = start[0] * columns + start[1], goal[0] * columns + goal[1]
    waves = graph_waves(graph, edges, first, last, flat == 0, threads=1)
    total = np.empty(len(edges), dtype=np.int64)
    for die, pointers in enumerate(waves.pointers):
        before = graph.predecessors(pointers)
        cell, total[die] = last, flat[last]
        while cell != first:
            cell = int(before[cell])
            total[die] += flat[cell]
    return total


def _unit(cost_map: CostMap, delays: F64) -> tuple[float, float]:
    """Mean delay of a unit of cost, s, and relative spread on a die, at the lowest cost of the map."""
    flat = cost_map.costs.ravel()
    low = int(flat[flat > 0].min())
    cells = delays[:, flat == low]
    relative = cells / cells.mean(axis=1, keepdims=True)
    return float(cells.mean()) / low, float(relative.std())


def _not_below_zero(interval: Interval) -> Interval:
    """No regret is below zero, whatever a bootstrap says."""
    return Interval(max(interval.low, 0.0), interval.high)
