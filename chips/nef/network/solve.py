"""Least squares with sums in a fixed order, so that decoders are the same to the bit on any computer.

A library's matrix product sums in an order that depends on its number of threads, and a network with memory
makes another run of a last digit. Here every sum runs in the order of its index: `A'A` by tiles of rows,
`L L' = A` (Cholesky) row by row, and both substitutions.
"""

from __future__ import annotations

import math

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled

_TILE = 4


def gram(rates: F64) -> F64:
    """Return `A'A` of rates, float64[m, n]."""
    columns = np.ascontiguousarray(rates.T)
    found = np.zeros((columns.shape[0], columns.shape[0]))
    _gram(columns, found)
    return found


def moment(rates: F64, values: F64) -> F64:
    """Return `A'F` of rates, float64[m, n], and values, float64[m, k]."""
    found = np.zeros((rates.shape[1], values.shape[1]))
    _moment(np.ascontiguousarray(rates), np.ascontiguousarray(values), found)
    return found


def solve(matrix: F64, right: F64) -> F64:
    """Return X of `A X = B`, where A is symmetric and positive definite; A is overwritten."""
    found = np.ascontiguousarray(right.T, dtype=np.float64)
    _cholesky(matrix)
    for row in found:
        _substitute(matrix, row)
    return np.ascontiguousarray(found.T)


@compiled(fastmath={"contract", "reassoc"})
def _dot(a: F64, b: F64, count: int) -> float:
    total = 0.0
    for k in range(count):
        total += a[k] * b[k]
    return total


@compiled(fastmath={"contract", "reassoc"})
def _gram(columns: F64, out: F64) -> None:
    n, m = columns.shape
    tiled = n - n % _TILE
    for i in range(0, tiled, _TILE):
        a0, a1, a2, a3 = columns[i], columns[i + 1], columns[i + 2], columns[i + 3]
        for j in range(i + _TILE):
            b = columns[j]
            t0, t1, t2, t3 = 0.0, 0.0, 0.0, 0.0
            for k in range(m):
                t0 += a0[k] * b[k]
                t1 += a1[k] * b[k]
                t2 += a2[k] * b[k]
                t3 += a3[k] * b[k]
            out[i, j], out[i + 1, j], out[i + 2, j], out[i + 3, j] = t0, t1, t2, t3
    for i in range(tiled, n):
        for j in range(i + 1):
            out[i, j] = _dot(columns[i], columns[j], m)
    for i in range(n):
        for j in range(i):
            out[j, i] = out[i, j]


@compiled()
def _moment(rates: F64, values: F64, out: F64) -> None:
    m, n = rates.shape
    for k in range(m):
        for i in range(n):
            for j in range(values.shape[1]):
                out[i, j] += rates[k, i] * values[k, j]


@compiled()
def _cholesky(a: F64) -> None:
    """Lower factor in the lower triangle."""
    for i in range(a.shape[0]):
        for j in range(i):
            a[i, j] = (a[i, j] - _dot(a[i], a[j], j)) / a[j, j]
        a[i, i] = math.sqrt(a[i, i] - _dot(a[i], a[i], i))


@compiled()
def _substitute(a: F64, x: F64) -> None:
    """Solve with the lower factor and its transpose, in place."""
    n = x.size
    for i in range(n):
        x[i] = (x[i] - _dot(a[i], x, i)) / a[i, i]
    for i in range(n - 1, -1, -1):
        x[i] /= a[i, i]
        for j in range(i):
            x[j] -= a[i, j] * x[i]
