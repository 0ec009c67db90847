"""Events of a sensor, and the bus that reads them out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circuits.compiled import compiled

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

_compiled = compiled()


@dataclass(frozen=True, slots=True, eq=False)
class Events:
    """Events in the order in which they were read out.

    time: float64[n], s; x: int64[n], column from the left; y: int64[n], row from the bottom; on: bool[n];
    lost: how many more the bus could not carry.
    """

    time: F64
    x: I64
    y: I64
    on: NDArray[np.bool_]
    lost: int = 0

    def __len__(self) -> int:
        return len(self.time)

    def where(self, chosen: NDArray[np.bool_]) -> Events:
        """The events where `chosen`, bool[n], is true."""
        return Events(self.time[chosen], self.x[chosen], self.y[chosen], self.on[chosen], self.lost)


def joined(parts: Sequence[Events]) -> Events:
    """Events of several stretches of time as one."""
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


@_compiled
def read_out(time: F64, gap: float, depth: int, free: F64, kept: NDArray[np.bool_]) -> int:
    """Pass sorted events over a bus that carries one in `gap` s, and holds `depth` that wait.

    time: s, becomes when each was read out; free: float64[1], s, when the bus is free; kept: filled. Returns
    how many were lost.
    """
    lost = 0
    for i in range(time.size):
        if free[0] - time[i] > depth * gap:
            kept[i] = False
            lost += 1
        else:
            kept[i] = True
            time[i] = max(free[0], time[i])
            free[0] = time[i] + gap
    return lost
