"""Pieces of two circuits between the nodes that are matched already, and whether the pieces are the same.

Take away every node whose colour no other node has, for these are matched. A piece is what still hangs
together then. Where no colour repeats inside a piece, equal colours say that two pieces are the same.
Elsewhere networkx looks for an isomorphism that keeps the colours (VF2++: Juttner and Madarasi, 2018).
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator

import networkx as nx
import numpy as np

from netlists.compare.pair import Pair
from netlists.compare.refinement import Colours, label

Piece = list[int]  # device numbers


def unlike_pieces(pair: Pair, colours: Colours) -> Iterator[tuple[Piece, int, int]]:
    """Yield a piece, and of how many like it in each circuit not all have their like in the other."""
    pieces = [_pieces(pair, colours, side) for side in (0, 1)]
    for key in dict.fromkeys((*pieces[0], *pieces[1])):
        first, second = pieces[0].get(key, []), pieces[1].get(key, [])
        repeated = len(set(key)) < len(key)
        if len(first) != len(second) or (repeated and not _matched(pair, colours, first, second)):
            yield (first or second)[0], len(first), len(second)


def _pieces(pair: Pair, colours: Colours, side: int) -> dict[tuple[int, ...], list[Piece]]:
    """Pieces of one circuit by the colours of their devices and nodes."""
    values, counts = np.unique(colours.node, return_counts=True)
    own = set(values[counts > 2].tolist())  # in both circuits together: more than the one of each
    begin, end = (0, pair.devices_a) if side == 0 else (pair.devices_a, len(pair.devices))
    graph = nx.Graph()
    node_colour = colours.node.tolist()
    for k in range(begin, end):
        graph.add_node(k)
        graph.add_edges_from((k, -1 - n) for n in pair.devices[k].nodes if node_colour[n] in own)
    found: dict[tuple[int, ...], list[Piece]] = defaultdict(list)
    for piece in nx.connected_components(graph):
        devices = sorted(v for v in piece if v >= 0)
        key = sorted(int(colours.device[v]) if v >= 0 else node_colour[-1 - v] for v in piece)
        found[tuple(key)].append(devices)
    return found


def _matched(pair: Pair, colours: Colours, first: list[Piece], second: list[Piece]) -> bool:
    """Whether the pieces of pair circuits are of the same classes, equally often."""
    models: list[nx.Graph] = []
    counts: list[Counter[int]] = [Counter(), Counter()]
    for side, pieces in enumerate((first, second)):
        for piece in pieces:
            graph = _piece_graph(pair, colours, piece)
            equal = (k for k, m in enumerate(models) if nx.vf2pp_is_isomorphic(m, graph, node_label="colour"))
            k = next(equal, len(models))
            if k == len(models):
                models.append(graph)
            counts[side][k] += 1
    return counts[0] == counts[1]


def _piece_graph(pair: Pair, colours: Colours, piece: Piece) -> nx.Graph:
    """Vertices for devices, their sides, the sides' terminals and the nodes, coloured."""
    graph = nx.Graph()
    for k in piece:
        device = pair.devices[k]
        graph.add_node(("device", k), colour=int(colours.device[k]))
        for i, (side, terminals) in enumerate(device.sides):
            graph.add_edge(("device", k), ("side", k, i))
            graph.nodes["side", k, i]["colour"] = label(side)
            for role, position in terminals:
                node = device.nodes[position]
                graph.add_node(("node", node), colour=int(colours.node[node]))
                graph.add_node(("role", k, position), colour=label(role))
                graph.add_edge(("side", k, i), ("role", k, position))
                graph.add_edge(("role", k, position), ("node", node))
    return graph
