"""Where many balances of currents are, each to the cell that bisection comes to.

An excess that rises is looked for where interpolation through its last values has it, and the cell of a
bisection in which that is has to have its ends on both sides of zero; where it has not, bisection goes on by
itself. So a balance has the bits of a bisection, of a third of its evaluations.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled

_HALVINGS = 40  # a supply of 1.8 V to 2 pV
_COARSE, _ROUNDS = 5, 20  # evaluations half-way before any is interpolated, and most in all; ours
_SETTLED = 1e-9  # V, a step of the interpolation after which it is nearer than a cell; ours
_NEIGHBOURS = 3  # cells that are looked at beside; ours

_compiled = compiled()


def balance(excess: Callable[[F64], F64], low: F64, high: F64) -> F64:
    """Return where `excess`, which rises, is zero between two bounds, V, in their shape."""
    low, high = (np.array(x, order="C", dtype=np.float64) for x in np.broadcast_arrays(low, high))
    zero, below, above = _interpolated(excess, low, high), np.empty_like(low), np.empty_like(low)
    a, b, x, y, z = (each.reshape(-1) for each in (low, high, zero, below, above))
    for _ in range(_NEIGHBOURS):
        _cells(a, b, x, y, z)
        if not _beside(a, b, x, y, z, _values(excess, below), _values(excess, above)):
            return np.asarray(0.5 * (below + above))
    return _bisected(excess, low, high)


def _bisected(excess: Callable[[F64], F64], low: F64, high: F64) -> F64:
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        above = excess(middle) > 0.0
        high, low = np.where(above, middle, high), np.where(above, low, middle)
    return np.asarray(0.5 * (low + high))


def _interpolated(excess: Callable[[F64], F64], low: F64, high: F64) -> F64:
    """About where an excess is zero, V."""
    x = 0.5 * (low + high)
    flat = x.reshape(-1)
    ends = np.stack([low.reshape(-1), high.reshape(-1)])
    room = np.full((4, flat.size), np.nan)
    for k in range(_ROUNDS):
        if not _closer(flat, _values(excess, x), ends, room, k < _COARSE):
            break
    return x


def _values(excess: Callable[[F64], F64], x: F64) -> F64:
    """An excess at x, in one row."""
    return np.ascontiguousarray(np.broadcast_to(excess(x), x.shape), dtype=np.float64).reshape(-1)


@_compiled
def _closer(x: F64, value: F64, ends: F64, room: F64, half_way: bool) -> int:  # noqa: FBT001 - of a kernel
    """Move x to where interpolation has the zero; return of how many it still moves.

    ends: between which it is, V, float64[2, n]; room: the excess there, and a third place and its excess,
    float64[4, n], NaN where none was evaluated.
    """
    moving = 0
    for i in range(x.size):
        side = 1 if value[i] > 0.0 else 0
        room[2, i], room[3, i] = ends[side, i], room[side, i]
        ends[side, i], room[side, i] = x[i], value[i]
        a, b, c = ends[0, i], ends[1, i], room[2, i]
        f, g, h = room[0, i], room[1, i], room[3, i]
        near = 0.5 * (a + b)
        if not half_way:
            through = a * g / ((f - g) * (f - h)) * h + b * f / ((g - f) * (g - h)) * h
            through += c * f / ((h - f) * (h - g)) * g
            straight = a - f * (b - a) / (g - f)
            if a <= through <= b:
                near = through
            elif a <= straight <= b:
                near = straight
            elif math.isnan(f):  # all are above zero so far: it may be at the bound
                near = a
            elif math.isnan(g):
                near = b
        moving += abs(near - x[i]) > _SETTLED and b - a > _SETTLED
        x[i] = near
    return moving


@_compiled
def _cells(low: F64, high: F64, zero: F64, below: F64, above: F64) -> None:
    """Fill the cells to which a bisection between two bounds comes where an excess is zero."""
    for i in range(zero.size):
        a, b = low[i], high[i]
        for _ in range(_HALVINGS):
            middle = 0.5 * (a + b)
            if middle > zero[i]:
                b = middle
            else:
                a = middle
        below[i], above[i] = a, b


@_compiled
def _beside(
    low: F64, high: F64, zero: F64, below: F64, above: F64, at_below: F64, at_above: F64
) -> int:  # fmt: skip
    """Move zeros that are not in their cells into those beside; return how many."""
    moved = 0
    for i in range(zero.size):
        half = 0.5 * (above[i] - below[i])
        if at_below[i] > 0.0 and below[i] > low[i]:
            zero[i] = below[i] - half
            moved += 1
        elif not at_above[i] > 0.0 and above[i] < high[i]:
            zero[i] = above[i] + half
            moved += 1
    return moved
