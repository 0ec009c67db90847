"""Scaled-sigma sampling: the probability of a rare failure, extrapolated from dies of exaggerated variation.

Failures are counted on dies whose sigmas are s times too large.

Of d standard normals scaled by s a region of failure has the probability

    P(s) = integral over it of (2 pi s^2)^(-d/2) exp(-|z|^2 / 2 s^2)

whose logarithm is led by its largest term (the "soft maximum"), at the failing die of least norm, so that

    ln P(s) = a + b ln s + c / s^2,    P(1) = exp(a + c)

Fitted to the counts by maximum likelihood (binomial, with this logarithm as the link). The interval is the
percentile one of a parametric bootstrap of the counts, for that randomness only: that the model holds down
to s = 1 is assumed. Its price is noise: three coefficients extrapolated from 5,000 samples leave a
probability of 1e-4 uncertain by a factor of about 3 (one standard error) even where the model is exact.
Source: Sun, Li, Liu, Luo, Gu, "Fast statistical analysis of rare circuit failure events via scaled-sigma
sampling for high-dimensional variation space", IEEE TCAD 34, 1096 (2015).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from circuits.arrays import F64, I64
from circuits.errors import ParameterError, SolverError
from system.study.statistics.interval import LEVEL, Interval
from system.study.statistics.rare import Fails, RareFailure, check_budget

SCALES: Mapping[float, float] = MappingProxyType({1.4: 0.4, 1.8: 0.3, 2.5: 0.2, 4.0: 0.1})
FEWEST_FAILURES = 5  # at a scale, for it to count as one of the three that the model needs
_RESAMPLES = 999
_COEFFICIENTS = 3  # of the model
_NEVER = -1e3  # of ln P: exp of it is 0
_STEPS = 50
_SETTLED = 1e-9  # of ln P
_LARGEST = 1.0 - 1e-9  # of a fitted probability, whose logarithm knows no such bound


def scaled_sigma(
    fails: Fails,
    dimensions: int,
    samples: int,
    rng: np.random.Generator,
    scales: Mapping[float, float] = SCALES,
    level: float = LEVEL,
) -> RareFailure:
    """Estimate the probability of a rare failure from dies whose sigmas are scaled up.

    Parameters
    ----------
    fails : tells which rows of float64[n, dimensions] standard normals fail, bool[n].
    dimensions : number of standard normals behind a die.
    samples : number of dies in all.
    rng : generator of the standard normals and of the bootstrap.
    scales : share of the samples that is measured at each scale s > 1.
    level : confidence level of the interval.

    Raises
    ------
    ParameterError
        There are too few samples, fewer than three scales, or a scale that is not above 1.
    SolverError
        Fewer than three scales have enough failures, or all dies fail.
    """
    check_budget(dimensions, samples, 100 * len(scales))
    s = np.array(sorted(scales))
    if s.size < 3 or s[0] <= 1.0:
        raise ParameterError(f"scales: {s.tolist()}, must be three or more above 1; give 1.4, 1.8, 2.5 and 4")
    tried = np.array([int(samples * scales[each]) for each in s])
    tried[0] += samples - tried.sum()
    failed = np.array(
        [
            np.count_nonzero(fails(each * rng.standard_normal((n, dimensions))))
            for each, n in zip(s, tried, strict=True)
        ]
    )
    return extrapolate(s, tried, failed, rng, level)


def extrapolate(
    scales: F64, tried: I64, failed: I64, rng: np.random.Generator, level: float = LEVEL
) -> RareFailure:
    """Extrapolate the probability of a failure to the scale s = 1.

    Parameters
    ----------
    scales : float64[n], factors on the sigmas of the dies.
    tried : int64[n], number of dies at each scale.
    failed : int64[n], how many of them failed.
    rng : generator of the bootstrap.
    level : confidence level of the interval.

    Raises
    ------
    SolverError
        Fewer than three scales have enough failures, or all dies fail.
    """
    counted = " ".join(f"{k}/{n} at {s:g}" for s, n, k in zip(scales, tried, failed, strict=True))
    if np.count_nonzero(failed >= FEWEST_FAILURES) < 3:
        raise SolverError(
            f"scaled-sigma: failures {counted}, must be >= {FEWEST_FAILURES} at three scales; "
            "take more samples or larger scales"
        )
    if (failed == tried).all():  # resamples of them would all be the same
        raise SolverError(
            f"scaled-sigma: failures {counted}, must not be all dies; sample plainly, which says why"
        )
    ceiling = float((failed / tried).min())  # a failure can only be rarer with smaller sigmas, noise aside
    logarithm = float(_fit(scales, tried, failed[None])[0])
    again = rng.binomial(tried, failed / tried, (_RESAMPLES, len(tried)))
    low, high = np.exp(np.quantile(_fit(scales, tried, again), [0.5 * (1.0 - level), 0.5 * (1.0 + level)]))
    value = min(math.exp(logarithm), 1.0)
    interval = Interval(min(float(low), value), max(min(float(high), 1.0), value))
    note = "" if value <= ceiling else "; above what was counted, so the model does not hold"
    return RareFailure(
        "scaled-sigma", value, interval, int(tried.sum()), math.nan, f"failures {counted}{note}"
    )


def _fit(scales: F64, tried: I64, failed: I64) -> F64:
    """Logarithm of P(1) in the maximum-likelihood model of counts [m, n], float64[m].

    Where failures are left at fewer than three scales it falls without end, and is `_NEVER`.
    """
    known = np.count_nonzero(failed, axis=1) >= _COEFFICIENTS
    found = np.full(len(failed), _NEVER)
    if known.any():
        found[known] = _scored(scales, tried, failed[known])
    return found


def _scored(scales: F64, tried: I64, failed: I64) -> F64:
    """Logarithm of P(1) of counts [m, n] that have one, by Fisher's scoring; float64[m]."""
    columns = np.column_stack([np.ones_like(scales), np.log(scales), scales**-2.0])
    logarithm = np.log((failed + 0.5) / (tried + 1.0))
    value = np.full(len(failed), np.nan)
    for _ in range(_STEPS):
        p = np.minimum(np.exp(logarithm), _LARGEST)
        weight = (tried * p / (1.0 - p))[:, :, None]
        target = (logarithm + (failed / tried - p) / p)[:, :, None]
        right = columns.T @ (weight * target)
        coefficient = np.linalg.solve(columns.T @ (weight * columns), right)[:, :, 0]
        logarithm = np.minimum(coefficient @ columns.T, math.log(_LARGEST))
        before, value = value, coefficient[:, 0] + coefficient[:, 2]
        if np.all(np.abs(value - before) < _SETTLED):
            break
    return value
