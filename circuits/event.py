r"""The pulse that carries an event into a circuit, and the crossing that marks one coming out of it.

An event is a moment in time. At an input it is a pulse of the full supply that begins to rise at that moment;
its top lasts `WIDTH` and each edge lasts `EDGE`. At an output it is the moment at which the node rises
through half the supply, or through the port's own threshold. All numbers are ours.

         ______________           v_dd
        /              \         half: HALF_WIDTH
    ___/                \___      0
       EDGE   WIDTH   EDGE        whole: LENGTH
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled
from circuits.devices.source import Constant, Polyline, Pulse, Waveform

WIDTH = 10e-6  # s, at the full supply
EDGE = 0.1e-6  # s, of either edge
HALF_WIDTH = 10.1e-6  # s, between the middles of the edges
LENGTH = WIDTH + 2.0 * EDGE  # s, within which a second event merges into the first


def pulse(times: tuple[float, ...], v_dd: float) -> Waveform:
    """Waveform with one event at each of `times` (s), of `v_dd` volt; a constant 0 V without any."""
    return Pulse(0.0, v_dd, times, WIDTH, EDGE, EDGE) if times else Constant(0.0)


def pulse_line(start: float, v_dd: float) -> Polyline:
    """One event at `start` (s) as the times (s) and voltages (V) of a polyline; v_dd: the supply, V."""
    return start + np.array([0.0, EDGE, HALF_WIDTH, LENGTH]), np.array([0.0, v_dd, v_dd, 0.0])


def rising_crossing(time: F64, v: F64, level: float) -> float | None:
    """First time (s) at which a waveform rises through a level, or None where it never does.

    Parameters
    ----------
    time
        Times, float64[T], s.
    v
        Waveform at these times, float64[T], in the unit of `level`; between them it is a straight line.
    level
        The level, in the unit of the waveform.
    """
    below = np.flatnonzero((v[:-1] < level) & (v[1:] >= level))
    if below.size == 0:
        return None
    k = int(below[0])
    return float(time[k] + (level - v[k]) / (v[k + 1] - v[k]) * (time[k + 1] - time[k]))


def falling_crossing(time: F64, v: F64, level: float) -> float | None:
    """First time (s) at which a waveform falls through a level, or None where it never does.

    `time` (s) and `v`, float64[T], and `level`, in the unit of `v`, are those of `rising_crossing`.
    """
    return rising_crossing(time, -v, -level)


@compiled(forceinline=True)
def sort_events(time: F64, value: F64 | I64, count: int) -> None:
    """Sort the first `count` events and what each of them is in place, by time; those of one time stay as is.

    It is for few events, or for many that are nearly in order; for use in compiled kernels too.
    """
    for i in range(1, count):
        at, what, k = time[i], value[i], i
        while k > 0 and time[k - 1] > at:
            time[k], value[k] = time[k - 1], value[k - 1]
            k -= 1
        time[k], value[k] = at, what
