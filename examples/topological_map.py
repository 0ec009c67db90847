"""Plan between 1,000 places on a map that is no grid, by a wave of spikes."""

from __future__ import annotations

import networkx as nx
import numpy as np

from chips.wavefront.chip import ChipCells
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from system.rover.topological_map import plan_places, scatter_places


def main() -> None:
    """Print a way, its cost, and networkx's."""
    places = scatter_places(1000, np.random.default_rng(1000))
    cost = nx.get_node_attributes(places, "cost")
    position = nx.get_node_attributes(places, "pos")
    start = min(places, key=lambda place: sum(position[place]))
    goal = max(places, key=lambda place: sum(position[place]))
    way = plan_places(places, start, goal)
    if way is None:
        raise SystemExit("no way leads there")
    lowest = nx.dijkstra_path_length(places, start, goal, weight=lambda a, _b, _data: cost[a])
    print(f"from place {start} to place {goal}: {' '.join(map(str, way))}")
    on_die = plan_places(places, start, goal, ChipCells(Silicon(die=Die("A", 1000))))
    if on_die is not None:
        print(f"on die A/1000: cost {sum(cost[p] for p in on_die[:-1])}")
    print(f"{len(way)} places, cost {sum(cost[p] for p in way[:-1])}; networkx's Dijkstra: {lowest}")


if __name__ == "__main__":
    main()
