"""Read-out of a path from a wave: by pointers of first arrivals, or by a causal walk over the spikes.

- Pointers: each cell's latch has kept which of its inputs came first. The path is followed from the goal
  back; no list of events is needed.
- Causal walk of the AER table: from the spike of cell i at t_i go to the neighbour j whose spike, after its
  delay, arrived then, t_j + D_j = t_i within a tolerance. Of several the nearest in time counts, then the
  lowest neighbour number. Every step goes back in time, so the walk ends.
- The paper's walk (Hwu et al. 2018, section II.C) is in `chips.wavefront.paper_walk`.

With exact delays both give paths of least cost: the sum of the costs of all cells but the goal. Paths are
int64 [n, 2] of (row, column) on a grid, int64[n] of cells on a graph, start first; the path of a start that
is the goal is that cell alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from chips.wavefront.axon_graph import NEIGHBOURS, AxonGraph
from circuits.arrays import F64, I8, I64
from circuits.errors import DataError, ParameterError

Cell = tuple[int, int]  # row, column
C = TypeVar("C")

TOLERANCE = 1e-9  # relative to the larger time: rounding of sums of real delays


class UnreachableError(ParameterError):
    """No path leads from the start to the goal."""


def unreachable(start: object, goal: object) -> UnreachableError:
    """Return the error for a goal that no spike reached."""
    return UnreachableError(
        f"plan.goal: {goal} has no spike from {start}, must be reachable; unblock a way, or choose another"
    )


def pointer_path(pointers: I8, start: Cell, goal: Cell) -> I64:
    """Return the path by the pointers of a wave over a grid, int64[n, 2], rows and columns.

    Raises `UnreachableError` where the goal has not fired.

    Parameters
    ----------
    pointers
        Pointers of the wave, int8[rows, columns].
    start, goal
        Row and column of the first and the last cell.
    """

    def before(cell: Cell) -> Cell | None:
        k = int(pointers[cell])
        return None if k < 0 else (cell[0] + NEIGHBOURS[k][0], cell[1] + NEIGHBOURS[k][1])

    if start != goal and pointers[goal] < 0:
        raise unreachable(start, goal)
    return np.array(_follow(before, start, goal, pointers.size), dtype=np.int64)


def pointer_nodes(graph: AxonGraph, pointers: I8, start: int, goal: int) -> I64:
    """Return the path by the pointers of a wave over a graph, int64[n]; pointers: int8[n].

    Raises `UnreachableError` where the goal has not fired.
    """
    predecessors = graph.predecessors(pointers)

    def before(cell: int) -> int | None:
        return None if predecessors[cell] < 0 else int(predecessors[cell])

    if start != goal and pointers[goal] < 0:
        raise unreachable(start, goal)
    return np.array(_follow(before, start, goal, graph.cells), dtype=np.int64)


def spike_times(times: F64, addresses: I64, cells: int) -> F64:
    """Return the first spike of each cell in a list of events, s, float64[cells], inf where there is none."""
    first = np.full(cells, np.inf)
    np.minimum.at(first, addresses, times)
    return first


def causal_path(times: F64, delays: F64, start: Cell, goal: Cell, tolerance: float = 0.0) -> I64:
    """Return the path by a causal walk over a grid, int64[n, 2].

    times: of first spikes, inf for none, float64[rows, columns]; delays: of the sending cells in the same
    unit, float64[rows, columns]; tolerance: of t_j + D_j against t_i in that unit, beside 1e-9 of t_i. Raises
    `UnreachableError` where the goal has no spike, and `DataError` where a spike has no cause.
    """
    rows, columns = times.shape

    def before(cell: Cell) -> Cell | None:
        near = [(cell[0] + down, cell[1] + right) for down, right in NEIGHBOURS]
        inside = [(r, c) for r, c in near if 0 <= r < rows and 0 <= c < columns]
        there = np.array([(times[c], times[c] + delays[c]) for c in inside]).reshape(-1, 2)
        k = _cause(there, float(times[cell]), tolerance)
        return None if k < 0 else inside[k]

    if not np.isfinite(times[goal]):
        raise unreachable(start, goal)
    return np.array(_follow(before, start, goal, times.size), dtype=np.int64)


def causal_nodes(
    graph: AxonGraph, times: F64, delays: F64, start: int, goal: int, tolerance: float = 0.0
) -> I64:
    """Return the path by a causal walk over a graph whose axons have delays of their own, int64[n].

    delays: float64[edges]; the other arguments are those of `causal_path`. Of several causes that are as near
    in time the lowest input counts.
    """
    order = np.lexsort((graph.inputs, graph.targets))
    sources, into = graph.sources()[order], delays[order]
    first = np.searchsorted(graph.targets[order], np.arange(graph.cells + 1))

    def before(cell: int) -> int | None:
        near = slice(first[cell], first[cell + 1])
        sent = times[sources[near]]
        k = _cause(np.column_stack((sent, sent + into[near])), float(times[cell]), tolerance)
        return None if k < 0 else int(sources[near][k])

    if not np.isfinite(times[goal]):
        raise unreachable(start, goal)
    return np.array(_follow(before, start, goal, graph.cells), dtype=np.int64)


def _cause(there: F64, time: float, tolerance: float) -> int:
    """Which of the neighbours' spikes float64[k, 2], sent and arrived, came at `time`; -1 for none."""
    off = np.where(there[:, 0] < time, np.abs(there[:, 1] - time), np.inf)
    if off.size == 0 or not off.min() <= tolerance + TOLERANCE * time:
        return -1
    return int(off.argmin())


def _follow(before: Callable[[C], C | None], start: C, goal: C, most: int) -> list[C]:
    """Cells from start to goal, each the one before the next."""
    path = [goal]
    while path[-1] != start:
        cell = before(path[-1])
        if cell is None or len(path) > most:
            raise DataError(
                f"plan.path: the spike of {path[-1]} has no cause, must come from a neighbour;"
                " raise the tolerance, or use the pointers"
            )
        path.append(cell)
    return path[::-1]
