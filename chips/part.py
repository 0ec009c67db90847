"""The contract of time: parts of a run say when they act next, and advance up to their first output event.

A part has a state, a value that pickles and is never written to. `begin` gives its first one, `next_time` the
next moment at which it acts by itself, and `advance` takes it to a time, or to its first output event before
that, so that what the event brings about elsewhere is never late. Inputs are events, (port, time s), at or
after the state's time, and polylines on analog ports, in force until others replace them. Chips, boards,
circuits, sensors, robots and worlds are parts; `system.loop` moves them together.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

from circuits.arrays import F64
from circuits.devices.source import Polyline
from circuits.errors import unknown_name

Event = tuple[str, float]  # port (with index, as in spike[3]) and time, s
Analog = Mapping[str, Polyline] | None  # polylines (time s, value) by port, None for no new ones
State = TypeVar("State")


class Advanced(Protocol):
    """What a part returns when it was advanced: its output events, and its analog ports from the start on."""

    @property
    def events(self) -> Sequence[Event]:
        """Output events (port, time s)."""

    @property
    def time(self) -> F64:
        """Times of the analog points, s, float64[T]."""

    @property
    def voltage(self) -> F64:
        """Analog ports at these times, float64[T, ports], V."""


@dataclass(frozen=True, slots=True)
class Output:
    """What a part did over a stretch of time.

    Attributes
    ----------
    events : tuple of (str, float)
        Its output events in order: port and time (s) each.
    time : array
        Times of the analog points, the start included, float64[T], s.
    voltage : array
        Voltages at these times, float64[T, ports], V, in the order of the part's `analog`.
    """

    events: tuple[Event, ...]
    time: F64
    voltage: F64


class Part(Protocol[State]):
    """Something that lives in a run, as a chip, a circuit, a sensor, a robot or a world."""

    @property
    def analog(self) -> tuple[str, ...]:
        """Names of the output's columns."""

    def begin(self, time: float = 0.0) -> State:
        """Return the state at `time` s; states are values that pickle and are never written to."""

    def next_time(self, state: State) -> float:
        """Return when the part next acts by itself from its `state`, s, inf where it cannot know."""

    def advance(
        self, state: State, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[State, float, Advanced]:
        """Advance to a time, or to the first output event.

        Into which spans a run is cut is the caller's, and should move no event; a part whose events it moves
        says by how much.

        Parameters
        ----------
        state
            Where the part stands.
        until
            Time to advance to, s.
        events
            Events that come in: port and time (s) each, in order.
        analog
            Voltages (V) that come in, by port, as polylines; None where nothing changes.

        Returns
        -------
        The new state, the time that was reached (s), and the output.
        """


class Unforeseen:
    """A part that cannot know when it next acts: whoever advances it finds out."""

    __slots__ = ()

    def next_time(self, state: object) -> float:
        """Return inf (s) for every `state`."""
        return math.inf


def quiet(time: float, events: tuple[Event, ...] = ()) -> Output:
    """Return the output of a part without analog ports at `time` s."""
    return Output(events, np.array([time]), np.zeros((1, 0)))


def first_of(due: tuple[Event, ...], until: float) -> tuple[tuple[Event, ...], tuple[Event, ...]]:
    """Split events, which are in order, into those of the first moment up to `until` s, and the others."""
    if not due or due[0][1] > until:
        return (), due
    first = due[0][1]
    count = sum(1 for _, time in due if time == first)
    return due[:count], due[count:]


class Waiting(Protocol):
    """A state, which is a frozen dataclass, of a part that knows ahead what it will send.

    time: reached, s; due: the events to come in order, unless the part receives more before.
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def time(self) -> float:
        """Time reached, s."""

    @property
    def due(self) -> tuple[Event, ...]:
        """Events to come, in order."""


W = TypeVar("W", bound=Waiting)


def next_due(state: Waiting) -> float:
    """Return the time of the next event that is due, s, inf where there is none."""
    return state.due[0][1] if state.due else math.inf


def tell(state: W, until: float) -> tuple[W, float, Output]:
    """Advance such a state to `until` s or to its next event; events of one moment are sent together."""
    now, later = first_of(state.due, until)
    reached = now[0][1] if now else until
    return replace(state, time=reached, due=later), reached, quiet(reached, now)


def port_index(port: str, name: str, count: int, path: str) -> int:
    """Return the index of an element of a port, as 3 of `spike[3]`.

    Raises `UnknownNameError` for a port of another name, or an index that is not below `count`.
    """
    head, _, rest = port.partition("[")
    index = rest.removesuffix("]")
    if head != name or not rest.endswith("]") or not index.isdecimal() or int(index) >= count:
        raise unknown_name(f"{path} event port", port, [f"{name}[0]", f"{name}[{count - 1}]"])
    return int(index)
