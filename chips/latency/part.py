"""The latency chip as a part of a running system: events of pings go in, winners come out.

Inputs are events on `onset`, `reset`, and `memory[p]`, `goal[p]` and `direction[g]`; outputs `winner[p]` and
`emergency`, as they leave the bus. What the chip says after a ping is `LatencyChip.ping`'s, of the events
that have come by then: all of it is causal, so that what comes later changes nothing that was said, but for a
bus on which events wait for each other. What comes before the first onset is not heard.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from chips.latency.chip import LatencyChip, PingResponse
from chips.latency.kernel import Memory
from chips.part import Analog, Event, Output, next_due, port_index, tell
from circuits.errors import ParameterError


@dataclass(frozen=True, slots=True)
class PingState:
    """State of a latency chip in a loop.

    time: reached, s; memory: as it was at the onset of the present ping; start: of that ping, s, nan before
    the first; heard: events of this ping, (s after its onset, address); due: what the chip will send unless
    more comes, in order; unheard: events before the first onset.
    """

    time: float
    memory: Memory
    start: float = math.nan
    heard: tuple[tuple[float, int], ...] = ()
    due: tuple[Event, ...] = ()
    unheard: int = 0


class LatencyPart:
    """A latency chip in a loop, without units at transistor level; path: named in errors."""

    analog: tuple[str, ...] = ()

    def __init__(self, chip: LatencyChip, path: str = "latency_chip") -> None:
        """Raise `ParameterError` for a chip with units at transistor level, whose states are their own."""
        if chip.units:
            raise ParameterError(f"{path}.units: {len(chip.units)}, must be none in a loop; leave them out")
        self.chip, self.path = chip, path

    def begin(self, time: float = 0.0) -> PingState:
        """Return the state after a reset at `time` s."""
        memory = self.chip.new_memory()
        self.chip.reset(memory, time)
        return PingState(time, memory)

    def next_time(self, state: PingState) -> float:
        """Return the time of the next event that the chip sends unless it receives more, s, inf for none."""
        return next_due(state)

    def advance(
        self, state: PingState, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[PingState, float, Output]:
        """Advance to `until` s or to the first event that the chip sends.

        Those of one moment come together.
        """
        for port, time in sorted(events, key=lambda e: e[1]):
            state = self._heard(state, port, time)
        return tell(state, until)

    def response(self, state: PingState) -> PingResponse:
        """Return the response to the present ping, by what the chip has received so far."""
        return self._response(state, _copied(state.memory))

    def _response(self, state: PingState, memory: Memory) -> PingResponse:
        times, addresses = zip(*state.heard, strict=True)
        return self.chip.ping(
            memory, state.start, np.array(times, dtype=np.float64), np.array(addresses, dtype=np.int64)
        )

    def _heard(self, state: PingState, port: str, time: float) -> PingState:
        if port in {"onset", "reset"}:
            memory = _copied(state.memory)
            if state.heard:
                self._response(state, memory)  # what the ping that is over has left behind
            if port == "reset":
                self.chip.reset(memory, time)
                return PingState(state.time, memory, unheard=state.unheard)
            state = PingState(
                state.time, memory, time, ((0.0, self.chip.addresses.onset),), unheard=state.unheard
            )
        elif not state.heard:
            return replace(state, unheard=state.unheard + 1)
        else:
            state = replace(state, heard=(*state.heard, (time - state.start, self._address(port))))
        return replace(state, due=self._due(state, time))

    def _due(self, state: PingState, after: float) -> tuple[Event, ...]:
        """What the chip says after the latest event, s."""
        response, start = self.response(state), state.start
        winners = zip(response.times.tolist(), response.paths, strict=True)
        found = [(f"winner[{p}]", start + t) for t, p in winners]
        if response.emergency < math.inf:
            found.append(("emergency", start + response.emergency))
        return tuple(sorted((e for e in found if e[1] > after), key=lambda e: e[1]))

    def _address(self, port: str) -> int:
        a, head = self.chip.addresses, port.partition("[")[0]
        n, groups = self.chip.design.paths, len(self.chip.design.second)
        begin, count = {"goal": (a.goal, n), "direction": (a.direction, groups)}.get(head, (0, n))
        name = head if head in {"goal", "direction"} else "memory"
        return begin + port_index(port, name, count, self.path)


def _copied(memory: Memory) -> Memory:
    return memory._replace(**{name: getattr(memory, name).copy() for name in Memory._fields})
