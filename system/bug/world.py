"""World of the Bug robot: outlines of obstacles, and the pieces of them near a place (Stöckel 2017, III.A).

The cells of a map are joined to polygons, whose sides without corners are one; each side is cut into pieces
no longer than `PIECE`, and their ends stand in a k-d tree. What a ray of length R from p can meet has an end
within R + PIECE of p, so one query of the tree finds all pieces for all rays and for the body; it holds until
the robot has moved by `SLACK`. Rays and motion are then exact on the pieces, where the paper cuts the rays
into points too and asks the tree for each.

Ours: walls that touch at a corner only are joined there by a square of `_SEAL`, so that nothing passes.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely.geometry import MultiPolygon, Polygon
from shapely.geometry.polygon import orient

from circuits.arrays import F64, Bools
from circuits.catalogue import later
from circuits.errors import ParameterError
from system.bug.map import BugMap, Point

if TYPE_CHECKING:
    from scipy.spatial import KDTree

spatial = later("scipy.spatial")


PIECE = 0.25  # largest length of a piece of an outline, the paper's epsilon; ours
SLACK = 0.25  # way after which pieces are looked up again; ours
_SEAL = 2e-3  # side of the square where walls touch at a corner; ours
FRAME = 1.0  # width of the wall around the map; ours
ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """Obstacles of a map: their polygons, their outlines in pieces and the tree of the pieces' ends.

    pieces: float64[n, 4], x and y of begin and end; tree: of the 2 n ends, begins first.

    obstacles : their polygons, joined.
    """

    map: BugMap
    obstacles: MultiPolygon
    pieces: F64
    tree: KDTree

    def near(self, place: Point, reach: float) -> F64:
        """Pieces of which a part lies within `reach` of `place`, and some more; float64[m, 4]."""
        found = self.tree.query_ball_point(place, reach + PIECE)
        return self.pieces[np.unique(np.asarray(found, dtype=np.int64) % len(self.pieces))]

    def clearance(self, place: Point) -> float:
        """Distance from a place to the nearest wall, 0 inside one."""
        return float(self.obstacles.distance(shapely.Point(place)))


def build_world(bug_map: BugMap) -> World:
    """Return the world of a map: its walls as polygons and their outlines."""
    obstacles = _polygons(bug_map)
    outlines = [ring for polygon in obstacles.geoms for ring in (polygon.exterior, *polygon.interiors)]
    pieces = np.concatenate([_cut(np.asarray(ring.coords)) for ring in outlines])
    ends = np.concatenate([pieces[:, :2], pieces[:, 2:]])
    return World(bug_map, obstacles, pieces, spatial.KDTree(ends))


def check_place(world: World, place: Point, radius: float, what: str) -> None:
    """Raise `ParameterError` if a robot of this radius does not fit."""
    width, height = world.map.width, world.map.height
    if not (0.0 < place[0] < width and 0.0 < place[1] < height):
        raise ParameterError(
            f"{what}: {place[0]:g},{place[1]:g}, must be in the map of {width:g} x {height:g}"
        )
    room = world.clearance(place)
    if room < radius - ROUNDING:
        raise ParameterError(
            f"{what}: {place[0]:g},{place[1]:g}, a wall is {room:.3g} away, must be at least the robot's"
            f" radius of {radius:g}; place it elsewhere"
        )


def corners(world: World) -> F64:
    """Convex corners of the obstacles, where shortest paths turn; float64[n, 2]."""
    found = []
    for polygon in world.obstacles.geoms:
        for ring in (orient(polygon).exterior, *orient(polygon).interiors):
            points = np.asarray(ring.coords)[:-1]
            before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
            # wall lies to the left of an oriented ring, exterior or hole
            turns = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
            found.append(points[turns > 0.0])
    points = np.concatenate(found)
    inside = (points > 0.0).all(axis=1) & (points < (world.map.width, world.map.height)).all(axis=1)
    return np.asarray(points[inside])


def _polygons(bug_map: BugMap) -> MultiPolygon:
    """Obstacles and the frame, joined, without corners on straight sides."""
    walls, height = bug_map.walls, bug_map.height
    boxes = [shapely.box(j, height - i - 1.0, j + 1.0, height - i) for i, j in np.argwhere(walls)]
    edge = shapely.box(0.0, 0.0, bug_map.width, height)
    frame = shapely.box(-FRAME, -FRAME, bug_map.width + FRAME, height + FRAME)
    boxes += [_square(*place) for place in _touching(np.pad(walls, 1, constant_values=True), height)]
    joined = shapely.union_all([frame.difference(edge), *boxes]).simplify(0.0)
    return joined if isinstance(joined, MultiPolygon) else MultiPolygon([joined])


def _touching(walls: Bools, height: float) -> list[Point]:
    """Corners where two wall cells touch with two free ones between them; `walls` has a rim of 1."""
    nw, ne, sw, se = walls[:-1, :-1], walls[:-1, 1:], walls[1:, :-1], walls[1:, 1:]
    at = np.argwhere(((nw & se) & ~(ne | sw)) | ((ne & sw) & ~(nw | se)))
    return [(float(j), height - float(i)) for i, j in at]


def _square(x: float, y: float) -> Polygon:
    half = 0.5 * _SEAL
    return shapely.box(x - half, y - half, x + half, y + half)


def _cut(ring: F64) -> F64:
    """Pieces of a closed ring no longer than `PIECE`, float64[n, 4]."""
    pieces = []
    for a, b in pairwise(ring):
        n = max(int(np.ceil(np.hypot(*(b - a)) / PIECE)), 1)
        points = a + np.linspace(0.0, 1.0, n + 1)[:, None] * (b - a)
        pieces.append(np.concatenate([points[:-1], points[1:]], axis=1))
    return np.concatenate(pieces)
