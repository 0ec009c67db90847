"""How much of a forest paths have covered: which of the ways between obstacles were taken.

Neighbouring obstacles are those that an edge of the Delaunay triangulation joins (on the torus). A gap is
such an edge longer than twice the radius of the zone of collision, so that a bat fits through; it is taken
where the path crosses it. Every path through the forest is a sequence of gaps. The measure is ours: Wen &
Horiuchi 2022 say that most of the viable paths were visited, without one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import F64, I64
from circuits.catalogue import later
from system.openspace.law import Arcs, arc_point
from system.openspace.map import SIDE, Forest

if TYPE_CHECKING:
    from scipy.spatial import Delaunay

spatial = later("scipy.spatial")  # slow to import

Gap = tuple[int, int]  # obstacles on its sides, the lower number first

_BEYOND = 6.0  # m of copies beyond the borders: far more than between any two neighbours
_POINTS = 40  # of a path between pings


@dataclass(frozen=True, slots=True)
class Coverage:
    """Gaps of a forest, and how often each that was taken was."""

    gaps: frozenset[Gap]
    taken: dict[Gap, int]

    @property
    def share(self) -> float:
        """Share of the gaps that were taken at least once."""
        return len(self.taken) / len(self.gaps)

    @property
    def busiest(self) -> float:
        """Share of all gaps that carries half of the crossings: small where a few paths are repeated."""
        counts = np.sort(list(self.taken.values()))[::-1]
        needed = int(np.searchsorted(np.cumsum(counts), 0.5 * counts.sum())) + 1
        return needed / len(self.gaps)


def coverage(forest: Forest, zone: float, paths: Iterable[F64]) -> Coverage:
    """Coverage by paths, each float64[n, 2] in m on the torus, with steps short against a gap."""
    mesh, number = _mesh(forest)
    gaps = frozenset(
        _gap(number, a, b)
        for triangle in mesh.simplices
        if _inside(mesh.points[triangle].mean(axis=0))
        for a, b in zip(triangle, np.roll(triangle, 1), strict=True)
        if np.hypot(*(mesh.points[a] - mesh.points[b])) > 2.0 * zone
    )
    taken: Counter[Gap] = Counter()
    for path in paths:
        taken.update(gap for gap in _crossed(mesh, number, path) if gap in gaps)
    return Coverage(gaps, dict(taken))


def fine_path(arcs: Arcs, log: F64) -> F64:
    """Path between the pings of a log (see the kernel), along the arcs that were flown, float64[n, 2], m."""
    arc = log[:, 5].astype(np.int64)
    way = (arcs.speed * arcs.step)[arc][:, None] * np.arange(_POINTS) / _POINTS
    ahead, left = arc_point(arcs.curvature[arc][:, None], way)
    cos, sin = np.cos(log[:, 3:4]), np.sin(log[:, 3:4])
    places = np.stack([log[:, 1:2] + cos * ahead - sin * left, log[:, 2:3] + sin * ahead + cos * left])
    return np.asarray(places.reshape(2, -1).T % SIDE)


def _mesh(forest: Forest) -> tuple[Delaunay, I64]:
    """Triangulation of the obstacles and their copies; also the number of each point's obstacle."""
    shifts = SIDE * np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    points = (forest.place[None] + shifts[:, None]).reshape(-1, 2)
    near = np.flatnonzero(((points >= -_BEYOND) & (points < SIDE + _BEYOND)).all(axis=1))
    return spatial.Delaunay(points[near]), near % len(forest.place)


def _inside(point: F64) -> bool:
    return bool(((point >= 0.0) & (point < SIDE)).all())


def _gap(number: I64, a: int, b: int) -> Gap:
    first, second = int(number[a]), int(number[b])
    return min(first, second), max(first, second)


def _crossed(mesh: Delaunay, number: I64, path: F64) -> list[Gap]:
    """Edges between triangles that follow each other along a path; jumps across a border are no crossing."""
    triangle = mesh.find_simplex(path)
    at = np.flatnonzero(triangle[1:] != triangle[:-1])
    found = []
    for k in at.tolist():
        shared = np.intersect1d(mesh.simplices[triangle[k]], mesh.simplices[triangle[k + 1]])
        if len(shared) == 2:
            found.append(_gap(number, *shared.tolist()))
    return found
