"""The contract of a robot that goes on by one action at a time, with noctule's controller or another's.

`System.open` makes one of a scenario. A run step by step (`system.play.run`) and the environments of
Gymnasium (`system.gym`) drive it; a system that a user registers is driven alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar, final

from circuits.arrays import I64
from system.live.signals import Array, Signals

if TYPE_CHECKING:
    from matplotlib.axes import Axes

State = TypeVar("State")


@final
@dataclass(frozen=True, slots=True)
class Chosen(Generic[State]):
    """What a robot's own law chose, by pings and arcs: the action, and the state that the choice leaves."""

    action: I64
    after: State


class LiveRobot(Protocol):
    """A robot in its world, at its start when it is made; `act` overwrites it."""

    @property
    def senses(self) -> Signals:
        """What an observation is."""

    @property
    def actions(self) -> Signals:
        """What an action is."""

    @property
    def time(self) -> float:
        """Time since the start, s."""

    @property
    def reward(self) -> float:
        """Reward of the last step, a number whose unit the system's page says; 0 before the first."""

    @property
    def ended(self) -> str:
        """Why the run is over, for good; empty while it goes on."""

    @property
    def late(self) -> str:
        """Why the run is cut off, as by its time; empty while there is some left."""

    @property
    def succeeded(self) -> bool:
        """Whether it has done by now what the system is for."""

    @property
    def place(self) -> tuple[float, float]:
        """Where it is, in the unit of its world."""

    def sense(self) -> Array:
        """Return the observation at this time, in the shape of `senses`."""

    def readings(self) -> Any:
        """Return what the observation was made of: events, echoes or spikes as the robot has them."""

    def own(self) -> Array:
        """Return the action of noctule's own controller; made at the first call, which may calibrate a chip.

        Called once a step at most, before `act`.
        """

    def act(self, action: Array) -> None:
        """Go on by a step with an action, which has been checked (`actions`).

        An action equal to what `own` returned is the own controller's step to the bit.
        """

    def draw(self, ax: Axes) -> None:
        """Draw the world, the way so far and the robot on the axes `ax`."""
