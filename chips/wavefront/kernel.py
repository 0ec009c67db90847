"""A wave of spikes in continuous time: when each cell fires, and which of its inputs came first.

A cell fires once, at t_i = min_j (t_j + D_ij) over its neighbours j, so that the arrivals are Dijkstra's
distances. Three forms, by what D is: an integer cost of the sender on a grid, a real-valued delay of the
sender on a grid, a delay of its own for each axon of any graph.

Arrivals are inf where a cell does not fire. A pointer is the number of the input that came first, the
lowest where several came together, and -1 at the start and where a cell does not fire; `ties` counts the
cells where several did. With a goal the wave stops at the goal's spike: what would fire later has not
fired, what fires at that very instant has. A blocked cell never fires; from a blocked start nothing does.
Where start and goal are one, only the start has fired, at 0.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from chips.wavefront.axon_graph import AxonGraph, grid_graph
from chips.wavefront.wave import edges as wave_edges
from chips.wavefront.wave import real as wave_real
from chips.wavefront.wave.integer import HIGHEST_COST, LONGEST, REFUSED, spread, work_size
from circuits.arrays import F64, I8, I64, Bools
from circuits.errors import ParameterError

Cell = tuple[int, int]  # row, column

_I64, _I32, _I8, _F64 = (np.dtype(t) for t in (np.int64, np.int32, np.int8, np.float64))


class Wave(NamedTuple):
    """A wave over a grid or a graph.

    Attributes
    ----------
    arrivals : array
        When each cell fired, float64[rows, columns] or float64[cells], in the unit of the delays; inf where
        it did not.
    pointers : array
        Input by which each cell was fired first, int8 of the same shape; below 0 for none.
    ties : int
        How many ties there were.
    """

    arrivals: F64
    pointers: I8
    ties: int


class Waves(NamedTuple):
    """Waves of several dies: arrivals and pointers, [dies, cells], and ties, int64[dies]."""

    arrivals: F64
    pointers: I8
    ties: I64


def integer_wave(costs: NDArray[np.integer], start: Cell, goal: Cell | None = None) -> Wave:
    """Run a wave over a grid whose delays are integer costs of the sending cell.

    It takes 17 bytes a cell beside the costs.

    Parameters
    ----------
    costs
        Costs from 1 to 4095, 0 for a blocked cell, int[rows, columns]; the highest times the number of cells
        is below 2**31.
    start, goal
        Row and column of the cell that fires first, and of that at which the wave ends; None for no goal.

    Returns
    -------
    The wave; its arrivals are in units of cost, and exact.

    Raises
    ------
    ParameterError
        Costs are others, or start or goal is off the grid.
    """
    if costs.ndim != 2 or costs.dtype.kind not in "iub":
        raise _array_error("costs", costs, "integers")
    whole = np.ascontiguousarray(costs, _I32 if costs.dtype == _I32 else _I64)
    shape = whole.shape
    first, last, arrivals, pointers = _begun(shape, start, goal)
    ties = spread(whole, np.empty(work_size(*shape), _I32), arrivals, pointers, first, last)
    if ties == REFUSED:
        raise _cost_error(whole)
    return Wave(arrivals, pointers, ties)


def real_wave(delays: F64, start: Cell, goal: Cell | None = None) -> Wave:
    """Run a wave over a grid whose delays are those of the sending cell, float64[rows, columns].

    Delays are above 0, inf for a blocked cell; arrivals are in their unit. It takes 29 bytes a cell beside
    the delays; where the largest is more than 4,000 times the smallest, it runs as `graph_wave`. Raises
    `ParameterError` for other delays, and where start or goal is off the grid.
    """
    if delays.ndim != 2 or delays.dtype.kind not in "iubf":
        raise _array_error("delays", delays, "numbers")
    delays = np.ascontiguousarray(delays, _F64)
    shape = delays.shape
    first, last, arrivals, pointers = _begun(shape, start, goal)
    padded = (shape[0] + 2) * (shape[1] + 1) + 2
    work = np.empty(padded + wave_real.BUCKETS, _I32)
    ties = wave_real.spread(delays, np.empty((2, padded), _F64), work, arrivals, pointers, first, last)
    if ties == wave_real.REFUSED:
        raise _delay_error(delays)
    if ties == wave_real.TOO_WIDE:
        graph, flat = grid_graph(*shape), delays.ravel()
        wave = graph_wave(graph, flat[graph.sources()], first, None if goal is None else last, np.isinf(flat))
        return Wave(wave.arrivals.reshape(shape), wave.pointers.reshape(shape), wave.ties)
    return Wave(arrivals, pointers, ties)


def graph_wave(
    graph: AxonGraph,
    delays: F64,
    start: int,
    goal: int | None = None,
    blocked: Bools | None = None,
) -> Wave:
    """Run a wave over a graph of n cells with a delay of each axon.

    It takes 18 bytes a cell beside the graph and its delays.

    graph: cells and axons. delays: delay of each axon in the graph's order, above 0, inf where no spike
    passes, float64[edges]; s, or any other unit, in which the arrivals are then. start, goal: number of the
    cell that fires first, and of that at which the wave ends; None for no goal. blocked: whether a cell never
    fires, bool[n]; none unless given.

    Raises `ParameterError` for other delays, and where start or goal is no cell.
    """
    given = np.ascontiguousarray(delays, _F64)
    waves = _new_waves(1, graph.cells)
    _run_dies(graph, given.reshape(1, -1), waves, _mask(blocked, graph.cells), _ends(graph, start, goal))
    return Wave(waves.arrivals[0], waves.pointers[0], int(waves.ties[0]))


def graph_waves(
    graph: AxonGraph,
    delays: F64,
    start: int,
    goal: int | None = None,
    blocked: Bools | None = None,
    threads: int | None = None,
) -> Waves:
    """Run the wave of `graph_wave` on many dies; delays: float64[dies, edges].

    threads: how many share the dies, all cores if None; the answer does not depend on it.
    """
    given = np.ascontiguousarray(delays, _F64)
    dies, mask, ends = len(given), _mask(blocked, graph.cells), _ends(graph, start, goal)
    waves = _new_waves(dies, graph.cells)
    count = max(1, min(threads or os.cpu_count() or 1, dies))
    parts = [slice(dies * k // count, dies * (k + 1) // count) for k in range(count)]

    def run(part: slice) -> None:
        mine = Waves(waves.arrivals[part], waves.pointers[part], waves.ties[part])
        _run_dies(graph, given[part], mine, mask, ends)

    with ThreadPoolExecutor(count) as executor:
        list(executor.map(run, parts))
    return waves


def _run_dies(graph: AxonGraph, delays: F64, waves: Waves, blocked: Bools, ends: tuple[int, int]) -> None:
    """Fill the waves of dies one after another."""
    if delays.shape[1] != graph.edges:
        raise ParameterError(
            f"plan.delays: {delays.shape[1]} on a die, must be {graph.edges}; give one for each axon"
        )
    work = np.empty(2 * graph.cells + 2 * wave_edges.BUCKETS, _I32)
    axons = graph.offsets, graph.targets, graph.inputs
    found = waves.arrivals, waves.pointers, waves.ties
    if wave_edges.spread_dies(axons, delays, blocked, found, work, ends):
        return
    for die in np.flatnonzero(waves.ties < 0):
        if waves.ties[die] == wave_edges.REFUSED:
            raise _delay_error(delays[die])
        waves.ties[die] = _by_heap(
            graph, delays[die], blocked, waves.arrivals[die], waves.pointers[die], ends
        )


def _new_waves(dies: int, cells: int) -> Waves:
    return Waves(np.empty((dies, cells), _F64), np.empty((dies, cells), _I8), np.empty(dies, _I64))


def _mask(blocked: Bools | None, cells: int) -> Bools:
    return np.zeros(cells, np.bool_) if blocked is None else np.ascontiguousarray(blocked, np.bool_).ravel()


def _ends(graph: AxonGraph, start: int, goal: int | None) -> tuple[int, int]:
    """Start and goal, checked, the goal -1 for none."""
    for name, cell in (("start", start), ("goal", start if goal is None else goal)):
        if not 0 <= cell < graph.cells:
            raise ParameterError(
                f"plan.{name}: cell {cell}, must be 0 to {graph.cells - 1}; cells count from 0"
            )
    return int(start), -1 if goal is None else int(goal)


def _by_heap(
    graph: AxonGraph, delays: F64, blocked: Bools, arrivals: F64, pointers: I8, ends: tuple[int, int]
) -> int:
    edges = graph.offsets, graph.targets, graph.inputs, delays
    heap, keys = np.empty(graph.edges + 1, _I32), np.empty(graph.edges + 1, _F64)
    return wave_edges.spread_by_heap(edges, blocked, arrivals, pointers, heap, keys, ends)


def _delay_error(delays: F64) -> ParameterError:
    where = tuple(int(k) for k in np.argwhere(~(delays > 0.0))[0])
    return ParameterError(
        f"delays[{', '.join(map(str, where))}]: {delays[where]:g}, must be > 0; use inf for a blocked cell"
    )


def _begun(shape: tuple[int, ...], start: Cell, goal: Cell | None) -> tuple[int, int, F64, I8]:
    """Numbers of start and goal, checked, the goal -1 for none; arrays that a wave over a grid fills."""
    rows, columns = shape
    first = _number(start, "start", (rows, columns))
    last = -1 if goal is None else _number(goal, "goal", (rows, columns))
    return first, last, np.empty(shape, _F64), np.empty(shape, _I8)


def _number(cell: Cell, name: str, shape: tuple[int, ...]) -> int:
    row, column = cell
    rows, columns = shape
    if 0 <= row < rows and 0 <= column < columns:
        return row * columns + column
    raise ParameterError(
        f"plan.{name}: ({row}, {column}), must be on the grid of {rows} x {columns}; both count from 0"
    )


def _array_error(name: str, values: NDArray[np.generic], what: str) -> ParameterError:
    given = f"{values.dtype} with {values.ndim} dimensions"
    return ParameterError(f"{name}: {given}, must be {what} with 2, rows and columns; convert them")


def _cost_error(costs: NDArray[np.integer]) -> ParameterError:
    highest = min(HIGHEST_COST, LONGEST // costs.size)
    row, column = (int(k) for k in np.argwhere((costs < 0) | (costs > highest))[0])
    return ParameterError(
        f"costs[{row}, {column}]: {costs[row, column]}, must be 0 to {highest} on {costs.size} cells;"
        " scale the costs, or use real-valued delays"
    )
