"""The interpolation of the EKV law, `F(u) = ln^2(1 + e^(u/2))`: for arrays, and for compiled kernels.

A transistor carries `I_S [F((v_p - v_s) / U_T) - F((v_p - v_d) / U_T)]` (`circuits.devices.transistor`), so
that in saturation, with its source at the bulk, it carries `I_S F(v_p / U_T)`: `e^u` in weak inversion,
`u^2 / 4` in strong inversion. What models need of it is here, and nowhere else:

| of arrays | in kernels | what |
|---|---|---|
| `interpolation(u)` | `law(u)`, with its derivative; `root(u)` | F, a current over the specific current |
| `argument(f)` | `argument_of_root(sqrt(f))` | u at which F is f, the inverse |
| `of_weak(e^u)` | | F by what weak inversion alone would have |
| `weak_over(f)` | | what weak inversion alone would have, over F, where F is f |
| `steepness(f)` | `steepness_of_root(sqrt(f))` | `d ln F / du = (1 - e^-L) / L`, `L = sqrt(f)` |

The solver's law computes the same with packed logarithms (`circuits.devices.softplus`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from circuits.arrays import F64
from circuits.compiled import compiled


def interpolation(u: ArrayLike) -> F64:
    """F(u) in the shape of u, where u is the pinch-off voltage less the source's voltage, over U_T."""
    return np.asarray(np.logaddexp(0.0, 0.5 * np.asarray(u, dtype=np.float64)) ** 2)


def argument(f: ArrayLike) -> F64:
    """The u at which F(u) is f, for f above zero, in the shape of f; the inverse of `interpolation`."""
    return np.asarray(2.0 * np.log(np.expm1(np.sqrt(np.asarray(f, dtype=np.float64)))))


def of_weak(weak: ArrayLike) -> F64:
    """F(u) in the shape of `weak`, which is e^u: what weak inversion alone would make of F."""
    return np.asarray(np.log1p(np.sqrt(np.asarray(weak, dtype=np.float64))) ** 2)


def weak_over(f: ArrayLike) -> F64:
    """`e^u / F(u)` where F(u) is f >= 0, in the shape of f: 1 in weak inversion, and larger above it."""
    root = np.sqrt(np.asarray(f, dtype=np.float64))
    some = np.where(root > 0.0, root, 1.0)
    return np.where(root > 0.0, np.expm1(some) / some, 1.0) ** 2


def steepness(f: ArrayLike) -> F64:
    """`d ln F / du` where F(u) is f >= 0, in the shape of f: 1 in weak inversion, `1 / sqrt(f)` in strong."""
    root = np.sqrt(np.asarray(f, dtype=np.float64))
    some = np.where(root > 0.0, root, 1.0)
    return np.where(root > 0.0, -np.expm1(-some) / some, 1.0)


@compiled(forceinline=True)
def law(u: float) -> tuple[float, float]:
    """F(u) and its derivative, for use in compiled kernels."""
    x = 0.5 * u
    e = math.exp(-abs(x))
    q = max(x, 0.0) + math.log1p(e)
    s = 1.0 / (1.0 + e)
    return q * q, q * (s if x >= 0.0 else e * s)


@compiled(forceinline=True)
def root(u: float) -> float:
    """`sqrt(F(u)) = ln(1 + e^(u/2))`, for use in compiled kernels."""
    x = 0.5 * u
    return max(x, 0.0) + math.log1p(math.exp(-abs(x)))


@compiled(forceinline=True)
def argument_of_root(root: float) -> float:
    """The u at which `ln(1 + e^(u/2))` is `root`, which is above zero; for use in compiled kernels."""
    return 2.0 * (root + math.log(-math.expm1(-root)))


@compiled(forceinline=True)
def steepness_of_root(root: float) -> float:
    """`d ln F / du` where `ln(1 + e^(u/2))` is `root` >= 0; for use in compiled kernels."""
    return -math.expm1(-root) / root if root > 0.0 else 1.0
