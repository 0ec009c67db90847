"""Flights that shuttle about one place by one emergency after the other, and never leave it.

A memory only grows until a reset: pings to the sides keep what earlier ones left, seen from places that the
bat has passed, and places of the map are 0.2 m and 4 degrees apart, so that an obstacle that is just beside
the path may block it. In a narrow place three or four pings leave no motor choice that spikes before the
emergency neuron; the bat turns round on its circle, is told the same on its way back, and turns round again.
The reset has erased everything, so that the same place gives the same pings: the flight repeats itself.

A flight is caught where the last `WINDOW` of it lies within `REACH` of where it is; both are ours.
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64
from system.openspace.map import SIDE

WINDOW = 60.0  # s; at full speed a way of 120 m
REACH = 2.0  # m


def stays(time: F64, place: F64, window: float = WINDOW, reach: float = REACH) -> bool:
    """Whether all places of the last `window` s lie within `reach` m of the last one, and there are so many.

    time: float64[n], s; place: float64[n, 2], m, of a forest that is endless in both directions.
    """
    if time[-1] - time[0] < window:
        return False
    apart = place[time >= time[-1] - window] - place[-1]
    apart -= SIDE * np.round(apart / SIDE)
    return bool(np.hypot(*apart.T).max() <= reach)
