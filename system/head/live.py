"""A sonar head that goes on ping by ping (`system.live.robot`).

An action is the angle to which the neck is told to go once the spikes of a ping are counted. What it senses
are these counts, whether the ping had an answer, and its neck. The reward is less by the angle (rad) between
target and head at the next ping; it is 0 where the head points at its target.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from chips.lso.model import SIDES
from circuits.arrays import F64, I64
from system.head.loop import Following, Neck, decision, follows, hear_ping, most_of, told
from system.head.picture import draw_angles
from system.live.signals import Channel, Signals, gathered

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COUNTED = 10_000.0  # spikes of a ping, more than any neuron makes; ours


class LiveHead:
    """A head that follows its target; `System.open` of the head.

    head : at rest, before its first ping.
    """

    def __init__(self, head: Following) -> None:
        self.head, most = head, most_of(head.numbers)
        self.senses = Signals(
            (
                Channel("spikes of the left and of the right neuron", "", 0.0, COUNTED, (SIDES,)),
                Channel("whether the ping had an answer", "", 0.0, 1.0),
                Channel("angle of the neck at the ping, to the left", "rad", -most, most),
                Channel("angle to which it is on its way", "rad", -most, most),
            )
        )
        self.actions = Signals((Channel("angle to go to, to the left", "rad", -most, most),))
        self.reward, self.ended, self._steps = 0.0, "", 0
        hear_ping(head)

    @property
    def time(self) -> float:
        """Time since the start, s, at the last ping or the end."""
        return self._steps / self.head.numbers.ping_rate

    @property
    def place(self) -> tuple[float, float]:
        """Direction of the head, as a unit vector: ahead and to the left."""
        angle = self.head.neck.at(self.time, self.head.numbers.neck_speed)
        return math.cos(angle), math.sin(angle)

    @property
    def late(self) -> str:
        """Whether all pings are made."""
        over = self._steps == len(self.head.echoes)
        return f"time of {self.time:g} s over" if over else ""

    @property
    def succeeded(self) -> bool:
        """Whether it has pointed at its target in the second half of the pings so far."""
        return follows(self.head.log())

    def readings(self) -> I64:
        """Spikes of both neurons that were counted after the last ping, int64[SIDES]."""
        return self.head.heard[-1]

    def sense(self) -> F64:
        """Return the observation, as `senses`."""
        head = self.head
        return gathered(head.heard[-1], not head.lost[-1], head.angles[-1], head.neck.goal)

    def own(self) -> F64:
        """Return the angle to which the spikes of the chip tell it to go."""
        return np.array([told(self.head).goal])

    def act(self, action: F64) -> None:
        """Tell the neck where to go, in whole steps of its servo, and make the next ping."""
        head, when = self.head, decision(self.head)
        step = head.numbers.neck_step
        now = head.neck.at(when, head.numbers.neck_speed)
        head.neck = Neck(now, when, step * round(float(action[0]) / step))
        self._steps += 1
        if not self.late:
            hear_ping(head)
        target = float(head.way.at(self.time)[0])
        self.reward = -abs(target - head.neck.at(self.time, head.numbers.neck_speed))

    def draw(self, ax: Axes) -> None:
        """Draw the directions of head and target over the time so far."""
        draw_angles(self.head.log(), ax)
        ax.set_xlabel("time (s)")
