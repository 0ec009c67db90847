"""A car in its forest that goes on ping by ping (`system.live.robot`).

An action is the arc that is driven until the next ping, the direction of that ping, and whether the car backs
up instead, the way that it came. What it senses are the places that the last ping showed, and its heading.
The reward is the way through the forest in m, and `THROUGH` more or less where it comes through, or touches a
pipe or leaves by a side (ours).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import F64, I64
from system.car.drive import REASONS, Voyage, choose, go, look
from system.car.numbers import ARCS, DIRECTIONS
from system.car.picture import draw_robot
from system.live.robot import Chosen
from system.live.signals import Channel, Signals, gathered, padded
from system.openspace.choice import arc_actions

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PLACES = 8  # of an observation, the nearest; ours
THROUGH = 1.0  # m of way that an end is worth; ours
FAR = 100.0  # m, farther than any ping shows
SENSES = Signals(
    (
        Channel("cosine of the heading, from the way through", "", -1.0, 1.0),
        Channel("sine of the heading, to the left", "", -1.0, 1.0),
        Channel("direction of the last ping, to the left", "rad", -math.pi, math.pi),
        Channel("angle of the wheels, to the left", "rad", -math.pi, math.pi),
        Channel("places of the nearest pipes, ahead, 0 for none", "m", -FAR, FAR, (PLACES,)),
        Channel("the same, to the left", "m", -FAR, FAR, (PLACES,)),
    )
)  # fmt: skip
ACTIONS = arc_actions(ARCS, DIRECTIONS, "whether it backs up")


class LiveCar:
    """A car on its drive; `System.open` of the car.

    car : at its start.
    pings : after which it is cut off.
    """

    senses, actions = SENSES, ACTIONS

    def __init__(self, car: Voyage, pings: int) -> None:
        self.car, self._most = car, pings
        self.reward, self._end = 0.0, "undecided"
        self._choice: Chosen[Voyage] | None = None
        self._steps = 0
        self.path = [self.place]
        look(car)
        self.rows = [car.row()]

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return float(self.car.time)

    @property
    def place(self) -> tuple[float, float]:
        """Where the middle of the body is, m."""
        return float(self.car.pose[0]), float(self.car.pose[1])

    @property
    def ended(self) -> str:
        """Whether it came through, left by a side or touched a pipe."""
        return REASONS.get(self._end, "")

    @property
    def late(self) -> str:
        """Whether all pings are made."""
        return f"all {self._most} pings made" if self._steps >= self._most else ""

    @property
    def succeeded(self) -> bool:
        """Whether it came through."""
        return self._end == "through"

    def readings(self) -> F64:
        """Places that the last ping showed, in the body's frame, float64[n, 2], m, nearest first."""
        seen = self.car.seen
        return np.asarray(seen[np.argsort(np.hypot(*seen.T), kind="stable")])

    def sense(self) -> F64:
        """Return the observation, as `SENSES`."""
        car, heading = self.car, self.car.pose[2]
        told = car.arcs.direction[car.pinged], car.arcs.steering[car.arc]
        return gathered(math.cos(heading), math.sin(heading), told, padded(self.readings(), PLACES, 0.0).T)

    def own(self) -> I64:
        """Return the action of Curved Openspace."""
        after = replace(self.car, counts=dict(self.car.counts))
        retreat = choose(after)
        action = np.array([after.arc, after.head, retreat], dtype=np.int64)
        self._choice = Chosen(action, after)
        return action.copy()

    def act(self, action: I64) -> None:
        """Drive on with an action until the next ping, and ping."""
        chosen, self._choice = self._choice, None
        arc, head, retreat = (int(number) for number in action)
        if chosen is not None and np.array_equal(action, chosen.action):
            self.car = chosen.after
        elif not retreat:
            self.car.arc, self.car.head, self.car.scanning = arc, head, False
        before = self.car.pose[0]
        self._end = go(self.car, retreat=bool(retreat))
        self._steps += 1
        self.path.append(self.place)
        end = {"undecided": 0.0, "through": THROUGH}.get(self._end, -THROUGH)
        self.reward = float(self.car.pose[0] - before) + end
        if not self.ended:
            look(self.car)
            self.rows.append(self.car.row())

    def draw(self, ax: Axes) -> None:
        """Draw the pipes, the way and the pings."""
        car = self.car
        draw_robot(car.forest, car.arcs, np.array(self.path), np.array(self.rows), car.robot.zone, ax)
