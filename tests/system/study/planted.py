"""A planted metric of many standard normals whose distribution is known to nine digits.

    y = sum a_i z_i + sum q_i z_i^2,   characteristic function
    prod (1 - 2 i t q_i)^(-1/2) exp(-a_i^2 t^2 / 2 (1 - 2 i t q_i))

inverted by Gil-Pelaez: P(y > x) = 1/2 + 1/pi integral over t > 0 of Im(exp(-i t x) cf(t)) / t.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from circuits.arrays import F64

DIMENSIONS = 68
_STEP = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class Planted:
    """Coefficients float64[68] of the metric: a direction, and squares of both signs."""

    linear: F64
    square: F64

    def value(self, z: F64) -> F64:
        return z @ self.linear + (z * z) @ self.square

    def exceeds(self, x: float) -> float:
        t = _STEP * (np.arange(1_000) + 0.5)  # to 20, where the integrand is below 1e-40
        factor = 1.0 - 2j * np.outer(t, self.square)
        logarithm = (-0.5 * np.log(factor) - 0.5 * np.outer(t**2, self.linear**2) / factor).sum(axis=1)
        return float(0.5 + _STEP / np.pi * (np.exp(logarithm - 1j * t * x).imag / t).sum())

    def limit(self, probability: float) -> float:
        return float(brentq(lambda x: self.exceeds(x) - probability, 0.0, 20.0, xtol=1e-9))


def planted() -> Planted:
    """A direction that is mostly in a few of 68 normals, of norm 1, with squares of up to 3 % of it."""
    rng = np.random.default_rng(68)
    linear = rng.standard_normal(DIMENSIONS) * np.exp(-0.05 * np.arange(DIMENSIONS))
    return Planted(linear / np.linalg.norm(linear), rng.uniform(-0.03, 0.03, DIMENSIONS))
