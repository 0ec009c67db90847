"""Bisection for the value at which what a circuit does changes, as a threshold or a shortest time."""

from __future__ import annotations

import math
from collections.abc import Callable


def narrowed(holds: Callable[[float], bool], low: float, high: float, within: float) -> tuple[float, float]:
    """Return bounds, at most `within` apart, between which something begins to hold.

    holds: of a value, false at `low` and true at `high`.
    """
    while high - low > within:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return low, high


def narrowed_by_share(
    holds: Callable[[float], bool], low: float, high: float, within: float
) -> tuple[float, float]:
    """Return bounds above 0, whose ratio is at most `1 + within`, between which something begins to hold.

    holds: of a value, false at `low` and true at `high`.
    """
    while high > (1.0 + within) * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return low, high
