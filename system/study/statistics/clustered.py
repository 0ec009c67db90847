"""Yield of trials that belong to dies: the dies are the sample, and the trials of a die are alike.

Of D dies each has m trials, of which the share x_d passes. The yield is the mean p of these shares, whose
variance over the dies, s^2 / D, is what is known of it, whatever makes trials of a die alike. An effective
number of trials n = p (1 - p) / (s^2 / D) would be as well known if they were independent; the interval is
that of Clopper and Pearson (1934) for p n passes of n, from quantiles of the beta distribution at fractional
counts, n being made smaller by the square of Student's quantile over the normal one, since s is estimated
from D dies. With one trial a die nothing is estimated: n is D. Source: Korn and Graubard, "Confidence
intervals for proportions with small expected number of positive counts estimated from survey data" (1998).

Where few trials fail, little is known of how alike they are, and from no failure nothing is. So `PRIOR` is
added to the squares of the dies' deviations, and to what these would be if trials of a die were all alike,
D p (1 - p): without a failure each die counts once, whatever its trials. That weight is ours.

A study may end itself once this interval is narrow enough (`narrow`): in simulated studies the interval still
covers as often as it says (`benchmarks/mission_interval.py`). That holds for this rule alone. Unlike a
confidence sequence it says nothing to who stops when the yield pleases.

Source of the correlation: Kish, "Survey Sampling" (1965): n = D m / (1 + (m - 1) rho).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.errors import ParameterError
from system.study.statistics.interval import LEVEL, Interval, clopper_pearson, mean_interval

stats, special = later("scipy.stats"), later("scipy.special")

PRIOR = 0.5  # dies on which all trials fail
FEWEST_DIES = 16  # at which a study ends itself; ours


@dataclass(frozen=True, slots=True)
class ClusteredYield:
    """Yield of dies with several trials each.

    Attributes
    ----------
    value : float
        The yield, NaN without dies.
    interval : Interval
        Its confidence interval.
    dies, trials : int
        Dies, and trials on each of them.
    effective : float
        Number of independent trials from which it would be known as well.
    correlation : float
        Correlation of two trials of a die, 0 to 1; NaN for one trial a die, and where all trials are alike.
    """

    value: float
    interval: Interval
    dies: int
    trials: int
    effective: float
    correlation: float


def clustered_yield(shares: F64, trials: int, level: float = LEVEL) -> ClusteredYield:
    """Estimate the yield of dies from the share of each die's trials that pass.

    Parameters
    ----------
    shares
        Share of the trials that pass, of each die, float64[dies].
    trials
        Number of trials of each die.
    level
        Probability with which the interval covers the true yield.

    Raises
    ------
    ParameterError
        A die has no trial, or the level is not between 0 and 1.
    """
    if trials < 1 or not 0.0 < level < 1.0:
        raise ParameterError(f"trials: {trials} at level {level:g}, must be at least 1, and between 0 and 1")
    dies = len(shares)
    if dies == 0:
        return ClusteredYield(math.nan, Interval(0.0, 1.0), 0, trials, 0.0, math.nan)
    value = float(shares.mean())
    if trials == 1:
        exact = beta_interval(value, dies, level)
        return ClusteredYield(value, exact, dies, trials, float(dies), math.nan)
    effective = _effective(shares, trials, value)
    reach = (
        (special.ndtri(0.5 + 0.5 * level) / special.stdtrit(dies - 1, 0.5 + 0.5 * level)) ** 2
        if dies > 1
        else 0.0
    )
    interval = beta_interval(value, max(float(effective * reach), 1.0), level)
    return ClusteredYield(value, interval, dies, trials, effective, _correlation(shares, trials, value))


def mean_of_shares(shares: F64, least: float = 0.0) -> Interval:
    """Give the 95 % interval of the mean of dies' shares, or of differences of such shares.

    Of dies that are all alike some may differ unseen, by as much as a share can.

    Parameters
    ----------
    shares
        Share of each die, float64[dies].
    least
        The least that one can be: -1 of differences.
    """
    if not len(shares):
        return Interval(least, 1.0)
    if np.ptp(shares) == 0.0:
        value, reach = float(shares.mean()), clopper_pearson(0, len(shares)).high
        ends = Interval(value - reach, value + reach)
    else:
        ends = mean_interval(shares, np.random.Generator(np.random.Philox(key=0)))
    return Interval(max(ends.low, least), min(ends.high, 1.0))


def narrow(found: ClusteredYield, half_width: float) -> bool:
    """Tell whether a study ends itself: at an interval of that half-width, a share, and `FEWEST_DIES`."""
    return found.dies >= FEWEST_DIES and found.interval.half_width <= half_width


def _effective(shares: F64, trials: int, value: float) -> float:
    """Effective number of trials, from that of the dies to that of all."""
    dies = len(shares)
    spread = float(((shares - value) ** 2).sum()) * dies / max(dies - 1, 1)
    alike = (spread + PRIOR) / (dies * value * (1.0 - value) + PRIOR)  # 1 where a die's trials are all alike
    return float(np.clip(dies / alike, dies, dies * trials))


def _correlation(shares: F64, trials: int, value: float) -> float:
    """Correlation of two trials of a die, from the variance between dies."""
    most = value * (1.0 - value)
    if trials == 1 or len(shares) < 2 or most == 0.0:
        return math.nan
    ratio = float(shares.var(ddof=1)) / most
    return float(np.clip((trials * ratio - 1.0) / (trials - 1.0), 0.0, 1.0))


def beta_interval(value: float, samples: float, level: float) -> Interval:
    """Return Clopper and Pearson's interval of a share of a number of samples that need not be whole."""
    tail, passed = 0.5 * (1.0 - level), value * samples
    failed = samples - passed
    low = float(stats.beta.ppf(tail, passed, failed + 1.0)) if value > 0.0 else 0.0
    high = float(stats.beta.isf(tail, passed + 1.0, failed)) if value < 1.0 else 1.0
    return Interval(low, high)
