"""Dijkstra's algorithm (1959) on a grid of costs, by scipy: the reference that paths are held against.

Leaving a cell takes its cost, to any of its eight neighbours alike; a path from start to goal takes the costs
of all its cells but the goal. Blocked cells are neither entered nor left.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from chips.wavefront.axon_graph import grid_graph
from circuits.arrays import F64, I64

_NOWHERE = -9999  # scipy's predecessor of a node without one


def grid_edges(costs: I64) -> csr_array:
    """Edges of a grid int64[rows, columns]: float64[cells, cells], the cost of the cell that is left."""
    graph = grid_graph(*costs.shape)
    cost, tails = costs.ravel(), graph.sources()
    free = (cost[tails] > 0) & (cost[graph.targets] > 0)
    tails, heads = tails[free], graph.targets[free]
    return csr_array((cost[tails].astype(np.float64), (tails, heads)), shape=(costs.size, costs.size))


def distances(costs: I64, start: tuple[int, int]) -> F64:
    """Cost of reaching each cell from `start`, the goal's own left out; infinite where none leads."""
    first = start[0] * costs.shape[1] + start[1]
    return np.asarray(dijkstra(grid_edges(costs), indices=first)).reshape(costs.shape)


def plan(costs: I64, start: tuple[int, int], goal: tuple[int, int]) -> I64 | None:
    """Return the cheapest path, int64[n, 2] of (row, column), start first; None where none leads."""
    columns = costs.shape[1]
    first, last = start[0] * columns + start[1], goal[0] * columns + goal[1]
    _, before = dijkstra(grid_edges(costs), indices=first, return_predecessors=True)
    cells = [last]
    while cells[-1] != first:
        cells.append(int(before[cells[-1]]))
        if cells[-1] == _NOWHERE:
            return None
    return np.stack(np.divmod(np.array(cells[::-1], dtype=np.int64), columns), axis=1)
