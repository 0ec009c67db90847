r"""The pulse by which an event enters a circuit, and the crossing by which one leaves it.

An event is a moment. At a port it is a pulse of the full supply, `WIDTH` long with edges of `EDGE`, that
begins to rise then; a port's event is the moment at which its node rises through half the supply, or through
the port's own threshold. All numbers are ours.

         ______________           v_dd
        /              \         half: HALF_WIDTH
    ___/                \___      0
       EDGE   WIDTH   EDGE        whole: LENGTH
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64
from circuits.devices.source import Constant, Polyline, Pulse, Waveform

WIDTH = 10e-6  # s, at the full supply
EDGE = 0.1e-6  # s, of either edge
HALF_WIDTH = 10.1e-6  # s, between the middles of the edges
LENGTH = WIDTH + 2.0 * EDGE  # s, within which a second event merges into the first


def pulse(times: tuple[float, ...], v_dd: float) -> Waveform:
    """Events at `times` (s) as a source gives them; v_dd: V."""
    return Pulse(0.0, v_dd, times, WIDTH, EDGE, EDGE) if times else Constant(0.0)


def pulse_line(start: float, v_dd: float) -> Polyline:
    """An event at `start` (s) as a polyline; v_dd: V."""
    return start + np.array([0.0, EDGE, HALF_WIDTH, LENGTH]), np.array([0.0, v_dd, v_dd, 0.0])


def rising_crossing(time: F64, v: F64, level: float) -> float | None:
    """First time at which v rises through level by linear interpolation, s; None where it never does."""
    below = np.flatnonzero((v[:-1] < level) & (v[1:] >= level))
    if below.size == 0:
        return None
    k = int(below[0])
    return float(time[k] + (level - v[k]) / (v[k + 1] - v[k]) * (time[k + 1] - time[k]))


def falling_crossing(time: F64, v: F64, level: float) -> float | None:
    """First time at which v falls through level, s; None where it never does."""
    return rising_crossing(time, -v, -level)
