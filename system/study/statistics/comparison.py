"""Comparison of the yields of two designs that were measured on the same dies.

Pairing the dies cancels the variation that they have in common, so that the difference of the designs is
left.

McNemar's exact test looks at the dies where the designs disagree, binomial(n_10 + n_01, 1/2). The interval of
the difference d = (n_10 - n_01) / n inverts the score test,

    |n_10 - n_01 - n d| = z sqrt(n (2 q + d (1 - d)))

with q the maximum-likelihood chance of n_01 under d: the larger root of A q^2 + B q + C = 0, A = 2 n,
B = -n_10 - n_01 + (2 n - n_10 + n_01) d, C = -n_01 d (1 - d).
Sources: McNemar, Psychometrika 12, 153 (1947); Tango, "Equivalence test and confidence interval for the
difference in proportions for the paired-sample design", Statistics in Medicine 17, 891 (1998), section 3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from circuits.arrays import I64, Bools
from circuits.catalogue import later
from circuits.errors import ParameterError
from system.study.statistics.interval import LEVEL, Estimate, Interval

optimise, special, stats = later("scipy.optimize"), later("scipy.special"), later("scipy.stats")

Counts = int | I64

_BESIDE = 1e-9  # from the estimate, where the score of an empty cell is zero by itself


@dataclass(frozen=True, slots=True)
class Pairing:
    """Numbers of dies that two designs have in common and that only one of them has.

    Attributes
    ----------
    both : int
        How many dies both designs were measured on.
    only_first, only_second : int
        How many dies only the one design was measured on.
    """

    both: int
    only_first: int
    only_second: int


@dataclass(frozen=True, slots=True)
class YieldDifference:
    """Difference between the yields of two designs, over the dies that both were measured on.

    Attributes
    ----------
    pairing : Pairing
        How many dies the designs have in common.
    both_pass : int
        How many common dies both designs pass on.
    only_first_passes, only_second_passes : int
        How many common dies the one design passes on and the other does not.
    neither_passes : int
        How many common dies no design passes on.
    difference : Estimate
        Yield of the second design minus that of the first, with its interval; NaN without common dies.
    p_value : float
        Probability by McNemar's exact test, under the hypothesis that both yields are equal.
    """

    pairing: Pairing
    both_pass: int
    only_first_passes: int
    only_second_passes: int
    neither_passes: int
    difference: Estimate
    p_value: float


def compare_yields(
    first_dies: I64, first_passed: Bools, second_dies: I64, second_passed: Bools, level: float = LEVEL
) -> YieldDifference:
    """Estimate the difference between the yields of two designs.

    Parameters
    ----------
    first_dies, second_dies
        Numbers of the dies of each design, int64[n], each number once.
    first_passed, second_passed
        Whether each of these dies passed, bool[n].
    level
        Confidence level of the interval, from 0 to 1.

    Raises
    ------
    ParameterError
        A die occurs twice in one design.
    """
    pairing, here, there = _pair(first_dies, second_dies)
    x, y = first_passed[here], second_passed[there]
    gained, lost = int((y & ~x).sum()), int((x & ~y).sum())
    p_value = float(stats.binomtest(gained, gained + lost).pvalue) if gained + lost else 1.0
    value = (gained - lost) / pairing.both if pairing.both else math.nan
    return YieldDifference(
        pairing,
        int((x & y).sum()),
        lost,
        gained,
        int((~x & ~y).sum()),
        Estimate(value, paired_interval(gained, lost, pairing.both, level)),
        p_value,
    )


def paired_interval(gained: int, lost: int, pairs: int, level: float = LEVEL) -> Interval:
    """Give the score interval of the difference of two paired yields.

    Parameters
    ----------
    gained : pairs of which only the second member passes.
    lost : pairs of which only the first member passes.
    pairs : number of all pairs; without pairs the interval is -1 to 1.
    level : confidence level, from 0 to 1.
    """
    z = float(-special.ndtri(0.5 * (1.0 - level)))

    def score(d: float) -> float:
        """Square of the test's distance, less z^2 times its variance: zero at an end."""
        distance = gained - lost - pairs * d
        return float(distance * distance - z * z * _variance(gained, lost, pairs, d))

    if pairs == 0:
        return Interval(-1.0, 1.0)
    centre = (gained - lost) / pairs
    below, above = centre - _BESIDE, centre + _BESIDE
    low = float(optimise.brentq(score, -1.0, below)) if score(-1.0) > 0.0 > score(below) else -1.0
    high = float(optimise.brentq(score, above, 1.0)) if score(1.0) > 0.0 > score(above) else 1.0
    return Interval(low, high)


def paired_equivalence(gained: int, lost: int, pairs: int, margin: float) -> float:
    """Give the p of two one-sided score tests that two paired yields differ by a margin or more.

    It is the larger of both, and below 5 % where the 90 % `paired_interval` lies within the margin; 1 without
    pairs.

    Parameters
    ----------
    gained : pairs of which only the second member passes.
    lost : pairs of which only the first member passes.
    pairs : number of all pairs.
    margin : difference from which on the yields count as different, from 0 to 1.
    """
    if pairs == 0:
        return 1.0

    def one_sided(d: float) -> float:
        """P of so small a distance from the margin's end d, towards zero."""
        variance = _variance(gained, lost, pairs, d)
        distance = math.copysign(1.0, -d) * (gained - lost - pairs * d)
        return float(special.ndtr(-distance / math.sqrt(variance))) if variance > 0.0 else 0.5

    return max(one_sided(-margin), one_sided(margin))


_FAR = 9.0  # standard deviations of a count, and as many more; ours


def chance_above(gain: float, loss: float, pairs: int, margin: float, level: float) -> float:
    """Give the chance that a `paired_interval` lies above -margin, summed over all counts.

    Parameters
    ----------
    gain, loss : chance that of a pair only the second member passes, or only the first.
    pairs : number of all pairs.
    margin : from 0 to 1.
    level : confidence level of the interval, from 0 to 1.
    """
    most, fewer = (min(pairs, int(pairs * p + _FAR * (math.sqrt(pairs * p) + 1.0))) for p in (gain, loss))
    gained, lost = np.ogrid[: most + 1, : fewer + 1]  # beyond are too few to be seen in a double
    differ = gained + lost
    alike = np.maximum(pairs - differ, 0)
    ways = special.binom(pairs, differ) * special.binom(differ, lost)
    chance = ways * gain**gained * loss**lost * (1.0 - gain - loss) ** alike  # no way where too many differ
    needed = special.ndtri(0.5 * (1.0 + level)) * np.sqrt(_variance(gained, lost, pairs, -margin))
    return float(chance[gained - lost + pairs * margin > needed].sum())


def _variance(gained: Counts, lost: Counts, pairs: int, d: float) -> Any:
    """Variance of the difference of the counts if that of the yields is d."""
    return pairs * np.maximum(2.0 * _nuisance(gained, lost, pairs, d) + d * (1.0 - d), 0.0)


def _nuisance(gained: Counts, lost: Counts, pairs: int, d: float) -> Any:
    a = 2.0 * pairs
    b = -gained - lost + (2.0 * pairs - gained + lost) * d
    c = -lost * d * (1.0 - d)
    return np.maximum(0.0, (np.sqrt(np.maximum(0.0, b * b - 4.0 * a * c)) - b) / (2.0 * a))


def _pair(first: I64, second: I64) -> tuple[Pairing, I64, I64]:
    """Positions of the common dies in each, in the order of the dies."""
    for dies in (first, second):
        if len(np.unique(dies)) != len(dies):
            raise ParameterError("dies: one is there twice, must be once; compare one condition at a time")
    common, here, there = np.intersect1d(first, second, assume_unique=True, return_indices=True)
    return Pairing(len(common), len(first) - len(common), len(second) - len(common)), here, there
