"""The axons of a wavefront chip as a graph: which cell reaches which, and at which of its inputs.

Cell j fires at t_j; each of its targets i that has not fired in this plan fires at the earliest of t_j +
D_ij. Edges are stored by sending cell (compressed rows), so that the axons of a cell lie side by side. On a
grid the eight inputs of a cell come from its neighbours N, NE, E, SE, S, SW, W, NW, numbered 0 to 7 (Hwu et
al. 2018, section II.A); row 0 is at the north, and cell (row, column) is number row * columns + column.
"""

from __future__ import annotations

from dataclasses import dataclass

import networkx as nx
import numpy as np

from circuits.arrays import F64, I8, I32, I64
from circuits.errors import ParameterError, TopologyError

NEIGHBOURS = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))  # (row, column) offsets
MOST_INPUTS = 126  # of a cell: input numbers are int8, and -1 is none
_MOST_CELLS = 2**28  # eight edges each must stay below 2**31


@dataclass(frozen=True, slots=True)
class AxonGraph:
    """Directed graph of n cells and e axons.

    Attributes
    ----------
    offsets
        Edges of cell j are offsets[j] to offsets[j + 1], int64[n + 1].
    targets
        Cell that each axon leads to, int32[e].
    inputs
        Number of the input at the target, int8[e].
    shape
        (rows, columns) of a grid, else None.
    """

    offsets: I64
    targets: I32
    inputs: I8
    shape: tuple[int, int] | None = None

    @property
    def cells(self) -> int:
        """Number n of cells."""
        return int(self.offsets.size - 1)

    @property
    def edges(self) -> int:
        """Number e of axons."""
        return int(self.targets.size)

    def sources(self) -> I32:
        """Return the sending cell of each edge, int32[e]."""
        return np.repeat(np.arange(self.cells, dtype=np.int32), np.diff(self.offsets))

    def predecessors(self, pointers: I8) -> I32:
        """Return the cell that each cell's pointer stands for, int32[n], -1 for none.

        Parameters
        ----------
        pointers
            An input of each cell, or -1, int8[n].
        """
        found = np.full(self.cells, -1, dtype=np.int32)
        first = self.inputs == pointers.ravel()[self.targets]
        found[self.targets[first]] = self.sources()[first]
        return found


def grid_graph(rows: int, columns: int) -> AxonGraph:
    """Return a grid of `rows` by `columns` cells, each joined to its up to eight neighbours.

    They come in the order of `NEIGHBOURS`. Raises `ParameterError` for a grid without cells, or with more
    than 2**28.
    """
    if rows < 1 or columns < 1 or rows * columns > _MOST_CELLS:
        raise ParameterError(
            f"grid.shape: {rows} x {columns}, must have 1 to {_MOST_CELLS} cells; change rows or columns"
        )
    row, column = np.arange(rows, dtype=np.int32)[:, None], np.arange(columns, dtype=np.int32)
    there = np.empty((rows, columns, len(NEIGHBOURS)), dtype=np.bool_)
    for k, (down, right) in enumerate(NEIGHBOURS):
        inside_row = (row + down >= 0) & (row + down < rows)
        there[:, :, k] = inside_row & (column + right >= 0) & (column + right < columns)
    offsets = np.zeros(rows * columns + 1, dtype=np.int64)
    np.cumsum(there.sum(axis=2).ravel(), out=offsets[1:])
    steps = np.array([down * columns + right for down, right in NEIGHBOURS], dtype=np.int32)
    back = (np.arange(len(NEIGHBOURS)) + 4) % len(NEIGHBOURS)  # the opposite direction, seen from the target
    targets = (row * np.int32(columns) + column)[:, :, None] + steps
    inputs = np.broadcast_to(back.astype(np.int8), there.shape)
    return AxonGraph(offsets, targets[there], inputs[there], (rows, columns))


def graph_of(graph: nx.DiGraph) -> AxonGraph:
    """Return the axons of a directed networkx graph, whose nodes are numbered in their own order.

    Parameters
    ----------
    graph
        The graph. Its edges are sorted by source, then target; the inputs of a cell are numbered in the
        order of their sources. An undirected edge is two axons.

    Raises
    ------
    TopologyError
        It is a multigraph, has no nodes, or more than 126 edges into a node.
    """
    if graph.is_multigraph():
        raise TopologyError(
            "graph.edges: a multigraph, must have one edge a pair; keep the cheapest of parallel edges"
        )
    if graph.number_of_nodes() == 0:
        raise TopologyError("graph.nodes: 0, must be > 0; add a node")
    source, target = _sorted_edges(graph)
    n = graph.number_of_nodes()
    fan_in = np.bincount(target, minlength=n)
    if fan_in.max() > MOST_INPUTS:
        name = list(graph)[int(fan_in.argmax())]
        raise TopologyError(
            f"graph.nodes[{name}]: {fan_in.max()} edges into it, must be <= {MOST_INPUTS}; split the node"
        )
    offsets = np.zeros(n + 1, dtype=np.int64)
    np.cumsum(np.bincount(source, minlength=n), out=offsets[1:])
    by_target = np.lexsort((source, target))
    first = np.cumsum(fan_in) - fan_in
    inputs = np.empty(target.size, dtype=np.int8)
    inputs[by_target] = np.arange(target.size) - first[target[by_target]]
    return AxonGraph(offsets, target.astype(np.int32), inputs)


def node_costs(graph: nx.DiGraph, attribute: str = "cost") -> F64:
    """Return the cost of each node, float64[n]; raises `ParameterError` where one has none."""
    costs = [data.get(attribute) for _, data in graph.nodes(data=True)]
    for name, cost in zip(graph, costs, strict=True):
        if cost is None:
            raise ParameterError(f"graph.nodes[{name}].{attribute}: missing, must be a number; set it")
    return np.array(costs, dtype=np.float64)


def edge_weights(graph: nx.DiGraph, attribute: str = "weight") -> F64:
    """Return the weight of each edge in the order of `graph_of`, float64[e].

    Raises `ParameterError` where an edge has none.
    """
    directed = graph.to_directed(as_view=True)
    names = list(graph)
    weights = []
    for i, j in zip(*_sorted_edges(graph), strict=True):
        weight = directed.edges[names[i], names[j]].get(attribute)
        if weight is None:
            text = f"graph.edges[{names[i]}, {names[j]}].{attribute}: missing, must be a number; set it"
            raise ParameterError(text)
        weights.append(weight)
    return np.array(weights, dtype=np.float64)


def _sorted_edges(graph: nx.DiGraph) -> tuple[I64, I64]:
    """Numbers of sources and targets, int64[e] each."""
    number = {name: k for k, name in enumerate(graph)}
    pairs = [(number[a], number[b]) for a, b in graph.to_directed(as_view=True).edges]
    found = np.array(sorted(pairs), dtype=np.int64).reshape(-1, 2)
    return found[:, 0], found[:, 1]
