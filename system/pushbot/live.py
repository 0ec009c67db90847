"""A Pushbot in its scene that goes on look by look (`system.live.robot`).

An action is a speed and a turn rate, which reach the motors over the robot's link. What it senses are the
events of its camera in the last look, counted a pixel. The reward is the way driven in m, `TOUCH` less where
it touches something (ours).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import F64
from system.live.signals import Array, Channel, Signals
from system.plot import COLOURS
from system.pushbot.body import forward_of, turn_of
from system.pushbot.course import Errand
from system.pushbot.drive import Readings, Run, go_on, steer
from system.pushbot.loop import Command, Loop, command_with, think
from system.pushbot.readout import Readout
from system.pushbot.scene_picture import draw_path, draw_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TOUCH = 5.0  # m of way that a collision costs; ours
MOST = 255  # events of a pixel, a sign and a look that are told; ours


class LivePushbot:
    """A Pushbot on its drive; `System.open` of the Pushbot.

    Parameters
    ----------
    drive : the robot at its start.
    errand : when its run ends, and what for.
    loop : makes the chip in its loop when its commands are first asked for.
    readout : how long a look is.
    """

    def __init__(self, drive: Run, errand: Errand, loop: Callable[[], Loop], readout: Readout) -> None:
        self.drive, self.errand, self._make, self._look = drive, errand, loop, readout.look
        robot, dvs = drive.robot, drive.sensor.dvs
        fastest = 2.0 * robot.top_speed / (robot.slip * robot.wheel_distance)
        self.senses = Signals(
            (
                Channel(
                    "events, by row from the bottom, column, and off or on",
                    "",
                    0,
                    MOST,
                    (dvs.rows, dvs.columns, 2),
                ),
            ),
            "frame",
        )
        self.actions = Signals(
            (
                Channel("speed ahead", "m/s", -robot.top_speed, robot.top_speed),
                Channel("turn rate, to the left", "rad/s", -fastest, fastest),
            )
        )
        self._unit = forward_of(robot, 1.0), turn_of(robot, 1.0)  # of the robot's code
        self._loop: Loop | None = None
        self._command: Command | None = None
        self._told = np.zeros(2)
        self.reward, self._before = 0.0, drive.time
        self._seen = go_on(drive, self._look)

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self.drive.time

    @property
    def place(self) -> tuple[float, float]:
        """Where it is, m."""
        return self.drive.pose[0], self.drive.pose[1]

    @property
    def ended(self) -> str:
        """Whether it touched something, or passed the line of its obstacles."""
        return self.errand.ended(self.drive)

    @property
    def late(self) -> str:
        """Whether its time or way is over."""
        return self.errand.late(self.drive)

    @property
    def succeeded(self) -> bool:
        """Whether it has touched nothing, and done what its scene asks for."""
        return self.errand.reached(self.drive)

    def readings(self) -> Readings:
        """Return the events of the last look, at their times, and the samples of its gyro."""
        return self._seen

    def sense(self) -> Array:
        """Return the observation, uint8[rows, columns, 2]; `MOST` where a pixel has more events than that."""
        counts = np.zeros(self.senses.shape, dtype=np.int64)
        events = self._seen.events
        np.add.at(counts, (events.y, events.x, events.on.astype(np.int64)), 1)
        return counts.clip(0, MOST).astype(np.uint8)

    def own(self) -> F64:
        """Return what the chip commands, cut off at the bounds; the last command again where none is due."""
        if self._loop is None:
            self._loop = self._make()
        self._command = think(self._loop, self._seen, self._before)
        if self._command is not None:
            ahead, turn = (c / unit for c, unit in zip(self._command, self._unit, strict=True))
            self._told = np.array([ahead, turn]).clip(self.actions.low, self.actions.high)
        return self._told.copy()

    def act(self, action: F64) -> None:
        """Send a command, and drive on for a look."""
        if self._loop is None or not np.array_equal(action, self._told):
            steer(self.drive, self._unit[0] * float(action[0]), self._unit[1] * float(action[1]))
            self._told = np.array(action)
        elif self._command is not None:
            command_with(self._loop, self._command)
        self._command = None
        way, self._before = self.drive.way, self.drive.time
        self._seen = go_on(self.drive, self._look)
        self.reward = self.drive.way - way - TOUCH * (self.drive.touched is not None)

    def draw(self, ax: Axes) -> None:
        """Draw the scene, the way and the robot."""
        draw_scene(self.drive.scene, ax, self.time)
        draw_path(np.array(self.drive.path), ax)
        x, y, heading = self.drive.pose
        ax.plot(x, y, marker=(3, 0, math.degrees(heading) - 90.0), color=COLOURS[1], markersize=8)
