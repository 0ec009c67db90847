"""A part alone in the event loop, with a script of events."""

from __future__ import annotations

import math
import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from chips.part import Analog, Event, Output, Part
from circuits.devices.source import Polyline
from system.loop import EventWire, Loop


@dataclass(frozen=True, slots=True)
class Script:
    """Sends events at set times; a line of its own is on its analog port."""

    events: tuple[Event, ...]
    line: Polyline = (np.zeros(1), np.zeros(1))
    analog: tuple[str, ...] = ("line",)

    def begin(self, time: float = 0.0) -> float:
        return time - 1e-12  # so that events of the first moment are sent

    def next_time(self, state: float) -> float:
        return min((t for _, t in self.events if t > state), default=math.inf)

    def advance(
        self, state: float, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[float, float, Output]:
        reached = min(until, self.next_time(state))
        found = tuple(e for e in self.events if state < e[1] <= reached)
        inside = self.line[0][(self.line[0] > state) & (self.line[0] < reached)]
        times = np.array([state, *inside, max(reached, np.nextafter(state, np.inf))])
        return reached, reached, Output(found, times, np.interp(times, *self.line)[:, None])


def looped(
    part: Part[Any], events: Sequence[Event], until: float, horizon: float = 1e-3
) -> tuple[list[Event], Any]:
    """What a part says to events in the loop, and its last state, through a pickle at every round."""
    wires = [EventWire("script", port, "part", port) for port in {port for port, _ in events}]
    loop = Loop({"script": Script(tuple(events)), "part": part}, wires, [], horizon=horizon)
    said: list[Event] = []
    while loop.time < until:
        done = loop.step(until)
        said += [(port, time) for name, port, time in done.events if name == "part"]
        loop.states["part"] = pickle.loads(pickle.dumps(loop.states["part"]))
    return said, loop.states["part"]
