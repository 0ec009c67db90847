"""What is read of a run at its points: values of waveforms, times of their crossings, and their slopes.

A measure reads the parabola through the last points of the step that it falls into, as the solver does for
spikes. Its slopes are those of that parabola, so that they belong to the value that is told. As the steps of
a run move with its edges (`circuits.gradient.section`), it has slopes by their times too: a point of a
parabola p that moves by dt bends it there by `-p' dt`.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.gradient.backwards import Tap
from circuits.gradient.way import Way
from circuits.lowering.kernel import Machine

_BISECTIONS = 60
TIE = 1e-3  # V, or of a current, within which two extremes are one as far as a designer is concerned; ours
RAIL = 0.02  # of the supply, within which a peak stands at it; ours
FEW, FLAT = 3, 0.1  # points of a peak, and the share of its height that its top may change by; ours

Slopes = tuple[tuple[int, int, float], ...]  # (row, column, slope) each
Timing = tuple[tuple[int, float], ...]  # (row, slope) each


class Reading(NamedTuple):
    """A measure of a run.

    value : its value in SI units, NaN where it is not defined.
    slopes : its derivative by voltages: (row, column, slope) each, in its unit a V.
    note : why it has no value, or where it is not smooth; empty else.
    timing : its derivatives by the times of steps: (row, slope) each, in its unit a second.
    taps : what it reads of currents.
    whole : slopes by a column over all rows, (column, float64[rows]) each.
    along : its derivatives by the times of all rows, float64[rows]; None where `timing` has all.
    own : its derivatives by the numbers that it was asked with, as the end of a window: (name, slope) each.
    near : what would have it read something else.
    """

    value: float
    slopes: Slopes
    note: str = ""
    timing: Timing = ()
    taps: tuple[Tap, ...] = ()
    whole: tuple[tuple[int, F64], ...] = ()
    along: F64 | None = None
    own: tuple[tuple[str, float], ...] = ()
    near: tuple[Near, ...] = ()


class Near(NamedTuple):
    """What would have a measure read something else: a peak beside a level, an event beside a window's end.

    reading : it. margin : how far it is from where that happens, in its unit. what : what happens there.
    limit : what it is that far from, after the margin's unit.
    """

    reading: Reading
    margin: float
    what: str
    limit: str


class Passage(NamedTuple):
    """A waveform that passes a level in the step to a row, rising where `sign` is 1, else falling.

    machine : whose highest source and ground a voltage does not leave gradually; None for a current.
    """

    way: Way
    column: int
    level: float
    sign: float
    row: int
    machine: Machine | None

    @property
    def beyond(self) -> F64:
        """How far the waveform is beyond the level, float64[rows]."""
        return self.sign * (self.way.voltage[:, self.column] - self.level)

    def near(self, row: int, what: str, limit: str) -> tuple[Near, ...]:
        """The waveform at a row beside its level, in the frame of the steps; nothing at a rail or an end."""
        if not 0 < row < self.way.time.size - 1 or self._at_rail(row):
            return ()
        value = float(self.way.voltage[row, self.column])
        found = Reading(value, ((row, self.column, 1.0),), own=(("level", -1.0),))
        return (Near(found, abs(value - self.level), what, limit),)

    def _at_rail(self, row: int) -> bool:
        """Whether it is a voltage at ground or at the highest source, which it does not leave gradually."""
        if self.machine is None:
            return False
        high = float(self.way.voltage[row, self.machine.kernel.unknowns :].max(initial=0.0))
        at = float(self.way.voltage[row, self.column])
        return min(abs(high - at), abs(at)) < RAIL * high


def nears_of(passage: Passage, name: str, limit: str, *, arms: bool = False) -> tuple[Near, ...]:
    """Return the peak of an event, and what comes nearest to bringing or taking another one before it.

    name, limit: how they are told. arms: whether the waveform has to go far back before the next event, as
    before a spike, so that no dip between two of them counts.
    """
    found = passage.near(_top(passage), f"{name} vanishes", limit)
    beyond = passage.beyond[: passage.row + 1]
    for rows, what in (
        (_misses(passage, arms), "another one appears"),
        (_turns(beyond, arms), "one vanishes"),
    ):
        for row in rows[np.argsort(np.abs(beyond[rows]), kind="stable")].tolist():
            if own := passage.near(row, f"{what} before {name}", limit):
                found += own
                break
    return found


def _misses(passage: Passage, arms: bool) -> I64:  # noqa: FBT001 - passed on
    """Rows of peaks that do not reach the level, and of dips that do not, both by more than a ripple."""
    beyond = passage.beyond[: passage.row + 1]
    ripple = TIE if passage.machine is not None else TIE * abs(passage.level)
    after, before = np.minimum.accumulate(beyond[::-1])[::-1], np.maximum.accumulate(beyond)
    y, first, last = beyond[1:-1], beyond[:-2], beyond[2:]
    peaks = (y < 0.0) & (y > first) & (y >= last) & (after[1:-1] < y - ripple)
    dips = (y > 0.0) & (y < first) & (y <= last) & (before[1:-1] > y + ripple)
    return np.flatnonzero(peaks if arms else peaks | dips) + 1


def _turns(beyond: F64, arms: bool) -> I64:  # noqa: FBT001 - passed on
    """Rows of the extremes of what lies between two passages before the last one."""
    over = beyond >= 0.0
    at = np.flatnonzero(over[1:] != over[:-1]) + 1
    rows = [
        low + int(np.argmax(np.abs(beyond[low:high])))
        for low, high in pairwise(at.tolist())
        if over[low] or not arms
    ]
    return np.array(rows, np.int64)


def _top(passage: Passage) -> int:
    """Row of an event's peak, from that at which it begins; at its edges a voltage moves with time."""
    row, beyond = passage.row, passage.beyond
    below = np.flatnonzero(beyond[row:] < 0.0)
    end = row + int(below[0]) if below.size else beyond.size
    y, t = beyond[row:end], passage.way.time[row:end]
    if y.size < FEW:
        return row + int(np.argmax(y)) if y.size else row
    rate = np.abs(np.gradient(y, t)) * (t[-1] - t[0])
    flat = rate <= max(float(rate.min()), FLAT * float(y.max()))
    return row + int(np.argmax(np.where(flat, y, -np.inf)))


def uneven(samples: int) -> F64:
    """By what each of some samples is moved to see which a number reads, float64[samples] within 1.

    No two are moved alike: a time of a peak, or a ratio, stays where all that it reads is.
    """
    draw = np.random.default_rng(0)  # of no consequence
    return np.asarray(draw.uniform(0.5, 1.0, samples) * draw.choice([-1.0, 1.0], samples))


def top_of(way: Way, row: int, column: int) -> Reading:
    """Read an extreme at a row: at the vertex of the parabola through its neighbours, else at its time."""
    if not 0 < row < way.time.size - 1:
        return Reading(float(way.voltage[row, column]), ((row, column, 1.0),))
    rows = [row - 1, row, row + 1]
    t, y = way.time[rows], way.voltage[rows, column]
    first, second = np.diff(y) / np.diff(t)
    if 1 in way.order[row : row + 2] or first * second > 0.0 or first == second:
        rate = float(rates(way, np.array([row]), column)[0])
        return Reading(float(y[1]), ((row, column, 1.0),), timing=((row, -rate),))
    vertex = 0.5 * (t[1] - t[0] - first * (t[2] - t[0]) / (second - first))  # after the first
    return _on_parabola(way, rows, column, float(vertex), 1.0)


def rates(way: Way, rows: I64, column: int) -> F64:
    """Return the rates of a column from the row before to the row after each of some rows, V/s."""
    y, t = way.voltage[:, column], way.time
    return np.asarray((y[rows + 1] - y[rows - 1]) / (t[rows + 1] - t[rows - 1]))


def passed(way: Way, row: int, column: int, level: float) -> Reading:
    """Read the time at which a column passes a level within a step, s."""
    low, high = way.time[row - 1], way.time[row]
    falls = way.voltage[row, column] < way.voltage[row - 1, column]
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        before = (_at(way, row, column, middle) > level) == falls
        low, high = (middle, high) if before else (low, middle)
    return crossing(way, column, float(high), row)


def _nodes(way: Way, row: int) -> list[int]:
    """Rows of the points that the parabola of a step goes through."""
    return [row, row - 1] + ([row - 2] if way.order[row] == 2 else [])


def _weights(way: Way, rows: list[int], after: float) -> tuple[F64, F64]:
    """Weights of some rows in their parabola, and in its slope, 1/s; after: the first one, s.

    Times since the beginning are long beside steps, and would be rounded.
    """
    t = way.time[rows] - way.time[rows[0]]
    own, slope = np.ones(len(rows)), np.zeros(len(rows))
    for i in range(len(rows)):
        others = [t[j] for j in range(len(rows)) if j != i]
        scale = np.prod([t[i] - s for s in others])
        own[i] = np.prod([after - s for s in others]) / scale
        slope[i] = (1.0 if len(others) == 1 else 2.0 * after - others[0] - others[1]) / scale
    return own, slope


def _at(way: Way, row: int, column: int, time: float) -> float:
    rows = _nodes(way, row)
    return float(_weights(way, rows, time - way.time[row])[0] @ way.voltage[rows, column])


def read_at(way: Way, row: int, column: int, time: float) -> Reading:
    """Read what the parabola of a step has at a time."""
    rows, after = _nodes(way, row), float(time - way.time[row])
    y = way.voltage[rows, column]
    rate = float(_weights(way, rows, after)[1] @ (y - y[0]))
    return _on_parabola(way, rows, column, after, 1.0)._replace(own=(("at", rate),))


def _on_parabola(way: Way, rows: list[int], column: int, after: float, scale: float) -> Reading:
    """What the parabola of some rows has at a time after the first one, s; scale: of its slopes."""
    y, (own, _) = way.voltage[rows, column], _weights(way, rows, after)
    since = way.time[rows] - way.time[rows[0]]
    rate = [float(_weights(way, rows, float(t))[1] @ (y - y[0])) for t in since]
    slopes = tuple((row, column, scale * float(w)) for row, w in zip(rows, own, strict=True))
    timing = tuple((row, -slope * by) for (row, _, slope), by in zip(slopes, rate, strict=True))
    return Reading(float(own @ y), slopes, timing=timing)


def crossing(way: Way, column: int, time: float, row: int | None = None) -> Reading:
    """Read a time at which a column passes a level, in the step to a row: it moves by `-dv / slope`."""
    row = max(int(np.searchsorted(way.time, time - 1e-15)), 1) if row is None else row
    rows = _nodes(way, row)
    y, after = way.voltage[rows, column], time - float(way.time[row])
    rate = float(_weights(way, rows, after)[1] @ (y - y[0]))
    found = _on_parabola(way, rows, column, after, -1.0 / rate)
    return found._replace(value=time, own=(("level", 1.0 / rate),))
