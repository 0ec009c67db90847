"""Axons of grids and of networkx graphs, in their order."""

import networkx as nx
import numpy as np
import pytest

from chips.wavefront.axon_graph import NEIGHBOURS, edge_weights, graph_of, grid_graph, node_costs
from circuits.errors import ParameterError, TopologyError


def test_grid_joins_each_cell_to_its_neighbours_at_the_opposite_input() -> None:
    rows, columns = 3, 4
    graph = grid_graph(rows, columns)
    expected = []
    for r in range(rows):
        for c in range(columns):
            for down, right in NEIGHBOURS:
                if 0 <= r + down < rows and 0 <= c + right < columns:
                    which = NEIGHBOURS.index((-down, -right))
                    expected.append((r * columns + c, (r + down) * columns + c + right, which))
    found = zip(graph.sources().tolist(), graph.targets.tolist(), graph.inputs.tolist(), strict=True)
    assert list(found) == expected
    assert graph.shape == (rows, columns)


def test_one_cell_has_no_axon() -> None:
    graph = grid_graph(1, 1)
    assert (graph.cells, graph.edges) == (1, 0)


@pytest.mark.parametrize("shape", [(0, 3), (3, 0), (2**20, 2**20)])
def test_impossible_grid_is_refused(shape: tuple[int, int]) -> None:
    with pytest.raises(ParameterError, match=r"grid.shape"):
        grid_graph(*shape)


def _places() -> nx.DiGraph:
    graph = nx.DiGraph()
    graph.add_node("c", cost=3)
    graph.add_node("a", cost=1.5)
    graph.add_node("b", cost=2)
    graph.add_edge("a", "c", weight=7)
    graph.add_edge("b", "c", weight=8)
    graph.add_edge("c", "b", weight=9)
    graph.add_edge("a", "b", weight=10)
    return graph


def test_networkx_nodes_keep_their_order_and_inputs_count_by_source() -> None:
    graph = graph_of(_places())  # c = 0, a = 1, b = 2
    assert graph.offsets.tolist() == [0, 1, 3, 4]
    assert graph.targets.tolist() == [2, 0, 2, 0]
    assert graph.inputs.tolist() == [0, 0, 1, 1]
    assert node_costs(_places()).tolist() == [3.0, 1.5, 2.0]
    assert edge_weights(_places()).tolist() == [9.0, 7.0, 10.0, 8.0]


def test_pointers_name_their_sources() -> None:
    graph = graph_of(_places())
    assert graph.predecessors(np.array([1, -1, 0], dtype=np.int8)).tolist() == [2, -1, 0]


def test_an_undirected_edge_is_two_axons() -> None:
    graph = graph_of(nx.path_graph(3))
    assert graph.targets.tolist() == [1, 0, 2, 1]


def test_wrong_graphs_are_refused() -> None:
    with pytest.raises(TopologyError, match="multigraph"):
        graph_of(nx.MultiDiGraph([(0, 1), (0, 1)]))
    with pytest.raises(TopologyError, match="nodes: 0"):
        graph_of(nx.DiGraph())
    with pytest.raises(TopologyError, match=r"nodes\[hub\]: 127 edges into it, must be <= 126"):
        graph_of(nx.DiGraph([(k, "hub") for k in range(127)]))
    with pytest.raises(ParameterError, match=r"graph.nodes\[0\].cost: missing"):
        node_costs(nx.path_graph(2))
    with pytest.raises(ParameterError, match=r"graph.edges\[0, 1\].weight: missing"):
        edge_weights(nx.path_graph(2))
