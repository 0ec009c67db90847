"""Shortest paths by visibility graph and Dijkstra, and how alike two paths are (Stöckel 2017, III.A).

The graph joins the convex corners of the obstacles, the start and the goal wherever a straight line between
them crosses no obstacle; networkx's Dijkstra finds the shortest way for a point.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import shapely

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.errors import ParameterError
from system.bug.map import Point
from system.bug.world import World, corners

if TYPE_CHECKING:
    import networkx as nx
else:
    nx = later("networkx")

spatial = later("scipy.spatial")


MOST_CORNERS = 2000  # of a map, whose pairs are all tried; ours
_SHRUNK = 1e-6  # by which obstacles are made smaller, so that a line along a side does not cross it


def shortest_path(world: World, start: Point, goal: Point) -> F64 | None:
    """Shortest path of a point, float64[n, 2] from start to goal; None if there is no way.

    Raises `ParameterError` for a map of more than `MOST_CORNERS` corners.
    """
    turns = corners(world)
    if len(turns) > MOST_CORNERS:
        raise ParameterError(
            f"{world.map.name}: {len(turns)} corners, must be at most {MOST_CORNERS}; draw it coarser"
        )
    points = np.concatenate([[start, goal], turns])
    graph = _visibility(world, points)
    try:
        way = nx.dijkstra_path(graph, 0, 1)
    except nx.NetworkXNoPath:
        return None
    return np.asarray(points[way])


def path_length(path: F64) -> float:
    """Return the length of a path, float64[n, 2], in its unit."""
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


def median_distance(path: F64, other: F64) -> float:
    """Median over the points of `path` of the distance to the nearest point of `other`."""
    return float(np.median(spatial.KDTree(other).query(path)[0]))


def _visibility(world: World, points: F64) -> nx.Graph:
    """Graph of the points that see each other, weighted by distance."""
    a, b = np.triu_indices(len(points), 1)
    lines = shapely.linestrings(np.stack([points[a], points[b]], axis=1))
    obstacles = world.obstacles.buffer(-_SHRUNK, join_style="mitre")
    shapely.prepare(obstacles)
    seen = ~shapely.intersects(obstacles, lines)
    graph = nx.Graph()
    graph.add_nodes_from(range(len(points)))
    length = np.hypot(*(points[a] - points[b]).T)
    graph.add_weighted_edges_from(zip(a[seen].tolist(), b[seen].tolist(), length[seen].tolist(), strict=True))
    return graph
