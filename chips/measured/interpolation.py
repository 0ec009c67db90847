"""Interpolation between the points of a record's tables."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled


@lru_cache(maxsize=1024)
def lagrange_weights(nodes: tuple[float, ...], x: float) -> F64:
    """Return the weights at x of values at `nodes`, of the polynomial through all of them, float64[nodes].

    The array must not be written to.
    """
    at = np.array(nodes)
    others = [np.delete(at, i) for i in range(at.size)]
    weights = np.array([np.prod((x - o) / (a - o)) for a, o in zip(at, others, strict=True)])
    weights.setflags(write=False)
    return weights


@compiled()
def table_at(knots: F64, table: F64, x: float) -> float:
    """Return the value at x of straight lines through a table, held beyond its ends; knots rise."""
    n = knots.size
    if x <= knots[0]:
        return float(table[0])
    for k in range(1, n):
        if x < knots[k]:
            share = (x - knots[k - 1]) / (knots[k] - knots[k - 1])
            return float(table[k - 1] + share * (table[k] - table[k - 1]))
    return float(table[n - 1])


@compiled()
def monotone_cubic(knots: F64, table: F64, x: float, out: F64) -> None:
    """Fill `out`, float64[columns], with monotone cubics at x through the columns of a table.

    They go on beyond its ends; their slopes are those of Fritsch and Butland (1984). knots: float64[points],
    rising, at least three; table: float64[points, columns].
    """
    last = knots.size - 1
    k = 0
    while k < last - 1 and x >= knots[k + 1]:
        k += 1
    h = knots[k + 1] - knots[k]
    z = (x - knots[k]) / h
    w = 1.0 - z
    for j in range(out.size):
        a, b = table[k, j], table[k + 1, j]
        slopes = h * (w * _slope(knots, table, k, j) - z * _slope(knots, table, k + 1, j))
        out[j] = a * w * w * (1.0 + 2.0 * z) + b * z * z * (3.0 - 2.0 * z) + z * w * slopes


@compiled()
def _slope(knots: F64, table: F64, k: int, j: int) -> float:
    """Slope at knot k: weighted harmonic mean of both neighbours', 0 at an extremum."""
    last = knots.size - 1
    if k == 0:
        return _end_slope(knots, table, 0, 1, 2, j)
    if k == last:
        return _end_slope(knots, table, last, last - 1, last - 2, j)
    before, after = knots[k] - knots[k - 1], knots[k + 1] - knots[k]
    left, right = (table[k, j] - table[k - 1, j]) / before, (table[k + 1, j] - table[k, j]) / after
    if left * right <= 0.0:
        return 0.0
    one, other = 2.0 * after + before, after + 2.0 * before
    return float((one + other) / (one / left + other / right))


@compiled()
def _end_slope(knots: F64, table: F64, end: int, next_: int, third: int, j: int) -> float:
    """One-sided slope of the parabola through the last three points, kept from overshooting."""
    near, far = knots[next_] - knots[end], knots[third] - knots[next_]
    first, second = (table[next_, j] - table[end, j]) / near, (table[third, j] - table[next_, j]) / far
    slope = ((2.0 * near + far) * first - near * second) / (near + far)
    if slope * first <= 0.0:
        return 0.0
    if first * second <= 0.0 and abs(slope) > 3.0 * abs(first):
        return float(3.0 * first)
    return float(slope)
