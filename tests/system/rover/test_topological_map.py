"""A map of 1,000 places: the wave's way is as cheap as networkx's."""

from __future__ import annotations

import networkx as nx
import numpy as np
import pytest

from chips.wavefront.chip import ChipCells
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.rover.topological_map import plan_places, scatter_places


def test_a_thousand_places() -> None:
    graph = scatter_places(1000, np.random.default_rng(1000))
    assert len(graph) == 1000
    assert nx.is_strongly_connected(graph)
    cost = nx.get_node_attributes(graph, "cost")
    for goal in (1, 500, 999):
        way = plan_places(graph, 0, goal)
        assert way is not None
        assert nx.is_path(graph, way)
        found = nx.dijkstra_path_length(graph, 0, goal, weight=lambda a, _b, _data: cost[a])
        assert sum(cost[place] for place in way[:-1]) == found


def test_a_die_finds_a_way_that_is_nearly_as_cheap() -> None:
    graph = scatter_places(1000, np.random.default_rng(1000))
    cost = nx.get_node_attributes(graph, "cost")
    way, best = (
        plan_places(graph, 0, 999, cells)
        for cells in (ChipCells(Silicon(AMI_1500_IDEAL, die=Die("A", 3))), None)
    )
    assert way is not None
    assert best is not None
    assert nx.is_path(graph, way)
    paid, lowest = (sum(cost[place] for place in places) for places in (way, best))
    # a cell's delay spreads by 4 %, so that a way of a hundred units is known to a few of them
    assert lowest <= paid <= 1.1 * lowest


def test_one_way_streets() -> None:
    graph = nx.DiGraph([("a", "b"), ("b", "c"), ("a", "c")])
    nx.set_node_attributes(graph, 3, "cost")
    assert plan_places(graph, "a", "c") == ["a", "c"]
    assert plan_places(graph, "c", "a") is None
    assert plan_places(graph, "b", "b") == ["b"]
    with pytest.raises(ParameterError, match=r"^goal: d, must be a place"):
        plan_places(graph, "a", "d")


def test_sparse_places_are_joined() -> None:
    for places in (1, 2, 30):
        graph = scatter_places(places, np.random.default_rng(5))
        assert len(graph) == places
        assert nx.is_strongly_connected(graph)
