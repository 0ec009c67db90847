"""Behavioural model of the centroid board, as a part of a running system.

Same ports as the circuit: events spike[k] in, proximity (analog) out. A spike opens its neuron's gate for one
event's width; open gates pull the hold node towards their look-up voltages, each with the strength that was
measured, and simultaneous spikes average. Between spikes the node leaks towards the measured far default.
Equations in `chips.boards.centroid.kernel`, numbers from `chips.boards.centroid.measure`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from chips.boards.centroid.kernel import Centroid, centroid_run
from chips.measured.table_record import all_on_silicon, tables_on
from chips.part import Analog, Event, Output, Unforeseen
from circuits.arrays import F64
from circuits.blocks.sonar import centroid_board
from circuits.circuit import Circuit
from circuits.errors import unknown_name
from circuits.event import HALF_WIDTH, LENGTH
from circuits.silicon.silicon import Silicon

_ROOM = 64  # vertices worked out at once


@dataclass(frozen=True, slots=True)
class CentroidState:
    """State of a centroid board.

    board: time (s), hold node, follower and low-pass (V), float64[4]; ends: when each gate goes off, s,
    float64[neurons]; merged: events lost in the pulse of the one before.
    """

    board: F64
    ends: F64
    merged: int = 0

    @property
    def time(self) -> float:
        """Time that was reached, s."""
        return float(self.board[0])


@cache
def circuits() -> tuple[Circuit, ...]:
    """Return the circuit that the model stands for."""
    return (centroid_board.build(),)


class CentroidModel(Unforeseen):
    """A centroid board on a silicon.

    lookup: voltage for which each neuron stands, V, the board's own unless given; path: the instance path
    named in errors. Raises `ParameterError` for silicon outside the record's box, and `DataError` where the
    record is of another circuit.
    """

    def __init__(
        self, silicon: Silicon, lookup: Sequence[float] | None = None, path: str = "centroid_board"
    ) -> None:
        """Read the record at the silicon's temperature and die."""
        data = tables_on(silicon, "centroid_board", circuits, path)
        entry = np.array(centroid_board.linear_lookup() if lookup is None else lookup)
        names = "log_share", "log_far_default", "offset_V", "leak_time_s", "filter_time_s", "slew_time_s"
        strength, far, offset, leak, low_pass, slew = all_on_silicon(data, names, silicon)
        known = centroid_board.linear_lookup()
        share = np.interp(entry, known[::-1], strength[::-1]) / HALF_WIDTH
        self.numbers = Centroid(
            share, entry, math.exp(far), float(offset), float(leak), float(low_pass), float(slew),
            silicon.process.v_dd,
        )  # fmt: skip
        self.analog: tuple[str, ...] = ("proximity",)
        self._index = {f"spike[{k}]": k for k in range(entry.size)}
        self._path = path

    def begin(self, time: float = 0.0) -> CentroidState:
        """Return the state at `time` s, with the hold node where it leaks to."""
        far = self.numbers.far
        return CentroidState(np.array([time, far, far, far]), np.full(self.numbers.entry.size, -math.inf))

    def advance(
        self, state: CentroidState, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[CentroidState, float, Output]:
        """Advance to `until` s; the output has a vertex at least every 2 ms."""
        board, ends, merged = state.board.copy(), state.ends.copy(), state.merged
        pieces = [np.array([[board[0], board[3] + self.numbers.offset]])]
        for port, time in sorted(events, key=lambda e: e[1]):
            if port not in self._index:
                raise unknown_name(f"{self._path} event port", port, tuple(self._index))
            pieces.append(self._run(board, ends, min(time, until)))
            k = self._index[port]
            if time <= ends[k] - HALF_WIDTH + LENGTH:
                merged += 1
            else:
                ends[k] = time + HALF_WIDTH
        pieces.append(self._run(board, ends, until))
        line = np.concatenate(pieces)
        return CentroidState(board, ends, merged), until, Output((), line[:, 0], line[:, 1:])

    def _run(self, board: F64, ends: F64, until: float) -> F64:
        pieces = []
        while board[0] < until:
            out = np.empty((_ROOM, 2))
            pieces.append(out[: centroid_run(self.numbers, ends, board, until, out)])
        return np.concatenate(pieces) if pieces else np.empty((0, 2))
