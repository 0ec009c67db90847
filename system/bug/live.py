"""A Bug robot that goes on by 10 ms (`system.live.robot`).

An action is a steering vector in the robot's frame, x ahead and y to the left; what it senses are ranges,
contact, compass and distance. The reward is by how much it came nearer to the goal, in map units, and
`ARRIVAL` more where it arrives (ours).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import F64
from system.bug.body import ARRIVED, FASTEST, RANGE, RAYS, STEP, Robot, Senses
from system.bug.brain import Brain
from system.bug.path import shortest_path
from system.bug.picture import draw_paths, draw_world
from system.live.signals import Channel, Signals, gathered
from system.plot import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ARRIVAL = 10.0  # map units that an arrival is worth; ours
SENSES = Signals(
    (
        Channel("ranges along the eight rays, from ahead to the left", "map units", 0.0, RANGE, (RAYS.size,)),
        Channel("whether it touched a wall in the last step", "", 0.0, 1.0),
        Channel("direction of the goal in its own frame, ahead and left", "", -1.0, 1.0, (2,)),
        Channel("direction of the goal in the world, east and north", "", -1.0, 1.0, (2,)),
        Channel("distance to the goal over the map's diagonal", "", 0.0, 2.0),
    )
)
ACTIONS = Signals(
    (Channel("steering vector, ahead and left", "map units/s", -FASTEST, FASTEST, (2,)),),
)


class LiveBug:
    """A Bug robot on its way; `System.open` of bug.

    Parameters
    ----------
    robot : in its world, at its start.
    duration : after which it is cut off, s.
    brain : makes noctule's own controller when it is first asked for.
    """

    senses, actions = SENSES, ACTIONS

    def __init__(self, robot: Robot, duration: float, brain: Callable[[], Brain]) -> None:
        self.robot, self._make = robot, brain
        self._brain: Brain | None = None
        self._wanted: F64 | None = None
        self._verdict = ""
        self._steps, self._most = 0, round(duration / STEP)
        self._seen = robot.sense()
        self._left = robot.distance
        self.reward = 0.0
        self.path = [self.place]

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return STEP * self._steps

    @property
    def place(self) -> tuple[float, float]:
        """Where it is, in map units."""
        return float(self.robot.place[0]), float(self.robot.place[1])

    @property
    def ended(self) -> str:
        """Whether it is at its goal, or its own brain has given up."""
        if self.robot.distance < ARRIVED:
            return f"goal reached after {self.time:.2f} s"
        return f"goal found {self._verdict} after {self.time:.2f} s" if self._verdict else ""

    @property
    def late(self) -> str:
        """Whether its time is over."""
        return f"time of {STEP * self._most:g} s over" if self._steps >= self._most else ""

    @property
    def succeeded(self) -> bool:
        """Whether it is at its goal, or has rightly found that no way leads there."""
        if self.robot.distance < ARRIVED:
            return True
        goal = float(self.robot.goal[0]), float(self.robot.goal[1])
        return bool(self._verdict) and shortest_path(self.robot.world, self.path[0], goal) is None

    def readings(self) -> Senses:
        """Return what a brain is told."""
        return self._seen

    def sense(self) -> F64:
        """Return the observation, as `SENSES`."""
        told = self._seen
        return gathered(told.ranges, told.contact, told.ahead, told.north, told.distance)

    def own(self) -> F64:
        """Return the steering vector of the scenario's brain, cut off at the bounds."""
        if self._brain is None:
            self._brain = self._make()
        self._wanted = np.asarray(self._brain.step(self._seen), dtype=np.float64)
        return self._wanted.clip(ACTIONS.low, ACTIONS.high)

    def act(self, action: F64) -> None:
        """Turn and move for 10 ms by a steering vector."""
        wanted, self._wanted = self._wanted, None
        if wanted is not None and np.array_equal(action, wanted.clip(ACTIONS.low, ACTIONS.high)):
            action = wanted  # whose length beyond the bounds is the body's to cut
        self.robot.step(action)
        self._steps += 1
        self._verdict = "" if self._brain is None else self._brain.verdict
        self.path.append(self.place)
        before, self._left = self._left, self.robot.distance
        self._seen = self.robot.sense()
        self.reward = before - self._left + (ARRIVAL if self._left < ARRIVED else 0.0)

    def draw(self, ax: Axes) -> None:
        """Draw the map, the way and the robot."""
        draw_world(self.robot.world, ax)
        draw_paths({"path": np.array(self.path)}, ax)
        ax.plot(*self.place, "o", color=COLOURS[1], markersize=5, zorder=6)
