"""Thinning of the polylines by which voltages pass from one part of a system to another."""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64, Bools, in_rows
from circuits.compiled import compiled
from circuits.devices.source import Polyline


def thin(time: F64, value: F64, tolerance: float) -> Polyline:
    """Leave out vertices of a polyline while straight lines stay within `tolerance` of all that is left out.

    time: s, float64[T] rising; value: float64[T]; the first and the last vertex are kept. This is
    swinging-door compression: a vertex is kept when the line to the next one would miss one of those passed
    over.
    """
    keep = np.zeros(time.size, dtype=np.bool_)
    _mark(in_rows(time), in_rows(value), tolerance, keep)
    return time[keep], value[keep]


@compiled(_nrt=True)
def _mark(time: F64, value: F64, tolerance: float, keep: Bools) -> None:
    last = time.size - 1
    keep[0] = True
    keep[last] = True
    anchor = 0
    low, high = -np.inf, np.inf
    for k in range(1, last + 1):
        slope = (value[k] - value[anchor]) / (time[k] - time[anchor])
        if slope > high or slope < low:
            anchor = k - 1
            keep[anchor] = True
            low, high = -np.inf, np.inf
        span = time[k] - time[anchor]
        low = max(low, (value[k] - tolerance - value[anchor]) / span)
        high = min(high, (value[k] + tolerance - value[anchor]) / span)
