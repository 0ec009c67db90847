"""What is read of a run at its points: values of waveforms, times of their crossings, and their slopes.

A measure reads the parabola through the last points of the step that it falls into, as the solver does for
spikes. Its slopes are those of that parabola, so that they belong to the value that is told. As the steps of
a run move with its edges (`circuits.gradient.section`), it has slopes by their times too: a point of a
parabola p that moves by dt bends it there by `-p' dt`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.gradient.backwards import Tap
from circuits.gradient.way import Way

_BISECTIONS = 60

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
    """

    value: float
    slopes: Slopes
    note: str = ""
    timing: Timing = ()
    taps: tuple[Tap, ...] = ()
    whole: tuple[tuple[int, F64], ...] = ()
    along: F64 | None = None
    own: tuple[tuple[str, float], ...] = ()


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
