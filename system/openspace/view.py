"""The geometry of Curved Openspace: what of a scene a bat can see, and which arcs an obstacle blocks.

An obstacle blocks an arc where it comes nearer to it than R_C. In the bat's frame, x ahead and y to the left,
the full circle of curvature k passes (x, y) at a distance below R_C where

    (y - R_C) / h < k < (y + R_C) / h,    h = (x^2 + y^2 - R_C^2) / 2,

so the arcs that need a closer look are a range of numbers. Of these the obstacle blocks the ones whose
nearest point lies on the arc, or whose end is nearer than R_C.
"""

from __future__ import annotations

import math

from circuits.arrays import F64
from circuits.compiled import compiled
from system.openspace.law import ARCS, MIDDLE, Arcs

# their numbers are compiled in
_compiled = compiled()
_inlined = compiled(forceinline=True)


@_inlined
def in_view(a: Arcs, x: float, y: float) -> bool:
    """Whether a place (m, x along the ping, y to its left) is within the Gaussian field of view."""
    squared = x * x + y * y
    if squared > a.max_range * a.max_range or abs(y) > a.view_half_width:
        return False
    bearing = math.atan2(y, x) / a.view_sigma
    return squared <= a.max_range * a.max_range * math.exp(-bearing * bearing)


@_compiled
def add_immediacies(a: Arcs, x: float, y: float, risk: F64) -> None:
    """Add an obstacle's immediacy, equations (3) and (11), to the risk of each arc that it blocks.

    x, y: its place in the body's frame, m. The immediacy is cut off at 0.
    """
    h = 0.5 * (x * x + y * y - a.zone * a.zone)
    if h <= 0.0:
        first, last = 0, ARCS - 1
    else:
        scale = 1.0 / (h * a.curvature_step)
        first = max(MIDDLE - math.floor(min((y + a.zone) * scale, MIDDLE + 1.0)), 0)
        last = min(MIDDLE - math.ceil(max((y - a.zone) * scale, -MIDDLE - 1.0)), ARCS - 1)
    for p in range(first, last + 1):
        s = blocked_at(a.curvature[p], a.length[p], a.end[p, 0], a.end[p, 1], x, y, a.zone)
        if s < 0.0:
            continue
        share = 1.0 - (s - a.zone) * a.max_range / (a.immediacy_range * a.length[p])
        if share > 0.0:
            risk[p] += a.max_risk * share**a.power if a.power > 1 else a.max_risk * share


@_inlined
def blocked_at(k: float, length: float, end_x: float, end_y: float, x: float, y: float, zone: float) -> float:
    """Way (m) along an arc of curvature k to its spot nearest to (x, y); -1 where none is nearer than zone.

    end_x, end_y: the last point of the arc. All in m and 1/m, in the frame of its beginning.
    """
    if k == 0.0:
        s, off = x, abs(y)
    else:
        across, along = 1.0 - k * y, abs(k) * x
        s = math.atan2(along, across) / abs(k)
        off = abs(math.sqrt(along * along + across * across) - 1.0) / abs(k)
    if 0.0 <= s <= length:
        return s if off < zone else -1.0
    to_end = (x - end_x) ** 2 + (y - end_y) ** 2
    to_start = x * x + y * y
    if min(to_end, to_start) >= zone * zone:
        return -1.0
    return length if to_end < to_start else 0.0
