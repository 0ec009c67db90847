"""Pieces between nodes that are matched."""

import numpy as np

from circuits.circuit import Circuit, Port
from circuits.devices import Resistor
from netlists.compare.pair import Pair, pair_of
from netlists.compare.pieces import unlike_pieces
from netlists.compare.refinement import Colours, first_colours, refine


def rings(*sizes: int) -> Circuit:
    devices = tuple(
        Resistor(f"r{j}_{k}", f"n{j}_{k}", f"n{j}_{(k + 1) % size}", 1.0)
        for j, size in enumerate(sizes)
        for k in range(size)
    )
    return Circuit("c", (Port("p", "analog"),), (*devices, Resistor("r", "p", "0", 1.0)))


def refined(pair: Pair) -> Colours:
    colours = first_colours(pair.structure, np.zeros(len(pair.devices), dtype=np.uint64))
    for _ in range(20):
        colours = refine(pair.structure, colours)
    assert pair.agree(colours)
    return colours


def test_equal_pieces_in_any_order() -> None:
    pair = pair_of(rings(3, 4, 4), rings(4, 3, 4), ({}, {}))
    assert list(unlike_pieces(pair, refined(pair))) == []


def test_pieces_of_equal_colours_that_are_connected_otherwise() -> None:
    pair = pair_of(rings(3, 5), rings(4, 4), ({}, {}))
    found = list(unlike_pieces(pair, refined(pair)))
    assert sorted((first, second) for _, first, second in found) == [(0, 2), (1, 0), (1, 0)]


def prism(*, twisted: bool) -> Circuit:
    """Two triangles side by side joined by rungs, or the ring of six with its diagonals: all nodes alike."""
    edges = [(k, (k + 1) % 3) for k in range(3)] + [(3 + k, 3 + (k + 1) % 3) for k in range(3)]
    edges += [(k, k + 3) for k in range(3)]
    if twisted:
        edges = [(k, (k + 1) % 6) for k in range(6)] + [(k, k + 3) for k in range(3)]
    devices = tuple(Resistor(f"r{k}", f"n{a}", f"n{b}", 1.0) for k, (a, b) in enumerate(edges))
    return Circuit("c", (Port("p", "analog"),), (*devices, Resistor("r", "p", "0", 1.0)))


def test_networkx_tells_what_colours_cannot() -> None:
    same = pair_of(prism(twisted=False), prism(twisted=False), ({}, {}))
    other = pair_of(prism(twisted=False), prism(twisted=True), ({}, {}))
    assert list(unlike_pieces(same, refined(same))) == []
    assert [(first, second) for _, first, second in unlike_pieces(other, refined(other))] == [(1, 1)]
