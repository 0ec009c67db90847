"""Topological maps: places and the ways between them, planned by a wave like a grid (Hwu et al. 2018, IV.D).

Each place is a cell whose axon delay is the place's cost, 1 to 31, and whose axons lead to the places that
can be reached from it. `scatter_places` draws one: places uniform in a square, joined where they are near.
"""

from __future__ import annotations

import math

import networkx as nx
import numpy as np

from chips.wavefront.axon_graph import graph_of, node_costs
from chips.wavefront.chip import ChipCells, WavefrontChip
from chips.wavefront.readout import UnreachableError
from circuits.errors import ParameterError
from system.rover.cost_map import MAX_CODE

NEIGHBOURS = 12.0  # of a place, on average; ours: enough that nearly all places hang together


def scatter_places(places: int, random: np.random.Generator) -> nx.DiGraph:
    """Draw a map of places in the unit square, with `pos` and a whole `cost` from 1 to 31 each.

    What does not hang together with the largest part is joined to it at its nearest place.

    Parameters
    ----------
    places
        How many places there are.
    random
        Generator that draws them.

    Raises
    ------
    ParameterError
        There is less than 1 place.
    """
    if places < 1:
        raise ParameterError(f"places: {places}, must be at least 1")
    radius = math.sqrt(NEIGHBOURS / (math.pi * places))
    at = random.random((places, 2))
    ways = nx.random_geometric_graph(places, radius, pos=dict(enumerate(at.tolist())))
    main, *others = sorted(nx.connected_components(ways), key=len, reverse=True)
    for part in others:
        a, b = np.array(sorted(part)), np.array(sorted(main))
        gap = np.hypot(*(at[a][:, None] - at[b][None]).transpose(2, 0, 1))
        i, j = np.unravel_index(int(gap.argmin()), gap.shape)
        ways.add_edge(int(a[i]), int(b[j]))
        main |= part
    nx.set_node_attributes(ways, dict(enumerate(random.integers(1, MAX_CODE + 1, places).tolist())), "cost")
    return ways.to_directed()


def plan_places(
    graph: nx.DiGraph, start: object, goal: object, cells: ChipCells | None = None
) -> list[object] | None:
    """Plan a way on a map of places by a wavefront chip.

    Every place has a `cost`; a way costs its places but the goal, and ideal cells find the cheapest.

    Parameters
    ----------
    graph
        The map, whose nodes are the places.
    start, goal
        The first and the last place.
    cells
        Cells of the chip; ideal ones unless given.

    Returns
    -------
    The places from start to goal; None where no way leads there.

    Raises
    ------
    ParameterError
        A cost is missing or has no code, or a place is not on the map.
    """
    names = list(graph)
    number = {name: k for k, name in enumerate(names)}
    for option, place in (("start", start), ("goal", goal)):
        if place not in number:
            raise ParameterError(f"{option}: {place}, must be a place of the map")
    chip = WavefrontChip(graph=graph_of(graph), cells=cells)
    try:
        path = chip.plan(chip.program(node_costs(graph)), number[start], number[goal]).path()
    except UnreachableError:
        return None
    return [names[place] for place in path.tolist()]
