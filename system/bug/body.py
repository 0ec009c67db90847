"""Robot of the Bug paper: a disc with a compass, a contact sensor and eight range rays (Stöckel 2017, III.A).

A steering vector v in the robot's frame, x ahead and y to the left, sets heading and speed:

    d heading / dt = TURN atan2(v_y, v_x)       |d place / dt| = |v|

Lengths are in map units, angles in rad, times in s. The paper's: radius, range, time step, that rays are not
symmetric. Everything else here is ours.

| ours | value | why |
|---|---|---|
| TURN | 10 /s | turns on a corner within a tenth of a second, some 0.1 map units |
| FASTEST | 1 map unit/s | the speed of a unit vector towards the goal; a longer v is cut |
| RAYS | 8, about 45 degrees apart | the fastest of 60 drawn; most even ones rest in corners |
| ARRIVED | 0.3 map units | two radii from the goal |
| distance | over the map's diagonal | from 0 to 1 on any map, so coarser on a larger one, as in the paper |
| contact | a wall was met in the last step | |
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from system.bug.kernel import look, slide
from system.bug.map import Point
from system.bug.world import SLACK, World

RADIUS = 0.15
RANGE = 1.0
STEP = 0.01  # s
TURN = 10.0
FASTEST = 1.0
ARRIVED = 2.0 * RADIUS
RAYS = np.deg2rad(np.array([-13.0, 26.0, 72.0, 126.0, 171.0, 215.0, 257.0, 311.0]))  # from ahead to the left


@dataclass(frozen=True, slots=True, eq=False)
class Senses:
    """What a brain is told every 10 ms.

    ranges: float64[8], from the centre, at most `RANGE`; contact: 0 or 1; ahead, north: unit vectors to the
    goal in the robot's frame and in the world's, float64[2]; distance: to the goal, over the map's diagonal.
    """

    ranges: F64
    contact: float
    ahead: F64
    north: F64
    distance: float


class Robot:
    """A robot in its world, moved by `step`; attributes are overwritten."""

    __slots__ = ("_looked", "_pieces", "_scratch", "contact", "goal", "heading", "place", "world")

    def __init__(self, world: World, start: Point, goal: Point) -> None:
        self.world, self.goal = world, np.array(goal)
        self.place = np.array(start)
        # at rest it faces the goal, so that no path begins with a loop
        self.heading = math.atan2(goal[1] - start[1], goal[0] - start[0])
        self.contact = False
        self._scratch = np.empty(3)
        self._look_up()

    @property
    def distance(self) -> float:
        """Distance to the goal, map units."""
        return float(np.hypot(*(self.goal - self.place)))

    def sense(self) -> Senses:
        """Sense from where it is."""
        ranges = np.empty(RAYS.size)
        look(self._pieces, self.place[0], self.place[1], self.heading, RAYS, RANGE, ranges)
        north = (self.goal - self.place) / max(self.distance, 1e-9)
        c, s = math.cos(self.heading), math.sin(self.heading)
        ahead = np.array([c * north[0] + s * north[1], c * north[1] - s * north[0]])
        return Senses(ranges, float(self.contact), ahead, north, self.distance / self.world.map.diagonal)

    def step(self, v: F64) -> None:
        """Turn and move for 10 ms by a steering vector, float64[2]."""
        speed = min(math.hypot(v[0], v[1]), FASTEST)
        if speed > 0.0:
            self.heading = _wrapped(self.heading + STEP * TURN * math.atan2(v[1], v[0]))
        dx, dy = STEP * speed * math.cos(self.heading), STEP * speed * math.sin(self.heading)
        self.contact = slide(self._pieces, self.place, dx, dy, RADIUS, self._scratch)
        if np.hypot(*(self.place - self._looked)) > SLACK:
            self._look_up()

    def _look_up(self) -> None:
        """Find the pieces that rays and body can meet until it has moved on by `SLACK`."""
        self._looked = self.place.copy()
        reach = RANGE + SLACK + STEP * FASTEST
        self._pieces = self.world.near((self.place[0], self.place[1]), reach)


def _wrapped(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi
