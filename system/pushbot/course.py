"""The line of obstacles of a scene, and how a path passed it (Milde et al. 2017, section 3.1, Table 1).

The line is perpendicular to the robot's first heading, through the mean of what stands or comes to stand in
the way; where the robot's middle crosses it, the distance is that from its outline to the nearest obstacle.
A robot that turns back without crossing has passed nothing: its closest approach is told instead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from system.worlds.arena.geometry import Obstacles, clearance
from system.worlds.arena.scene import Body, Scene

MOST = 3  # obstacles of a line; with more, a scene is clutter
EVERY = 4  # steps of a path between two looks for the closest approach


@dataclass(frozen=True, slots=True)
class Course:
    """Start (m, m, rad), distance (m) of the line ahead of it, and how far left the obstacles' middle is.

    start : pose at which a run begins, m, m, rad.
    """

    start: tuple[float, float, float]
    distance: float
    middle: float

    def ahead(self, pose: tuple[float, float, float]) -> float:
        """How far ahead of the start a pose is, m."""
        dx, dy = pose[0] - self.start[0], pose[1] - self.start[1]
        return dx * math.cos(self.start[2]) + dy * math.sin(self.start[2])

    def aside(self, pose: tuple[float, float, float]) -> float:
        """How far left of the start's heading a pose is, m."""
        dx, dy = pose[0] - self.start[0], pose[1] - self.start[1]
        return dy * math.cos(self.start[2]) - dx * math.sin(self.start[2])


@dataclass(frozen=True, slots=True)
class Passage:
    """How a path passed the line of obstacles.

    distance: to the nearest obstacle on the line, m; closest: on the whole way, m; side: of the obstacles'
    middle, 1 left, -1 right, None where not crossed; between: whether obstacles were on both sides.
    """

    crossed: bool
    distance: float | None
    closest: float
    side: int | None
    between: bool = False


def course_of(scene: Scene) -> Course | None:
    """The obstacle line of a scene of one to three blocks or cups and no target; None for other scenes."""
    things = [b for b in scene.bodies if b.name.startswith(("block", "cup"))]
    if not 0 < len(things) <= MOST or len(things) < len(scene.bodies):
        return None
    places = np.array([_end(b) for b in things])
    course = Course(scene.start, 0.0, 0.0)
    middle = float(places[:, 0].mean()), float(places[:, 1].mean()), 0.0
    return Course(scene.start, course.ahead(middle), course.aside(middle))


def passage(course: Course, obstacles: Obstacles, path: F64) -> Passage:
    """How a path, float64[n, 4] of s, m, m, rad, passed the line."""
    poses = [(float(x), float(y), float(h)) for _, x, y, h in path]
    closest = min(clearance(obstacles, poses[k], float(path[k, 0])) for k in range(0, len(path), EVERY))
    beyond = [k for k, pose in enumerate(poses) if course.ahead(pose) >= course.distance]
    if not beyond:
        return Passage(crossed=False, distance=None, closest=closest, side=None)
    k = beyond[0]
    distance = clearance(obstacles, poses[k], float(path[k, 0]))
    aside = course.aside(poses[k])
    others = [course.aside((*_end(b), 0.0)) for b in obstacles.scene.bodies]
    return Passage(
        crossed=True, distance=distance, closest=min(closest, distance),
        side=1 if aside > course.middle else -1, between=min(others) < aside < max(others),
    )  # fmt: skip


def _end(body: Body) -> tuple[float, float]:
    """Where a body stands, or comes to stand."""
    return body.at if body.motion is None else body.motion.path[-1]
