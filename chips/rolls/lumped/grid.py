"""The grid of zeta, over which a chip's step knows its neurons, and an integral over points.

Each octave of zeta is divided into `2^OCTAVE_BITS` lines of one length, so that a step reads the number of a
neuron's line from the leading bits of its zeta.
"""

from __future__ import annotations

import numpy as np

from chips.rolls.layout import OCTAVE_BITS
from circuits.arrays import F64


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
