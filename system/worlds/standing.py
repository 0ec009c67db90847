"""The share of its time for which something that moves stands still."""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64

SLOW = 0.1  # of its full speed, below which it stands; ours


def share_standing(path: F64, slow: float, every: int = 1) -> float:
    """Share of the looks, `every` rows apart, between which a path is slower than `slow` m/s; 0 of no looks.

    path: float64[n, 3 or more], time (s) in even steps, place (m).
    """
    chosen = path[::every]
    if len(chosen) < 2:
        return 0.0
    way, time = np.hypot(*np.diff(chosen[:, 1:3], axis=0).T), np.diff(chosen[:, 0])
    return float(np.mean(way < slow * time))


def evenly(time: F64, place: F64, step: float) -> F64:
    """Path in even steps (s), float64[n, 3], of times that are not, float64[k], and places, float64[k, 2]."""
    even = np.arange(float(time[0]), float(time[-1]), step)
    return np.stack([even, *(np.interp(even, time, each) for each in place.T)], axis=1)
