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
from system.pushbot.drive import Run
from system.worlds.arena.geometry import Obstacles, clearance
from system.worlds.arena.scene import Body, Scene
from system.worlds.standing import share_standing

MOST = 3  # obstacles of a line; with more, a scene is clutter
EVERY = 4  # steps of a path between two looks for the closest approach
BEYOND = 0.05  # m behind the obstacle line, where a run ends; ours
LOOK_STEPS, STANDS = 20, 0.03  # steps of a path (0.1 s), and m/s below which a robot stands; ours
NEAR, LOOKS = 0.25, 10  # m from another robot that is a target, steps between two looks at it; ours
RESTS = 0.5  # of its time, that a robot with nothing to reach may stand; ours


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


@dataclass(frozen=True, slots=True)
class Errand:
    """What a run is there for, and when it ends.

    scene : the world; course : its line of obstacles, None where it has none.
    duration, way : s and m, after which a run is cut off.
    """

    scene: Scene
    course: Course | None
    duration: float
    way: float = math.inf

    def ended(self, drive: Run) -> str:
        """Why a run is over for good: it touched something, or passed the line; empty while it goes on."""
        if drive.touched is not None:
            return f"touched {drive.touched}"
        if self.course is not None and self.course.ahead(drive.pose) > self.course.distance + BEYOND:
            return "passed the line of its obstacles"
        return ""

    def late(self, drive: Run) -> str:
        """Why a run is cut off; empty while there is time and way left."""
        if drive.way >= self.way:
            return f"way of {self.way:g} m driven"
        return f"time of {self.duration:g} s over" if drive.time >= self.duration - 1e-9 else ""

    def why(self, drive: Run) -> str:
        """Why a run ends; empty while it goes on."""
        return self.ended(drive) or self.late(drive)

    def reached(self, drive: Run) -> bool:
        """Whether a robot has touched nothing, and done what its scene asks for."""
        if drive.touched is not None:
            return False
        if self.course is not None:
            return any(self.course.ahead((x, y, h)) >= self.course.distance for _, x, y, h in drive.path)
        if any(body.name.startswith("robot") for body in self.scene.bodies):
            looks = drive.path[::LOOKS]
            return any(clearance(drive.obstacles, (x, y, h), t, "robot") <= NEAR for t, x, y, h in looks)
        return stood(np.array(drive.path)) <= RESTS


def stood(path: F64) -> float:
    """Return the share of the time in which a path is slower than `STANDS`.

    path : float64[n, 4], time (s), place (m, m), heading (rad).
    """
    return share_standing(path, STANDS, LOOK_STEPS)


def _end(body: Body) -> tuple[float, float]:
    """Where a body stands, or comes to stand."""
    return body.at if body.motion is None else body.motion.path[-1]
