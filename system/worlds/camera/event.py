"""Events of a dynamic vision sensor, and the bus that reads them out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled
from circuits.event import sort_events

_INSTANT = 1e-12  # s, in which events are too close to be told apart by equal bins
_CROWD = 64  # events beside each in its bin, from where on sorting by comparison is as fast; ours
_compiled = compiled()


@dataclass(frozen=True, slots=True, eq=False)
class Events:
    """Events in the order in which they were read out.

    Attributes
    ----------
    time : array
        Times, float64[n], s.
    x, y : array
        Column from the left and row from the bottom, int64[n].
    on : array
        Whether it is an ON event, bool[n].
    lost : int
        How many more the bus could not carry.
    """

    time: F64
    x: I64
    y: I64
    on: Bools
    lost: int = 0

    def __len__(self) -> int:
        return len(self.time)

    def where(self, chosen: Bools) -> Events:
        """The events where `chosen`, bool[n], is true."""
        return Events(self.time[chosen], self.x[chosen], self.y[chosen], self.on[chosen], self.lost)


def joined(parts: Sequence[Events]) -> Events:
    """Return the events of several stretches of time as one."""
    if not parts:
        none = np.empty(0, dtype=np.int64)
        return Events(np.empty(0), none, none, np.empty(0, dtype=np.bool_))
    return Events(
        np.concatenate([p.time for p in parts]),
        np.concatenate([p.x for p in parts]),
        np.concatenate([p.y for p in parts]),
        np.concatenate([p.on for p in parts]),
        sum(p.lost for p in parts),
    )


def frame(events: Events, columns: int, rows: int) -> I64:
    """On events minus off events a pixel, int64[rows, columns], row 0 at the bottom."""
    image = np.zeros((rows, columns), dtype=np.int64)
    np.add.at(image, (events.y, events.x), np.where(events.on, 1, -1))
    return image


def in_order(time: F64, code: I64) -> tuple[F64, I64]:
    """Events (s, code) sorted by time, those of one time in the order in which they came; copies."""
    to_time, to_code = np.empty_like(time), np.empty_like(code)
    if not _deal(time, code, np.zeros(time.size + 2, dtype=np.int64), to_time, to_code):
        order = np.argsort(time, kind="stable")
        return time[order], code[order]
    return to_time, to_code


@_compiled
def _deal(time: F64, code: I64, begin: I64, to_time: F64, to_code: I64) -> bool:
    """Deal events to as many bins of equal length as they are, then put right what is left, one by one.

    begin: int64[n + 2], zeros, overwritten. False, without a result, where they crowd in few bins.
    """
    n, low, high = time.size, np.inf, -np.inf
    for i in range(n):
        low, high = min(low, time[i]), max(high, time[i])
    if not high - low > _INSTANT:
        return False
    scale, pairs = (n - 1) / (high - low), 0
    for i in range(n):
        k = int((time[i] - low) * scale) + 2
        pairs += begin[k]
        begin[k] += 1
    if pairs > _CROWD * n:
        return False
    for k in range(2, n + 2):
        begin[k] += begin[k - 1]
    for i in range(n):
        k = int((time[i] - low) * scale) + 1
        to_time[begin[k]], to_code[begin[k]] = time[i], code[i]
        begin[k] += 1
    sort_events(to_time, to_code, n)
    return True


class Bus(NamedTuple):
    """A bus that takes `gap` s for an event, and holds up to `depth` that wait."""

    gap: float
    depth: int


def read_out(bus: Bus, rows: int, time: F64, code: I64, free: F64) -> Events:
    """Pass events over a bus, each when it is free; those that find no room are lost.

    Parameters
    ----------
    rows
        Of the sensor.
    time, code
        float64[n], s, in order, and int64[n], (column * rows + row) * 2 + polarity; overwritten.
    free
        float64[1], s, when the bus is free; goes on.
    """
    x, y, on = np.empty_like(code), np.empty_like(code), np.empty(code.size, dtype=np.bool_)
    passed = _pass(bus, rows, time, code, free, x, y, on)
    return Events(time[:passed], x[:passed], y[:passed], on[:passed], time.size - passed)


@_compiled
def _pass(bus: Bus, rows: int, time: F64, code: I64, free: F64, x: I64, y: I64, on: Bools) -> int:
    """Keep what the bus carries at the begin of the arrays; how many."""
    passed = 0
    for i in range(time.size):
        if free[0] - time[i] > bus.depth * bus.gap:
            continue
        time[passed] = max(free[0], time[i])
        free[0] = time[passed] + bus.gap
        pixel = code[i] >> 1
        x[passed] = pixel // rows
        y[passed] = pixel - rows * x[passed]
        on[passed] = code[i] & 1 == 1
        passed += 1
    return passed
