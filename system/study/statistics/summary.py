"""Summary of the samples of a study: moments and quantiles of a metric, and the yield, with intervals.

Samples whose metric is NaN are counted as undefined, those where it is infinite as infinite; moments and
quantiles are of the finite ones. Nothing is dropped unseen: samples = defined + undefined + infinite.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, I64
from system.study.specification import Verdict
from system.study.statistics.interval import (
    EVERYTHING,
    LEVEL,
    Estimate,
    Interval,
    clopper_pearson,
    mean_interval,
    quantile_interval,
    sigma_interval,
    skew_interval,
    skewness,
)
from system.study.statistics.share import percent

_UNKNOWN = EVERYTHING, Interval(0.0, math.inf)  # of mean and sigma
PROBABILITIES = (0.025, 0.05, 0.25, 0.5, 0.75, 0.95, 0.975)


@dataclass(frozen=True, slots=True)
class Quantile:
    """Quantile of a metric over the samples.

    p : probability of the quantile, above 0 and below 1.
    estimate : its value with its interval, in the unit of the metric.
    """

    p: float
    estimate: Estimate


@dataclass(frozen=True, slots=True)
class Proportion:
    """Share of the samples that pass, or for which a yes-or-no metric says yes.

    passed : how many these are.
    samples : of how many: all that were judged, or those at which the metric is defined.
    estimate : the share, with its interval.
    """

    passed: int
    samples: int
    estimate: Estimate

    def __str__(self) -> str:
        """Write the share as `0 of 20 (0 to 17 %)`."""
        return f"{self.passed} of {self.samples} ({percent(self.estimate.interval)})"


@dataclass(frozen=True, slots=True)
class Summary:
    """Statistics of a metric over the samples, in the unit of the metric.

    A statistic is NaN with an unlimited interval where there are too few values. Where all values are equal
    nothing is known of their spread, and the mean has no interval. Where dies have several samples each these
    are alike: the mean has the interval of the dies' means, and the other statistics have none.

    Attributes
    ----------
    samples : int
        Number of all samples.
    defined : int
        Samples at which the metric is finite.
    undefined : int
        Samples at which the metric is NaN.
    infinite : int
        Samples at which the metric is infinite.
    mean : Estimate
        Arithmetic mean.
    sigma : Estimate
        Standard deviation.
    skew : Estimate
        Skewness, without a unit.
    quantiles : tuple of Quantile
        Quantiles in the order of the probabilities asked for.
    share : Proportion or None
        Share that says yes of a yes-or-no metric, which has no other statistic than its mean; None of a
        number.
    """

    samples: int
    defined: int
    undefined: int
    infinite: int
    mean: Estimate
    sigma: Estimate
    skew: Estimate
    quantiles: tuple[Quantile, ...]
    share: Proportion | None = None


@dataclass(frozen=True, slots=True)
class Yield(Proportion):
    """Yield of the samples that were judged by specifications.

    causes : number of samples that do not pass, by cause.
    """

    causes: Mapping[str, int]


def summarise(
    values: F64,
    rng: np.random.Generator,
    probabilities: Sequence[float] = PROBABILITIES,
    level: float = LEVEL,
    dies: I64 | None = None,
) -> Summary:
    """Summarise the values of a metric, float64[n], NaN where it is not defined.

    Parameters
    ----------
    values
        Values, float64[n], in the unit of the metric; -0.0 is taken for 0.0.
    rng
        Generator of the bootstrap alone; a keyed one gives the same intervals for the same values.
    probabilities
        Probability of each quantile that is estimated.
    level
        Confidence level of the intervals.
    dies
        Number of each value's die, int64[n], where dies have several values each.
    """
    finite = np.isfinite(values)
    x, undefined = values[finite] + 0.0, int(np.isnan(values).sum())
    spread = len(x) > 1 and np.ptp(x) > 0.0
    alone = dies is None  # each value is its own die's
    own = x if dies is None else means_of_dies(x, dies[finite])
    mean, sigma = _UNKNOWN
    if spread:
        mean = mean_interval(own, rng, level) if len(own) > 1 and np.ptp(own) > 0.0 else EVERYTHING
        sigma = sigma_interval(x, rng, level) if alone else sigma
    return Summary(
        samples=len(values),
        defined=len(x),
        undefined=undefined,
        infinite=len(values) - len(x) - undefined,
        mean=Estimate(float(x.mean()) if len(x) else math.nan, mean),
        sigma=Estimate(_sigma(x), sigma),
        skew=Estimate(_skew(x), skew_interval(x, rng, level) if alone else EVERYTHING),
        quantiles=tuple(Quantile(p, _quantile(x, p, level, alone=alone)) for p in probabilities),
    )


def means_of_dies(values: F64, dies: I64) -> F64:
    """Give the mean of each die's values, float64[dies], in the order of the dies' numbers.

    values: float64[n], finite. dies: number of each value's die, int64[n].
    """
    _, owner, counts = np.unique(dies, return_inverse=True, return_counts=True)
    return np.asarray(np.bincount(owner, values, len(counts)) / counts)


def _sigma(x: F64) -> float:
    """Standard deviation, 0 of equal values, whose mean may be a rounding beside them; NaN below two."""
    if len(x) < 2:
        return math.nan
    return float(x.std(ddof=1)) if np.ptp(x) > 0.0 else 0.0


def summarise_share(values: F64, interval: Callable[[int, int], Interval] = clopper_pearson) -> Summary:
    """Summarise a yes-or-no metric, float64[n], 1 for yes, 0 for no and NaN where it is not defined.

    interval: gives the interval of a proportion from how many samples say yes and out of how many.
    """
    defined = int(np.isfinite(values).sum())
    passed = int((values == 1.0).sum())
    share = Estimate(passed / defined if defined else math.nan, interval(passed, defined))
    none = Estimate(math.nan, EVERYTHING)
    found = Proportion(passed, defined, share)
    return Summary(len(values), defined, len(values) - defined, 0, share, none, none, (), found)


def summarise_yield(verdict: Verdict, level: float = LEVEL) -> Yield:
    """Summarise judged samples as a yield with its Clopper-Pearson interval.

    The interval holds for a number of samples that was fixed beforehand. For a study that stopped itself use
    `confidence_sequence.sequence_interval`.

    Parameters
    ----------
    verdict
        The judgement of the samples.
    level
        Probability with which the interval covers the true yield, at least.
    """
    samples, passed = len(verdict.causes), int(verdict.passed.sum())
    value = passed / samples if samples else math.nan
    return Yield(passed, samples, Estimate(value, clopper_pearson(passed, samples, level)), verdict.counts)


def _quantile(x: F64, p: float, level: float, *, alone: bool) -> Estimate:
    if not len(x):
        return Estimate(math.nan, EVERYTHING)
    return Estimate(float(np.quantile(x, p)), quantile_interval(x, p, level) if alone else EVERYTHING)


def _skew(x: F64) -> float:
    return float(skewness(x)) if len(x) > 2 and np.ptp(x) > 0.0 else math.nan
