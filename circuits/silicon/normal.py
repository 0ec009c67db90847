"""Standard normals of counters: Philox4x32-10, 53 bits of it, and the inverse of the normal's integral.

All is computed in vectors. Numbers in the middle of the distribution, three of four, need a ratio of two
polynomials alone; those of the tails are put together before they are gone on with. Bits are those of
`scipy.special.ndtri` (tested), whose coefficients these are (Cephes, `ndtri.c`).

Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3" (2011), Philox4x32-10.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from circuits.arrays import F64, I64, U32, U64
from circuits.compiled import compiled

_MASK, _WORD = np.uint64(0xFFFFFFFF), np.uint64(32)
_FACTORS = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_KEYS = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)
_HIGH, _LOW = np.uint64(21), np.uint64(11)  # bits of the first word's place, and that the second one loses
CELL = 2.0**-53
TAIL = 0.13533528323661269189  # e^-2: below, and above 1 less it, are the tails
ROOT = 2.50662827463100050242  # sqrt(2 pi)
FAR = 8.0  # sqrt(-2 ln p) from which on a tail has other coefficients
_TOGETHER = 256
P0 = (
    -5.99633501014107895267e1, 9.80010754185999661536e1, -5.66762857469070293439e1, 1.39312609387279679503e1,
    -1.23916583867381258016e0,
)  # fmt: skip
Q0 = (
    1.95448858338141759834e0, 4.67627912898881538453e0, 8.63602421390890590575e1, -2.25462687854119370527e2,
    2.00260212380060660359e2, -8.20372256168333339912e1, 1.59056225126211695515e1, -1.18331621121330003142e0,
)  # fmt: skip
P1 = (
    4.05544892305962419923e0, 3.15251094599893866154e1, 5.71628192246421288162e1, 4.40805073893200834700e1,
    1.46849561928858024014e1, 2.18663306850790267539e0, -1.40256079171354495875e-1,
    -3.50424626827848203418e-2, -8.57456785154685413611e-4,
)  # fmt: skip
Q1 = (
    1.57799883256466749731e1, 4.53907635128879210584e1, 4.13172038254672030440e1, 1.50425385692907503408e1,
    2.50464946208309415979e0, -1.42182922854787788574e-1, -3.80806407691578277194e-2,
    -9.33259480895457427372e-4,
)  # fmt: skip
P2 = (
    3.23774891776946035970e0, 6.91522889068984211695e0, 3.93881025292474443415e0, 1.33303460815807542389e0,
    2.01485389549179081538e-1, 1.23716634817820021358e-2, 3.01581553508235416007e-4,
    2.65806974686737550832e-6, 6.23974539184983293730e-9,
)  # fmt: skip
Q2 = (
    6.02427039364742014255e0, 3.67983563856160859403e0, 1.37702099489081330271e0, 2.16236993594496635890e-1,
    1.34204006088543189037e-2, 3.28014464682127739104e-4, 2.89247864745380683936e-6,
    6.79019408009981274425e-9,
)  # fmt: skip


@compiled(forceinline=True)
def philox_words(c0: Any, c1: Any, c2: Any, c3: Any, k0: Any, k1: Any) -> tuple[Any, Any, Any, Any]:
    """Return the output of Philox4x32-10 for a counter and a key, each of them in an uint64."""
    for _ in range(10):
        p0, p1 = _FACTORS[0] * c0, _FACTORS[1] * c2
        c0, c1, c2, c3 = (p1 >> _WORD) ^ c1 ^ k0, p1 & _MASK, (p0 >> _WORD) ^ c3 ^ k1, p0 & _MASK
        k0, k1 = (k0 + _KEYS[0]) & _MASK, (k1 + _KEYS[1]) & _MASK
    return c0, c1, c2, c3


@compiled(_nrt=True)
def fill_normals(keys: U32, fixed: U32, shapes: I64, out: F64) -> None:
    """Fill `out` with the draws at all places of several paths, one path after the other.

    keys: of each path, uint32[2, paths]. fixed: first words of all counters. shapes: lengths of each path's
    dimensions, whose indices are the words that follow, the last one running fastest, and -1 behind them,
    int64[paths, 4].
    """
    tail, place = np.empty((2, _TOGETHER)), np.empty(_TOGETHER, np.int64)
    begin = 0
    for k in range(shapes.shape[0]):
        dimensions, rows = 0, 1
        while dimensions < shapes.shape[1] and shapes[k, dimensions] >= 0:
            rows *= shapes[k, dimensions]
            dimensions += 1
        length = shapes[k, dimensions - 1] if dimensions else 1
        counter, moves = np.zeros(4, np.uint64), np.zeros(4, np.uint64)
        for i in range(fixed.size):
            counter[i] = fixed[i]
        if dimensions:
            moves[fixed.size + dimensions - 1] = 1
        for row in range(rows // max(length, 1)):
            left = row
            for i in range(dimensions - 2, -1, -1):
                counter[fixed.size + i] = left % shapes[k, i]
                left //= shapes[k, i]
            for first in range(0, length, _TOGETHER):
                count = min(_TOGETHER, length - first)
                if dimensions:
                    counter[fixed.size + dimensions - 1] = first
                drawn = out[begin + first : begin + first + count]
                _middles(keys[0, k], keys[1, k], counter, moves, drawn, tail[0])
                _tails(drawn, tail, place)
            begin += length


@compiled(forceinline=True)
def _eight(x: float, begun: float, c: tuple[float, ...]) -> float:
    """`begun` times x^8 and the eight coefficients that follow, the highest first."""
    y = (((begun * x + c[0]) * x + c[1]) * x + c[2]) * x + c[3]
    return (((y * x + c[4]) * x + c[5]) * x + c[6]) * x + c[7]


@compiled()
def _middles(key: int, other: int, counter: U64, moves: U64, out: F64, left: F64) -> None:
    """Fill `out` with draws as if all were in the middle, and `left` with how far each is from the next end.

    counter: first one; moves: by what the next ones differ.
    """
    k0, k1, c0, c1, c2, c3 = np.uint64(key), np.uint64(other), counter[0], counter[1], counter[2], counter[3]
    for j in range(out.size):
        i = np.uint64(j)
        w0, w1, _, _ = philox_words(
            c0 + i * moves[0], c1 + i * moves[1], c2 + i * moves[2], c3 + i * moves[3], k0, k1
        )
        # 53 bits, centred in their cells so that neither 0 nor 1 occurs
        p = (np.float64(np.int64((w0 << _HIGH) ^ (w1 >> _LOW))) + 0.5) * CELL
        upper = p > 1.0 - TAIL
        p = 1.0 - p if upper else p
        left[j] = -p if upper else p
        y = p - 0.5
        y2 = y * y
        four = (((P0[0] * y2 + P0[1]) * y2 + P0[2]) * y2 + P0[3]) * y2 + P0[4]
        out[j] = (y + y * (y2 * four / _eight(y2, 1.0, Q0))) * ROOT


@compiled()
def _tails(out: F64, tail: F64, place: I64) -> None:
    """Put the draws of the tails in their places; tail: in its first row, what `_middles` says is left."""
    count = 0
    for j in range(out.size):
        place[count] = j
        count += 1 if abs(tail[0, j]) <= TAIL else 0
    for i in range(count):
        x = math.sqrt(-2.0 * math.log(abs(tail[0, place[i]])))
        tail[1, i] = x
        out[place[i]] = x - math.log(x) / x
    for i in range(count):
        x = tail[1, i]
        z = 1.0 / x
        near = z * _eight(z, P1[0], P1[1:]) / _eight(z, 1.0, Q1)
        far = z * _eight(z, P2[0], P2[1:]) / _eight(z, 1.0, Q2)
        tail[1, i] = near if x < FAR else far
    for i in range(count):
        x = out[place[i]] - tail[1, i]
        out[place[i]] = x if tail[0, place[i]] < 0.0 else -x
