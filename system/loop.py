"""The event loop: it moves the parts of a running system together, so that no event ever comes late.

All parts stand at one common time t. A round picks a horizon T and advances every part to it, upstream
of analog wires first. A part that meets an output event stops there, and T shrinks to that event:
parts already beyond it are advanced again from their state at t. Events at T are delivered when the
next round starts, so that feedback within a cycle takes effect at the instant of its cause.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from contextvars import copy_context
from dataclasses import dataclass, field
from itertools import chain
from typing import Any, final

from chips.part import Advanced, Event, Part
from chips.polyline import thin
from circuits.devices.source import Polyline
from circuits.errors import TopologyError

_LEADING = 4  # parts of a level that go before the others, which is a matter of speed; ours


@dataclass(frozen=True, slots=True)
class _Wire:
    """From a port of one part to a port of another, each by its name.

    source, port : where it begins.
    target, target_port : where it ends.
    """

    source: str
    port: str
    target: str
    target_port: str


@final
@dataclass(frozen=True, slots=True)
class EventWire(_Wire):
    """A wire by which the events of one part's port arrive at another's."""


@final
@dataclass(frozen=True, slots=True)
class AnalogWire(_Wire):
    """A wire by which one part's analog port drives another's.

    tolerance : voltage to which the polyline is thinned, V.
    """

    tolerance: float = 1e-3


@dataclass(slots=True)
class Round:
    """What happened in one round: the time reached, the events at its end, every part's output.

    start : time at which it began, s.
    stop : time that was reached, s.
    outputs : of every part, by its name.
    """

    start: float
    stop: float
    events: tuple[tuple[str, str, float], ...]  # (part, port, time)
    outputs: dict[str, Advanced]


@dataclass(slots=True)
class Loop:
    """Parts that live in a run, the wires between them, and their present states.

    Attributes
    ----------
    parts : mapping of str to Part
        The parts by name.
    events : sequence of EventWire
        Wires of events.
    analog : sequence of AnalogWire
        Wires of voltages; they must form no ring.
    horizon : float
        Longest round, s.
    executor : Executor or None
        Runs parts that do not depend on each other at once, where it is given.
    time : float
        Time at which all parts stand, s.
    states : dict of str to object
        State of each part by its name.
    pending : dict of str to list of (str, float)
        Events that are delivered when the next round starts, by the name of the part.
    repeated : int
        How many advances of parts were done again after an event.

    Raises
    ------
    TopologyError
        The analog wires form a ring.
    """

    parts: Mapping[str, Part[Any]]
    events: Sequence[EventWire]
    analog: Sequence[AnalogWire]
    horizon: float
    executor: Executor | None = None
    time: float = 0.0
    states: dict[str, Any] = field(default_factory=dict)
    pending: dict[str, list[Event]] = field(default_factory=dict)
    repeated: int = 0
    _levels: list[list[str]] = field(default_factory=list)
    _points: dict[str, int] = field(default_factory=dict)  # analog points of each part in the last round

    def __post_init__(self) -> None:
        """Order the parts along the analog wires; `TopologyError` where these form a ring."""
        self.states = {n: p.begin(self.time) for n, p in self.parts.items()}
        self._levels = _levels(tuple(self.parts), self.analog)

    def step(self, until: float) -> Round:
        """Advance all parts together to their first event, or by one horizon, or to the time `until`, s."""
        stop = min(until, self.time + self.horizon)
        own = [p.next_time(self.states[n]) for n, p in self.parts.items()]
        stop = min([stop, *(t for t in own if t > self.time)])
        delivered, self.pending = self.pending, {}
        results: dict[str, tuple[Any, float, Advanced]] = {}
        for level in self._levels:
            for names in self._in_turn(level):
                results |= self._advance(names, stop, delivered, results)
                stop = min([stop, *(results[n][1] for n in names)])
        late = [n for n, r in results.items() if r[1] > stop]
        for level in self._levels:
            again = [n for n in level if n in late]
            self.repeated += len(again)
            results |= self._advance(again, stop, delivered, results)
        # in the order of the parts, whichever went first
        results = {n: results[n] for level in self._levels for n in level}
        met = [(n, port, time) for n, r in results.items() for port, time in r[2].events]
        for wire in self.events:
            for name, port, _ in met:
                if name == wire.source and port == wire.port:
                    self.pending.setdefault(wire.target, []).append((wire.target_port, stop))
        done = Round(self.time, stop, tuple(met), {n: r[2] for n, r in results.items()})
        self.states = {n: r[0] for n, r in results.items()}
        self._points = {n: r[2].time.size for n, r in results.items()}
        self.time = stop
        return done

    def _in_turn(self, level: Sequence[str]) -> tuple[Sequence[str], Sequence[str]]:
        """The parts of a level that did most in the last round, whose events others need not go beyond."""
        busy = sorted(level, key=lambda name: -self._points.get(name, 0))
        return busy[:_LEADING], busy[_LEADING:]

    def _advance(
        self,
        names: Sequence[str],
        stop: float,
        delivered: Mapping[str, list[Event]],
        results: Mapping[str, tuple[Any, float, Advanced]],
    ) -> dict[str, tuple[Any, float, Advanced]]:
        inputs = self._inputs(names, results)

        def one(name: str) -> tuple[Any, float, Advanced]:
            part, state = self.parts[name], self.states[name]
            return part.advance(state, stop, delivered.get(name, ()), inputs[name])

        if self.executor is None or len(names) < 2:
            return {n: one(n) for n in names}
        waiting = iter(names)  # each thread takes the next one: to hand over every part by itself takes long

        def some() -> list[tuple[str, tuple[Any, float, Advanced]]]:
            return [(name, one(name)) for name in waiting]

        # a thread has none of this one's context variables
        here = [copy_context() for _ in range(min(len(names), os.cpu_count() or 1))]
        found = dict(chain(*self.executor.map(lambda context: context.run(some), here)))
        return {name: found[name] for name in names}

    def _inputs(
        self, names: Sequence[str], results: Mapping[str, tuple[Any, float, Advanced]]
    ) -> dict[str, dict[str, Polyline]]:
        """Polylines by port that drive parts; what one port drives several by is thinned once."""
        thinned: dict[tuple[str, str, float], Polyline] = {}
        found: dict[str, dict[str, Polyline]] = {name: {} for name in names}
        for wire in self.analog:
            if wire.target in found:
                key = wire.source, wire.port, wire.tolerance
                if key not in thinned:
                    output = results[wire.source][2]
                    column = self.parts[wire.source].analog.index(wire.port)
                    thinned[key] = thin(output.time, output.voltage[:, column], wire.tolerance)
                found[wire.target][wire.target_port] = thinned[key]
        return found


def _levels(names: tuple[str, ...], wires: Sequence[AnalogWire]) -> list[list[str]]:
    """Parts in order of the analog wires, those of one level independent of each other."""
    placed: set[str] = set()
    levels: list[list[str]] = []
    while len(placed) < len(names):
        ready = [
            n for n in names if n not in placed and all(w.source in placed for w in wires if w.target == n)
        ]
        if not ready:
            left = ", ".join(n for n in names if n not in placed)
            raise TopologyError(f"loop: analog wires form a ring through {left}; break it with an event")
        levels.append(ready)
        placed |= set(ready)
    return levels
