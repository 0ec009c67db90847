"""The event loop: events arrive at the instant of their cause, analog wires run downstream."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from chips.part import Part
from circuits.arrays import F64
from circuits.devices.source import Polyline
from circuits.errors import TopologyError
from system.loop import AnalogWire, EventWire, Loop


@dataclass(frozen=True, slots=True)
class Done:
    events: tuple[tuple[str, float], ...]
    time: F64
    voltage: F64


@dataclass(frozen=True, slots=True)
class Echoer:
    """Fires `delay` s after each event that it gets, and once at `first`; its analog port counts events."""

    delay: float
    first: float = math.inf
    analog: tuple[str, ...] = ("count",)

    def begin(self, time: float = 0.0) -> tuple[float, tuple[float, ...], int]:
        return time, (self.first,) if self.first < math.inf else (), 0

    def next_time(self, state: tuple[float, tuple[float, ...], int]) -> float:
        return math.inf

    def advance(
        self,
        state: tuple[float, tuple[float, ...], int],
        until: float,
        events: Sequence[tuple[str, float]] = (),
        analog: Mapping[str, Polyline] | None = None,
    ) -> tuple[tuple[float, tuple[float, ...], int], float, Done]:
        now, due, count = state
        due = tuple(sorted((*due, *(t + self.delay for _, t in events))))
        count += len(events)
        reached = min(until, due[0]) if due else until
        fired = bool(due) and due[0] <= until
        wave = Done(
            (("out", reached),) if fired else (), np.array([now, reached]), np.full((2, 1), float(count))
        )
        return (reached, due[1:] if fired else due, count), reached, wave


def _ring(workers: int | None) -> list[tuple[str, float]]:
    parts: dict[str, Part[Any]] = {"a": Echoer(0.3, first=1.0), "b": Echoer(0.5)}
    wires = [EventWire("a", "out", "b", "in"), EventWire("b", "out", "a", "in")]
    met: list[tuple[str, float]] = []
    with ThreadPoolExecutor(workers or 1) as executor:
        loop = Loop(parts, wires, [], horizon=10.0, executor=executor if workers else None)
        while loop.time < 5.0:
            met += [(part, round(time, 9)) for part, _, time in loop.step(5.0).events]
    return met


def test_feedback_is_never_late() -> None:
    assert _ring(None) == [
        ("a", 1.0), ("b", 1.5), ("a", 1.8), ("b", 2.3), ("a", 2.6), ("b", 3.1), ("a", 3.4), ("b", 3.9),
        ("a", 4.2), ("b", 4.7), ("a", 5.0),
    ]  # fmt: skip


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_the_answer_does_not_depend_on_the_workers(workers: int) -> None:
    assert _ring(workers) == _ring(None)


def test_parts_beyond_an_event_are_advanced_again() -> None:
    parts: dict[str, Part[Any]] = {"slow": Echoer(0.1), "quick": Echoer(0.1, first=0.25)}
    loop = Loop(parts, [], [], horizon=1.0)
    loop.step(2.0)
    assert loop.time == 0.25
    assert loop.repeated == 1
    assert loop.states["slow"][0] == 0.25


def test_events_of_one_time_come_in_the_order_of_the_parts_whichever_did_most() -> None:
    @dataclass(frozen=True, slots=True)
    class Detailed(Echoer):
        points: int = 2

        def advance(self, *given: Any) -> tuple[Any, float, Done]:
            state, reached, done = Echoer.advance(self, *given)
            time = np.linspace(given[0][0], reached, self.points)
            return state, reached, Done(done.events, time, np.zeros((self.points, 1)))

    parts: dict[str, Part[Any]] = {f"p{k}": Detailed(0.1, first=1.0, points=2 + k) for k in range(6)}
    loop = Loop(parts, [], [], horizon=0.6)
    loop.step(2.0)
    assert [name for name, _, _ in loop.step(2.0).events] == list(parts)


def test_analog_wires_order_the_parts() -> None:
    parts: dict[str, Part[Any]] = {"sink": Echoer(0.1), "origin": Echoer(0.1, first=0.5)}
    wire = AnalogWire("origin", "count", "sink", "in")
    loop = Loop(parts, [], [wire], horizon=1.0)
    assert loop.step(1.0).stop == 0.5


def test_a_ring_of_analog_wires_is_refused() -> None:
    parts: dict[str, Part[Any]] = {"a": Echoer(0.1), "b": Echoer(0.1)}
    wires = [AnalogWire("a", "count", "b", "in"), AnalogWire("b", "count", "a", "in")]
    with pytest.raises(TopologyError, match="ring through a, b"):
        Loop(parts, [], wires, horizon=1.0)
