"""A* on a grid of costs, as Hwu et al. 2018 describe theirs (section II.D), and an admissible one.

The paper's: the cost of a cell is its Euclidean distance from the start, plus that to the goal, plus the cost
of traversing it,

    f(n) = |n - start| + |n - goal| + map(n)

Adjacent cells that were never on the node list are placed on it, and the cell of lowest cost is taken from it
and expanded, until it is the goal. So read here literally: nothing accumulates along the path (the distance
from the start is "as the crow flies"), a cell is placed on the list once and keeps the neighbour that placed
it as its parent, and of equal costs the one placed first is taken (neighbours in the order N, NE, E, SE, S,
SW, W, NW). These three are ours where the text is silent.

The admissible one adds to the cost so far the least that can remain: the smallest cost on the map times the
moves, which are the larger of the row and column distances because diagonal moves cost no more than others.
By networkx. Source: Hart, Nilsson and Raphael 1968.
"""

from __future__ import annotations

import heapq
import math

import networkx as nx
import numpy as np

from chips.wavefront.axon_graph import NEIGHBOURS
from circuits.arrays import I64
from system.rover.search.dijkstra import grid_edges

Cell = tuple[int, int]


def plan_paper(costs: I64, start: Cell, goal: Cell) -> I64 | None:
    """Return the path of the paper's A*, int64[n, 2], start first; None where none leads."""
    parents: dict[Cell, Cell] = {start: start}
    waiting = [(0.0, 0, start)]
    while waiting:
        _, _, cell = heapq.heappop(waiting)
        if cell == goal:
            return _walk(parents, goal)
        for down, right in NEIGHBOURS:
            found = cell[0] + down, cell[1] + right
            if found not in parents and _is_free(costs, found):
                parents[found] = cell
                cost = math.dist(found, start) + math.dist(found, goal) + float(costs[found])
                heapq.heappush(waiting, (cost, len(parents), found))
    return None


def plan_admissible(costs: I64, start: Cell, goal: Cell) -> I64 | None:
    """Return the path of lowest cost, int64[n, 2], start first; None where none leads."""
    columns = costs.shape[1]
    edges = grid_edges(costs)
    graph = nx.from_scipy_sparse_array(edges, create_using=nx.DiGraph)
    cheapest = float(edges.data.min()) if edges.nnz else 0.0

    def remaining(a: int, b: int) -> float:
        moves: int = max(abs(a // columns - b // columns), abs(a % columns - b % columns))
        return cheapest * moves

    first, last = start[0] * columns + start[1], goal[0] * columns + goal[1]
    try:
        cells = nx.astar_path(graph, first, last, heuristic=remaining)
    except nx.NetworkXNoPath:
        return None
    return np.stack(np.divmod(np.array(cells, dtype=np.int64), columns), axis=1)


def _walk(parents: dict[Cell, Cell], goal: Cell) -> I64:
    cells = [goal]
    while parents[cells[-1]] != cells[-1]:
        cells.append(parents[cells[-1]])
    return np.array(cells[::-1], dtype=np.int64)


def _is_free(costs: I64, cell: Cell) -> bool:
    rows, columns = costs.shape
    return 0 <= cell[0] < rows and 0 <= cell[1] < columns and bool(costs[cell] > 0)
