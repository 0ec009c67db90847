"""Read-out of a path from a wave, by pointers of first arrivals.

Each cell's latch has kept which of its inputs came first. The path is followed from the goal back; no list
of events is needed. The paper's walk (Hwu et al. 2018, section II.C) is in `chips.wavefront.paper_walk`.

With exact delays the path has the least cost: the sum of the costs of all cells but the goal. Paths are
int64 [n, 2] of (row, column) on a grid, int64[n] of cells on a graph, start first; the path of a start that
is the goal is that cell alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from chips.wavefront.axon_graph import NEIGHBOURS, AxonGraph
from circuits.arrays import I8, I64
from circuits.errors import DataError, ParameterError

Cell = tuple[int, int]  # row, column
C = TypeVar("C")


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
