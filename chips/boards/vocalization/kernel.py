"""Compiled equations of the vocalization controller: the phase of its oscillator, and its next call.

From the end of a call's dead time the phase grows as `a + b p` with the proximity voltage p; the next call
comes when it reaches one, solved exactly where p is a straight line.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled


class Vocalization(NamedTuple):
    """Numbers of a vocalization controller on a die.

    base, slope: rate of the phase without proximity voltage, 1/s, and over it, 1/(V s); dead: time after a
    call in which the phase stands still, s; first: phase that lacks more than 1 before the first call;
    amplitude_base, amplitude_slope: of a call over its control voltage, V and V/V; v_dd: supply, V.
    """

    base: float
    slope: float
    dead: float
    first: float
    amplitude_base: float
    amplitude_slope: float
    v_dd: float


@compiled()
def crossing(rate: float, bend: float, missing: float) -> float:
    """Return the least t >= 0 at which `rate t + bend t^2 / 2` reaches `missing`, inf where it never does."""
    under = rate * rate + 2.0 * bend * missing
    if under < 0.0:
        return np.inf
    below = rate + math.sqrt(under)
    time: float = 2.0 * missing / below if below > 0.0 else np.inf
    return time


@compiled()
def vocalization_line(m: Vocalization, y: F64, start: float, stop: float, first: float, last: float) -> float:
    """Advance y along a straight line of the proximity voltage; return the time of a call (s), inf for none.

    y: phase, and when it is free to grow (s), overwritten; start, stop: of the line, s; first, last: its
    voltages, V. Where there is a call, the next interval has begun.
    """
    slope = (last - first) / (stop - start)
    begin = max(start, y[1])
    if begin >= stop:
        return np.inf
    rate = m.base + m.slope * (first + slope * (begin - start))
    bend = m.slope * slope
    wait = crossing(rate, bend, 1.0 - y[0])
    if begin + wait <= stop:
        y[0], y[1] = 0.0, begin + wait + m.dead
        call: float = begin + wait
        return call
    span = stop - begin
    y[0] += rate * span + 0.5 * bend * span * span
    return np.inf


@compiled()
def vocalization_run(m: Vocalization, y: F64, time: F64, value: F64, start: float, until: float) -> float:
    """Advance y along a polyline of the proximity voltage; return the time of the first call (s), or inf.

    time (s), value (V): vertices of the polyline, which is held beyond its ends; start, until: s; y: as in
    `vocalization_line`.
    """
    now = start
    k = 0
    while now < until:
        while k < time.size and time[k] <= now:
            k += 1
        stop = min(until, time[k]) if k < time.size else until
        call = vocalization_line(m, y, now, stop, _value(time, value, k, now), _value(time, value, k, stop))
        if call < np.inf:
            return call
        now = stop
    return np.inf


@compiled()
def _value(time: F64, value: F64, k: int, t: float) -> float:
    if k == 0:
        return float(value[0])
    if k == time.size:
        return float(value[k - 1])
    return float(value[k - 1] + (value[k] - value[k - 1]) * (t - time[k - 1]) / (time[k] - time[k - 1]))


@compiled()
def amplitude_at(m: Vocalization, control: float) -> float:
    """Return the amplitude of a call, V, at a control voltage (V)."""
    return min(max(m.amplitude_base + m.amplitude_slope * control, 0.0), m.v_dd)
