"""The grid of zeta, over which a chip's step knows its neurons, and an integral over points.

Each octave of zeta is divided into `2^OCTAVE_BITS` lines of one length, so that a step reads the number of a
neuron's line from the leading bits of its zeta.
"""

from __future__ import annotations

import numpy as np

from chips.rolls.layout import OCTAVE_BITS
from circuits.arrays import F64
from circuits.compiled import compiled


def edges(lines: int) -> F64:
    """Return where each of so many lines begins, and where the last one ends: zeta, float64[lines + 1]."""
    per, k = 1 << OCTAVE_BITS, np.arange(lines + 1)
    return np.asarray(np.exp2(k // per) * (1.0 + (k % per) / per))


def integral(v: F64, density: F64) -> F64:
    """Return the integral of `density` over v from its first point, float64[n, points].

    Between points the logarithm of the density is a straight line.
    """
    a, b = density[:, :-1], density[:, 1:]
    log = np.log(b / a)
    small = np.abs(log) < 1e-6
    mean = np.where(small, 0.5 * (a + b), (b - a) / np.where(small, 1.0, log))
    return np.concatenate((np.zeros((v.shape[0], 1)), np.cumsum(mean * np.diff(v), axis=1)), axis=1)


@compiled()
def interpolated(x: F64, points: F64, values: F64, out: F64) -> None:
    """Fill `out` with what `numpy.interp` gives at `x`, which rises as `points` do, to the last bit."""
    last, j = points.size - 1, 0
    for i in range(x.size):
        while j < last and points[j + 1] <= x[i]:
            j += 1
        if j == last or x[i] <= points[j]:  # at a point, or outside of all of them
            out[i] = values[j]
        else:
            slope = (values[j + 1] - values[j]) / (points[j + 1] - points[j])
            out[i] = slope * (x[i] - points[j]) + values[j]
