"""Regression of a response on standard normals, with the share of the variance that each term has.

The response is a polynomial that is fitted to the samples:

    y = a + sum b_i z_i + sum c_i (z_i^2 - 1) / sqrt(2) + sum d_ij z_i z_j + e,  i < j

For standard normals these terms have variance 1 and no covariance, so that Var y is the sum of b^2, c^2, d^2
and Var e. A fitted coefficient is off by its standard error, so its square is too large by that squared on
average, which is taken off; what is left is scaled to sum to the adjusted R^2 of k terms,
1 - (1 - R^2) (n - 1) / (n - k - 1).

Squares and interactions that enter are chosen from what the fit so far leaves, r: under none of them
`sum_s r_s z_si z_sj / sqrt(sum r^2)` is a standard normal, so those may enter whose size passes Bonferroni's
5 % limit for all p (p + 1) / 2 of them. Those at least half as large as the largest enter and the fit is made
again, until none is left, or two samples a term are used up.
Source: Sudret, "Global sensitivity analysis using polynomial chaos expansions" (2008): basis and variances.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, I64
from circuits.catalogue import later
from circuits.errors import ParameterError

special = later("scipy.special")

SAMPLES_A_TERM = 2
_CHANCE = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Shares of the response's variance that the terms of a fitted polynomial have.

    r2 : adjusted R^2, the sum of all shares.
    linear : float64[p], share of the linear term of each parameter.
    squares : float64[p], share of the square of each parameter, zero where the square did not enter.
    pairs : int64[m, 2], the two parameters of each product that entered.
    interactions : float64[m], share of each of these products.
    """

    r2: float
    linear: F64
    squares: F64
    pairs: I64
    interactions: F64

    def by_parameter(self) -> F64:
        """Give the share of each parameter, float64[p]: its own terms and half of each interaction."""
        share = self.linear + self.squares
        np.add.at(share, self.pairs.ravel(), np.repeat(0.5 * self.interactions, 2))
        return share


def enough(samples: int, parameters: int) -> bool:
    """Tell whether there are two samples for each parameter and two for the mean."""
    return samples >= SAMPLES_A_TERM * (parameters + 1)


def fit_linear(z: F64, y: F64) -> Fit:
    """Fit the response y, float64[n], linearly to the parameters z, float64[n, p], by least squares.

    Raises `ParameterError` for too few samples, and where y and z differ in length.
    """
    return _fit(z, y, np.empty((0, 2), dtype=np.int64))


def fit_quadratic(z: F64, y: F64) -> Fit:
    """Fit the response by least squares with those squares and products that the residual asks for.

    z: float64[n, p], the parameters; y: float64[n], the response. Raises `ParameterError` for too few
    samples, and where y and z differ in length.
    """
    _check(z, y)
    n, p = z.shape
    chosen = np.empty((0, 2), dtype=np.int64)
    room = n // SAMPLES_A_TERM - p - 1
    while len(chosen) < room:
        columns = np.column_stack([np.ones(n), z, _terms(z, chosen)])
        residual = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
        found = _products(z, residual, chosen)[: room - len(chosen)]
        if not len(found):
            break
        chosen = np.vstack([chosen, found])
    return _fit(z, y, chosen)


def _products(z: F64, residual: F64, chosen: I64) -> I64:
    """Pairs (i, j), i <= j, that enter next, the most significant first; int64[m, 2]."""
    p = z.shape[1]
    spread = float(np.sqrt((residual * residual).sum()))
    if spread == 0.0:
        return np.empty((0, 2), dtype=np.int64)
    score = np.abs((z * residual[:, None]).T @ z) / spread
    score[np.diag_indices(p)] /= np.sqrt(2.0)
    score[chosen[:, 0], chosen[:, 1]] = 0.0
    i, j = np.triu_indices(p)
    size = score[i, j]
    limit = max(float(-special.ndtri(0.5 * _CHANCE / len(i))), 0.5 * float(size.max()))
    order = np.argsort(-size, kind="stable")
    entering = order[size[order] > limit]
    return np.column_stack([i[entering], j[entering]])


def _terms(z: F64, products: I64) -> F64:
    """Columns of the products, float64[n, m], of variance 1 for standard normals."""
    square = products[:, 0] == products[:, 1]
    terms = z[:, products[:, 0]] * z[:, products[:, 1]]
    terms[:, square] = (terms[:, square] - 1.0) / np.sqrt(2.0)
    return np.asarray(terms)


def _fit(z: F64, y: F64, products: I64) -> Fit:
    _check(z, y)
    p = z.shape[1]
    square = products[:, 0] == products[:, 1]
    columns = np.column_stack([z, _terms(z, products)])
    r2, share = _shares(columns - columns.mean(axis=0), y - y.mean())
    squares = np.zeros(p)
    squares[products[square, 0]] = share[p:][square]
    return Fit(r2, share[:p], squares, products[~square], share[p:][~square])


def _shares(columns: F64, y: F64) -> tuple[float, F64]:
    """Adjusted R^2, and the unbiased squares of the coefficients scaled to it; both of centred data."""
    n, k = columns.shape
    total = float(y @ y)
    if total == 0.0 or k == 0:
        return 0.0, np.zeros(k)
    inverse = np.linalg.pinv(columns.T @ columns, hermitian=True)
    coefficient = inverse @ (columns.T @ y)
    residual = y - columns @ coefficient
    noise = float(residual @ residual) / (n - k - 1)
    r2 = max(0.0, 1.0 - noise * (n - 1) / total)
    unbiased = np.maximum(coefficient**2 - noise * np.diag(inverse), 0.0)
    whole = float(unbiased.sum())
    return (r2, unbiased * (r2 / whole)) if whole > 0.0 else (0.0, np.zeros(k))


def _check(z: F64, y: F64) -> None:
    n, p = z.shape
    if not enough(n, p) or n != len(y):
        least = SAMPLES_A_TERM * (p + 1)
        raise ParameterError(
            f"regression: {len(y)} samples, must be >= {least} for {p} parameters; take more"
        )
