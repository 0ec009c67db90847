"""Confidence sequence of a yield: intervals that hold at every number of samples at once.

A study that may stop itself at any sample needs such intervals.

State: `passed` of `samples`. Against a yield p the beta-binomial mixture of likelihood ratios

    M_n(p) = B(a + passed, a + samples - passed) / (B(a, a) p^passed (1 - p)^(samples - passed))

is a martingale with M_0 = 1 when samples are independent and p is true (a step multiplies by the mixture's
predictive chance over p's). By Ville's inequality it ever reaches 1 / (1 - level) with a chance of at most
1 - level. So the interval {p: M_n(p) < 1 / (1 - level)} holds for all n together with probability `level`,
whatever rule ends the study. a = 1/2, Jeffreys's prior, is narrower than a = 1 near yields of 0 and 1; any a
is valid.

An interval depends on the counts alone, not on when it was looked at. Samples must be independent: those of a
keyed random plan are, those of a Latin hypercube or of Sobol's sequence are not.
Source: Robbins, "Statistical methods related to the law of the iterated logarithm" (1970), section 4; Howard,
Ramdas, McAuliffe, Sekhon, "Time-uniform, nonparametric, nonasymptotic confidence sequences" (2021).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.catalogue import later
from circuits.errors import ParameterError
from system.study.statistics.interval import LEVEL, Interval

special = later("scipy.special")

_A = 0.5
_HALVINGS = 60  # to the resolution of a float


@dataclass(frozen=True, slots=True)
class StopRule:
    """Rule that stops a study as soon as its yield is known well enough.

    A condition that is None is left out. Raises `ParameterError` for a value outside 0 to 1, and where both
    conditions are left out.

    Attributes
    ----------
    half_width : float or None
        The study stops when half of the interval's length is below this share.
    required : float or None
        The study stops when the interval excludes this yield, a share.
    level : float
        Confidence level of the interval.
    """

    half_width: float | None = None
    required: float | None = None
    level: float = LEVEL

    def __post_init__(self) -> None:
        """Check the parts."""
        if self.half_width is None and self.required is None:
            raise ParameterError("auto-stop: no rule, must have one; give a half-width or a required yield")
        for name in ("half_width", "required", "level"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < 1.0:
                raise ParameterError(f"auto-stop: {name} {value:g}, must be above 0 and below 1")


@dataclass(frozen=True, slots=True)
class Stop:
    """Sample at which a rule ended a study.

    samples : number of samples until then.
    passed : how many of them passed.
    interval : interval of the yield at that sample.
    reason : why the rule ended the study, in words.
    """

    samples: int
    passed: int
    interval: Interval
    reason: str


def sequence_interval(passed: int, samples: int, level: float = LEVEL) -> Interval:
    """Give the interval of the yield after `samples`, which holds at all numbers of samples at once.

    Raises `ParameterError` unless 0 <= passed <= samples.
    """
    if not 0 <= passed <= samples:
        raise ParameterError(f"passed: {passed}, must be from 0 to samples {samples}; count again")
    low, high = sequence_intervals(np.array([passed]), np.array([samples]), level)
    return Interval(float(low[0]), float(high[0]))


def sequence_intervals(passed: I64, samples: I64, level: float = LEVEL) -> tuple[F64, F64]:
    """Give the lower and the upper ends of the intervals of the yield, float64[n] each.

    Parameters
    ----------
    passed : int64[n], how many samples passed.
    samples : int64[n], out of how many.
    level : confidence level, from 0 to 1.
    """
    centre = passed / np.maximum(samples, 1)
    low = _edge(passed, samples, np.zeros_like(centre), centre, level)
    high = _edge(passed, samples, np.ones_like(centre), centre, level)
    return np.where(passed == 0, 0.0, low), np.where(passed == samples, 1.0, high)


def log_martingale(passed: I64, samples: I64, p: F64 | float) -> F64:
    """Give the natural logarithm of the martingale M_n(p), float64[n].

    The yield p, which is a number or float64[n], is refuted where the logarithm is above -ln(1 - level). Both
    counts are int64[n].
    """
    failed = samples - passed
    mixture = special.betaln(_A + passed, _A + failed) - special.betaln(_A, _A)
    return np.asarray(mixture - special.xlogy(passed, p) - special.xlog1py(failed, -np.asarray(p)))


def ended(rule: StopRule, interval: Interval) -> bool:
    """Tell whether the rule ends a study whose yield has the interval `interval`."""
    narrow = rule.half_width is not None and interval.half_width < rule.half_width
    return narrow or (rule.required is not None and rule.required not in interval)


def first_stop(passed: Bools, rule: StopRule) -> Stop | None:
    """Find the first sample at which the rule ends the study; None where it never does.

    Parameters
    ----------
    passed
        Whether each sample passed, bool[n], in the order of the samples. The answer does not depend on
        how the samples are divided into chunks.
    """
    counts, samples = np.cumsum(passed, dtype=np.int64), np.arange(1, len(passed) + 1)
    low, high = sequence_intervals(counts, samples, rule.level)
    narrow = 0.5 * (high - low) < (rule.half_width or 0.0)
    required = math.nan if rule.required is None else rule.required
    ended = np.flatnonzero(narrow | (low > required) | (high < required))
    if not ended.size:
        return None
    k = int(ended[0])
    interval = Interval(float(low[k]), float(high[k]))
    return Stop(k + 1, int(counts[k]), interval, _reason(rule, interval))


def _reason(rule: StopRule, interval: Interval) -> str:
    if rule.required is not None and rule.required not in interval:
        side = "above" if interval.low > rule.required else "below"
        return f"the yield is {side} {rule.required:g}"
    return f"the yield's half-width is below {rule.half_width:g}"


def _edge(passed: I64, samples: I64, outer: F64, inner: F64, level: float) -> F64:
    """Where M_n, which grows from `inner` to `outer`, crosses the limit: bisected, on the safe side."""
    limit = -math.log1p(-level)
    for _ in range(_HALVINGS):
        middle = 0.5 * (outer + inner)
        refuted = log_martingale(passed, samples, middle) >= limit
        outer, inner = np.where(refuted, middle, outer), np.where(refuted, inner, middle)
    return outer
