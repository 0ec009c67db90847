"""Confidence intervals of a proportion, a count, a mean, a quantile, a standard deviation and a skewness.

Proportion: Clopper and Pearson (1934), the exact one, from quantiles of the beta distribution.
Count of Poisson events: Garwood, "Fiducial limits for the Poisson distribution" (1936), the exact one.
Mean, sigma, skew: the bootstrap-t of Efron. Of a statistic `v` with standard error `e` the pivot
`t* = (v* - v) / e*` is resampled, and the interval is `[v - e t_high, v - e t_low]`; sigma on a log scale. On
skewed data at 100 samples it covers better than BCa (lognormal, sigma 0.5, mean: 94.3 against 93.6 %).
Source: Hall, "The Bootstrap and Edgeworth Expansion" (1992), section 3.
Quantile p: between order statistics, for P(X_(k) > q_p) = P(beta(k, n + 1 - k) > p) in any distribution,
at fractional k with linear interpolation: Hutson, "Calculating nonparametric confidence intervals for
quantiles using fractional order statistics" (1999). A bootstrap would only put noise on the same order
statistics, and at the ends it knows few of them.

Measured with 1,000 experiments of 100 and of 200 samples, sigma's 95 % interval covers 92 to 95 %. Skewness
is known poorly from any sample of a long tail: its interval covers 92 % for a normal, but 67 to 80 % for a
lognormal (sigma 0.5) or an exponential. For a lognormal of sigma 1 that of the mean covers 93.6 % at 100.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.errors import ParameterError

stats, optimise, special = later("scipy.stats"), later("scipy.optimize"), later("scipy.special")

Reduction = Callable[..., Any]  # f(array, axis) -> array with one axis less

LEVEL = 0.95
RESAMPLES = 1999  # (RESAMPLES + 1) times half of 5 % is whole: Davison and Hinkley (1997), section 2.4
FEWEST = 10  # samples below which resampling them says nothing
MANY = 5_000  # samples from which on the pivot is normal for all that can be seen
_BATCH = 500_000  # resampled values held at a time
_FAR = 1e6  # pivot of a resample without spread, which ties make


@dataclass(frozen=True, slots=True)
class Interval:
    """Closed interval of numbers.

    Attributes
    ----------
    low : float
        Lower end, minus infinity where the samples set no limit.
    high : float
        Upper end, infinity where the samples set no limit.
    """

    low: float
    high: float

    @property
    def half_width(self) -> float:
        """Half of the interval's length, in the unit of its ends."""
        return 0.5 * (self.high - self.low)

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high


EVERYTHING = Interval(-math.inf, math.inf)


@dataclass(frozen=True, slots=True)
class Estimate:
    """Estimated value with its confidence interval.

    Attributes
    ----------
    value : float
        The estimate, NaN where it is not defined.
    interval : Interval
        Confidence interval of the value, in the same unit.
    """

    value: float
    interval: Interval


def clopper_pearson(passed: int, samples: int, level: float = LEVEL) -> Interval:
    """Give the exact interval of a proportion, which covers every true proportion often enough.

    Parameters
    ----------
    passed
        How many samples pass.
    samples
        How many samples there are.
    level
        Probability with which the interval covers the true proportion, at least.

    Raises
    ------
    ParameterError
        `passed` is not from 0 to `samples`, or the level is not between 0 and 1.
    """
    if not 0 <= passed <= samples:
        raise ParameterError(f"passed: {passed}, must be from 0 to samples {samples}; count again")
    tail, failed = 0.5 * (1.0 - _checked(level)), samples - passed
    low = float(stats.beta.ppf(tail, passed, failed + 1)) if passed else 0.0
    high = float(stats.beta.isf(tail, passed + 1, failed)) if failed else 1.0
    return Interval(low, high)


def poisson_interval(count: int, level: float = LEVEL) -> Interval:
    """Give the exact interval of the expected number of Poisson events of which `count` were seen.

    It covers every true number with at least `level`. Raises `ParameterError` for a count below zero, and for
    a level outside 0 to 1.
    """
    if count < 0:
        raise ParameterError(f"count: {count}, must be >= 0; count again")
    tail = 0.5 * (1.0 - _checked(level))
    low = 0.5 * float(stats.chi2.ppf(tail, 2 * count)) if count else 0.0
    return Interval(low, 0.5 * float(stats.chi2.isf(tail, 2 * count + 2)))


def mean_interval(
    values: F64, rng: np.random.Generator, level: float = LEVEL, resamples: int = RESAMPLES
) -> Interval:
    """Give the interval of the mean of finite values.

    It is Student's interval below 10 values, and unlimited below 2.

    `values`: float64[n], in any unit. `rng` draws the bootstrap, `resamples` a number of times. `level`: the
    probability with which the interval covers the true mean. Raises `ParameterError` for one that is not
    between 0 and 1.
    """
    n, level = len(values), _checked(level)
    if n < 2:
        return EVERYTHING
    if n < FEWEST:
        return _symmetric(float(values.mean()), float(_error_of_mean(values)), n, level)
    return _bootstrap_t(values, _mean, _error_of_mean, rng, level, resamples)


def sigma_interval(
    values: F64, rng: np.random.Generator, level: float = LEVEL, resamples: int = RESAMPLES
) -> Interval:
    """Give the interval of the standard deviation of finite values.

    It is 0 to infinity below 10 values.

    `values`: float64[n], in any unit. `rng` draws the bootstrap, `resamples` a number of times. `level`: the
    probability with which the interval covers the true standard deviation. Raises `ParameterError` for one
    that is not between 0 and 1.
    """
    level = _checked(level)
    if len(values) < FEWEST:
        return Interval(0.0, math.inf)
    if np.ptp(values) == 0.0:
        return Interval(0.0, 0.0)
    found = _bootstrap_t(values, _log_sigma, _error_of_log_sigma, rng, level, resamples)
    return Interval(math.exp(found.low), math.exp(found.high))


def skew_interval(
    values: F64, rng: np.random.Generator, level: float = LEVEL, resamples: int = RESAMPLES
) -> Interval:
    """Give the interval of the skewness of finite values.

    It is unlimited below 10 values, and where all values are equal. For data with long tails it is only
    indicative, as the module's text says.

    `values`: float64[n], in any unit. `rng` draws the bootstrap, `resamples` a number of times. `level`: the
    probability with which the interval covers the true skewness. Raises `ParameterError` for one that is not
    between 0 and 1.
    """
    level = _checked(level)
    if len(values) < FEWEST or np.ptp(values) == 0.0:
        return EVERYTHING
    return _bootstrap_t(values, skewness, _error_of_skewness, rng, level, resamples)


def quantile_interval(values: F64, p: float, level: float = LEVEL) -> Interval:
    """Give the interval of a quantile of finite values.

    An end is infinite where it would lie beyond the outermost value.

    Parameters
    ----------
    values
        The values, float64[n], in any unit.
    p
        Probability of the quantile, above 0 and below 1.
    level
        Probability with which the interval covers the true quantile.

    Raises
    ------
    ParameterError
        `p` or the level is not between 0 and 1.
    """
    if not 0.0 < p < 1.0:
        raise ParameterError(f"quantile: {p:g}, must be above 0 and below 1; give 0.5 for the median")
    tail, ordered = 0.5 * (1.0 - _checked(level)), np.sort(values)
    # 0.0 minus, for a minus sign alone would make -0.0 of 0.0
    return Interval(_lower_end(ordered, p, tail), 0.0 - _lower_end(-ordered[::-1], 1.0 - p, tail))


def skewness(values: F64, axis: int = -1) -> Any:
    """Give the skewness along an axis: the third central moment over the 3/2 power of the second.

    The values along the axis must not all be equal.
    """
    deviation = values - values.mean(axis, keepdims=True)
    square = (deviation * deviation).mean(axis)
    return (deviation * deviation * deviation).mean(axis) / (square * np.sqrt(square))


def _lower_end(ordered: F64, p: float, tail: float) -> float:
    """Value above which the quantile p lies but with probability `tail`."""
    n = len(ordered)
    if n == 0 or _above(1.0, n, p) > tail:
        return -math.inf
    if n == 1 or _above(n, n, p) < tail:
        return float(ordered[-1])
    k = float(optimise.brentq(lambda k: _above(k, n, p) - tail, 1.0, n))
    whole = min(int(k), n - 1)
    return float(ordered[whole - 1] + (k - whole) * (ordered[whole] - ordered[whole - 1]))


def _above(k: float, n: int, p: float) -> float:
    """Chance that the k-th of n order statistics is above the quantile p, also for a fractional k."""
    return float(special.betaincc(k, n + 1.0 - k, p))


def _bootstrap_t(
    values: F64,
    statistic: Reduction,
    error: Reduction,
    rng: np.random.Generator,
    level: float,
    resamples: int,
) -> Interval:
    """Bootstrap-t interval; normal for many samples, Student's where ties leave resamples without spread."""
    point, scale, n = float(statistic(values, -1)), float(error(values, -1)), len(values)
    if np.ptp(values) == 0.0:
        return Interval(point, point)
    plain = _symmetric(point, scale, n, level)
    if n > MANY:
        return plain

    def pivot(sample: F64, axis: int = -1) -> F64:
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (statistic(sample, axis) - point) / error(sample, axis)
        return np.asarray(np.clip(np.nan_to_num(t, nan=0.0), -_FAR, _FAR))

    tail = (0.5 * (1.0 - level) * (resamples + 1) - 1.0) / (resamples - 1)  # of ranks 1 to resamples
    found = stats.bootstrap(
        (values,), pivot, n_resamples=resamples, batch=max(1, _BATCH // n), vectorized=True,
        confidence_level=1.0 - 2.0 * max(tail, 0.0), method="percentile", random_state=rng,
    ).confidence_interval  # fmt: skip
    if max(abs(found.low), abs(found.high)) > 1e-3 * _FAR or not scale > 0.0:
        return plain
    return Interval(point - scale * float(found.high), point - scale * float(found.low))


def _symmetric(point: float, scale: float, n: int, level: float) -> Interval:
    tail = 0.5 * (1.0 - level)
    reach = scale * float(-special.ndtri(tail) if n > MANY else -special.stdtrit(n - 1, tail))
    return Interval(point - reach, point + reach)


def _mean(values: F64, axis: int = -1) -> Any:
    return values.mean(axis)


def _error_of_mean(values: F64, axis: int = -1) -> Any:
    return values.std(axis, ddof=1) / math.sqrt(values.shape[axis])


def _log_sigma(values: F64, axis: int = -1) -> Any:
    return np.log(values.std(axis, ddof=1))


def _error_of_log_sigma(values: F64, axis: int = -1) -> Any:
    """Infinitesimal jackknife: ln sigma moves by (z^2 - 1) / 2n with the weight of a sample."""
    z = _standardised(values, axis)
    return 0.5 * (z * z).std(axis) / math.sqrt(values.shape[axis])


def _error_of_skewness(values: F64, axis: int = -1) -> Any:
    """Infinitesimal jackknife: the skewness g moves by (z^3 - 3 z - g - 3/2 g (z^2 - 1)) / n."""
    z = _standardised(values, axis)
    square, cube = z * z, z * z * z
    g = cube.mean(axis, keepdims=True)
    return (cube - 3.0 * z - g - 1.5 * g * (square - 1.0)).std(axis) / math.sqrt(values.shape[axis])


def _standardised(values: F64, axis: int) -> F64:
    deviation = values - values.mean(axis, keepdims=True)
    return np.asarray(deviation / np.sqrt((deviation * deviation).mean(axis, keepdims=True)))


def _checked(level: float) -> float:
    if not 0.0 < level < 1.0:
        raise ParameterError(f"level: {level:g}, must be above 0 and below 1; give 0.95")
    return level
