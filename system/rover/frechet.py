"""Discrete Frechet distance of two polylines: the shortest leash that lets two walkers hop along them.

    d = min over couplings of max over coupled vertices |p_i - q_j|

Both start at their first and end at their last vertex, none goes back. Only vertices count. Computed by
shapely (GEOS, DiscreteFrechetDistance without densification).
Source: Eiter and Mannila, "Computing discrete Frechet distance" (1994), as in Hwu et al. 2018, section III.B.
"""

from __future__ import annotations

import numpy as np
import shapely

from circuits.arrays import F64
from circuits.errors import ParameterError


def discrete_frechet(first: F64, second: F64) -> float:
    """Return the discrete Frechet distance (m) of two polylines, float64[n, 2] and float64[m, 2] in m.

    Raises `ParameterError` unless both have a vertex and all are finite.
    """
    lines = [_line(points, name) for points, name in ((first, "first"), (second, "second"))]
    return float(shapely.frechet_distance(*lines))


def _line(points: F64, name: str) -> shapely.LineString:
    """A line of the points; a lone one is repeated, for a line has two ends, and that moves no distance."""
    if points.ndim != 2 or points.shape[1] != 2 or not len(points):
        raise ParameterError(f"{name}: shape {points.shape}, must be (n, 2) with n at least 1")
    if not np.isfinite(points).all():
        raise ParameterError(f"{name}: a vertex is not finite; leave it out")
    return shapely.LineString(points if len(points) > 1 else np.repeat(points, 2, axis=0))
