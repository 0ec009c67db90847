"""Bisection of many balances of currents at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from circuits.arrays import F64

_HALVINGS = 40  # a supply of 1.8 V to 2 pV


def balance(excess: Callable[[F64], F64], low: F64, high: F64) -> F64:
    """Return where `excess`, which rises, is zero between two bounds, V, in their shape."""
    low, high = (x.copy() for x in np.broadcast_arrays(low, high))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        above = excess(middle) > 0.0
        high, low = np.where(above, middle, high), np.where(above, low, middle)
    return np.asarray(0.5 * (low + high))
