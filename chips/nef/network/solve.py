"""Least squares with sums in a fixed order, so that decoders are the same to the bit on any computer.

A library's matrix product sums in an order that depends on its number of threads, and a network with memory
makes another run of a last digit. Here every sum of products has the same order, whatever the processor: in
the lanes of a vector (`circuits.vectors`) each by itself, then the lanes, then what is left over. `A'A` goes
by tiles of columns, `L L' = A` (Cholesky) by tiles of rows, so that a tile's sums share what is loaded. Rates
that were counted for a second are whole numbers, whose sums are exact in any order: of many of them those are
the library's.
"""

from __future__ import annotations

import math

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.vectors import vector
from circuits.vectors.vector import WIDTH, Lanes, rows

_TILE, _PAIR = 4, 2  # columns of a tile of `A'A` each way
_NEAR = 96_000  # numbers that stay near the processor, columns of which meet all tiles in turn; ours
_EXACT = 2.0**53  # up to which all whole numbers are float64
_LARGE = 5e8  # products of a matrix for which a library's threads are woken; ours
_FEW = 4  # products that are left over and still go side by side

_compiled = compiled(fastmath={"contract"})


def gram(rates: F64) -> F64:
    """Return `A'A` of rates, float64[m, n]."""
    m, n = rates.shape
    most = max(float(rates.max(initial=0.0)), -float(rates.min(initial=0.0)))
    if m * n * n > _LARGE and m * most * most < _EXACT and _whole(np.ascontiguousarray(rates).reshape(-1)):
        return np.asarray(rates.T @ rates)
    whole = m // WIDTH
    tiled = -(-n // _TILE) * _TILE
    columns = rows(tiled * whole)
    columns.reshape(tiled, whole * WIDTH)[:n] = rates[: whole * WIDTH].T
    left = np.zeros((tiled, m - whole * WIDTH))
    left[:n] = rates[whole * WIDTH :].T
    found = np.zeros((tiled, tiled))
    near = max(_NEAR // max(m, 1) // _PAIR, 1) * _PAIR
    _gram(columns, whole, left, near, found, rows(_TILE * _PAIR))
    return found[:n, :n]


def moment(rates: F64, values: F64) -> F64:
    """Return `A'F` of rates, float64[m, n], and values, float64[m, k]."""
    found = np.zeros((rates.shape[1], values.shape[1]))
    _moment(np.ascontiguousarray(rates), np.ascontiguousarray(values), found)
    return found


def missed(rates: F64, decoders: F64, values: F64) -> F64:
    """Return the root mean square of what decoders miss of values, float64[m, k], at rates, float64[m, n]."""
    found = np.zeros(values.shape[1])
    a, d, f = (np.ascontiguousarray(x, dtype=np.float64) for x in (rates, decoders.T, values))
    _missed(a, d, f, found)
    return np.asarray(np.sqrt(found / len(values)))


def factor(matrix: F64) -> F64:
    """Return the lower triangle L of `L L' = A`, where A is symmetric and positive definite."""
    n = len(matrix)
    width = -(-n // WIDTH) * WIDTH
    lanes = rows(n * (width // WIDTH))
    found = lanes.reshape(n, width)
    found[:, :n] = matrix
    _cholesky(lanes, found, rows(_TILE))
    return found


def solve(lower: F64, right: F64) -> F64:
    """Return X of `A X = B`; lower: `factor` of A."""
    found = np.array(right.T, dtype=np.float64, order="C")
    for row in found:
        _substitute(lower, row)
    return np.ascontiguousarray(found.T)


@compiled()
def _whole(values: F64) -> bool:
    """Whether all values are whole numbers."""
    parts = 0
    for k in range(values.size):
        parts += values[k] != np.floor(values[k])
    return parts == 0


@_compiled
def _summed(lanes: F64, row: int) -> float:
    """The sum of a vector's lanes."""
    t0 = lanes[row, 0] + lanes[row, 4] + lanes[row, 8] + lanes[row, 12]
    t1 = lanes[row, 1] + lanes[row, 5] + lanes[row, 9] + lanes[row, 13]
    t2 = lanes[row, 2] + lanes[row, 6] + lanes[row, 10] + lanes[row, 14]
    t3 = lanes[row, 3] + lanes[row, 7] + lanes[row, 11] + lanes[row, 15]
    return float((t0 + t2) + (t1 + t3))


@_compiled
def _and_left(total: float, a: F64, b: F64, begin: int, end: int) -> float:
    """A sum and the products that are left over."""
    k = begin
    if end - k >= _FEW:
        t0, t1, t2, t3 = total, 0.0, 0.0, 0.0
        while k + _FEW <= end:
            t0 += a[k] * b[k]
            t1 += a[k + 1] * b[k + 1]
            t2 += a[k + 2] * b[k + 2]
            t3 += a[k + 3] * b[k + 3]
            k += _FEW
        total = (t0 + t2) + (t1 + t3)
    while k < end:
        total += a[k] * b[k]
        k += 1
    return total


@_compiled
def _gram(columns: F64, whole: int, left: F64, near: int, out: F64, room: F64) -> None:
    """Of columns whose whole vectors are in the rows of `columns`, and what is left over of each.

    near: columns that meet all tiles in turn, a multiple of `_PAIR`; room: vectors for a tile's sums.
    """
    n, more = left.shape
    for near_by in range(0, n, near):
        for i in range(near_by - near_by % _TILE, n, _TILE):
            for j in range(near_by, min(near_by + near, i + _TILE), _PAIR):
                _tile(columns, whole, i, j, room)
                for r in range(_TILE):
                    for c in range(_PAIR):
                        total = _and_left(_summed(room, r * _PAIR + c), left[i + r], left[j + c], 0, more)
                        out[i + r, j + c] = total
                        out[j + c, i + r] = total


@_compiled
def _tile(columns: F64, whole: int, i: int, j: int, room: F64) -> None:
    """Sums of products of `_TILE` columns from i on and `_PAIR` from j on, lane by lane."""
    a, b = i * whole, j * whole
    none: Lanes = vector.every(0.0)
    t00, t01, t10, t11, t20, t21, t30, t31 = none, none, none, none, none, none, none, none
    for k in range(whole):
        b0, b1 = vector.load(columns, b + k), vector.load(columns, b + whole + k)
        x = vector.load(columns, a + k)
        t00, t01 = t00 + x * b0, t01 + x * b1
        x = vector.load(columns, a + whole + k)
        t10, t11 = t10 + x * b0, t11 + x * b1
        x = vector.load(columns, a + 2 * whole + k)
        t20, t21 = t20 + x * b0, t21 + x * b1
        x = vector.load(columns, a + 3 * whole + k)
        t30, t31 = t30 + x * b0, t31 + x * b1
    vector.store(room, 0, t00)
    vector.store(room, 1, t01)
    vector.store(room, 2, t10)
    vector.store(room, 3, t11)
    vector.store(room, 4, t20)
    vector.store(room, 5, t21)
    vector.store(room, 6, t30)
    vector.store(room, 7, t31)


@compiled()
def _moment(rates: F64, values: F64, out: F64) -> None:
    m, n = rates.shape
    for k in range(m):
        for i in range(n):
            for j in range(values.shape[1]):
                out[i, j] += rates[k, i] * values[k, j]


@compiled()
def _missed(rates: F64, decoders: F64, values: F64, out: F64) -> None:
    for k in range(rates.shape[0]):
        for j in range(out.size):
            off = _along(rates[k], decoders[j], rates.shape[1]) - values[k, j]
            out[j] += off * off


@_compiled
def _dot(lanes: F64, a: F64, i: int, j: int, count: int, room: F64) -> float:
    """Of the first numbers of two rows of `a`, whose vectors are in the rows of `lanes`."""
    each, whole = a.shape[1] // WIDTH, count // WIDTH
    total: Lanes = vector.every(0.0)
    for k in range(whole):
        total = total + vector.load(lanes, i * each + k) * vector.load(lanes, j * each + k)
    vector.store(room, 0, total)
    return _and_left(_summed(room, 0), a[i], a[j], whole * WIDTH, count)


@_compiled
def _four(lanes: F64, each: int, i: int, j: int, whole: int, room: F64) -> None:
    """Sums of products of four rows from i on, and one of number j, lane by lane."""
    a, b = i * each, j * each
    t0: Lanes = vector.every(0.0)
    t1, t2, t3 = t0, t0, t0
    for k in range(whole):
        y = vector.load(lanes, b + k)
        t0 = t0 + vector.load(lanes, a + k) * y
        t1 = t1 + vector.load(lanes, a + each + k) * y
        t2 = t2 + vector.load(lanes, a + 2 * each + k) * y
        t3 = t3 + vector.load(lanes, a + 3 * each + k) * y
    vector.store(room, 0, t0)
    vector.store(room, 1, t1)
    vector.store(room, 2, t2)
    vector.store(room, 3, t3)


@compiled()
def _cholesky(lanes: F64, a: F64, room: F64) -> None:
    """Lower factor in the lower triangle; lanes: the same numbers as vectors."""
    n, each = a.shape[0], a.shape[1] // WIDTH
    for i in range(0, n, _TILE):
        if i + _TILE <= n:
            for j in range(i):
                whole = j // WIDTH
                _four(lanes, each, i, j, whole, room)
                for r in range(_TILE):
                    total = _and_left(_summed(room, r), a[i + r], a[j], whole * WIDTH, j)
                    a[i + r, j] = (a[i + r, j] - total) / a[j, j]
        for r in range(i, min(i + _TILE, n)):
            for j in range(i if i + _TILE <= n else 0, r):
                a[r, j] = (a[r, j] - _dot(lanes, a, r, j, j, room)) / a[j, j]
            a[r, r] = math.sqrt(a[r, r] - _dot(lanes, a, r, r, r, room))


@compiled()
def _substitute(a: F64, x: F64) -> None:
    """Solve with the lower factor and its transpose, in place."""
    n = x.size
    for i in range(n):
        x[i] = (x[i] - _along(a[i], x, i)) / a[i, i]
    for i in range(n - 1, -1, -1):
        x[i] /= a[i, i]
        for j in range(i):
            x[j] -= a[i, j] * x[i]


@compiled(fastmath={"contract", "reassoc"})
def _along(a: F64, b: F64, count: int) -> float:
    total = 0.0
    for k in range(count):
        total += a[k] * b[k]
    return total
