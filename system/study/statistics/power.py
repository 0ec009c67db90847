"""Power: how likely a test of so many samples finds an effect, and the smallest effect that it will find.

Exact for counts: a sign test of n pairs that differ, or a comparison of two rates by n events of which a
share is expected on one side, are binomial tests. For means it is Student's test of n values, whose power is
that of the noncentral t. Two-sided, an equal part of the limit on either side. An effect is detectable where
the power is `POWER`. Sources: Cohen, "Statistical Power Analysis for the Behavioral Sciences" (1988),
sections 2 and 5; Przyborowski and Wilenski, Biometrika 31, 313 (1940) for rates.
"""

from __future__ import annotations

import math

import numpy as np

from circuits.catalogue import later
from circuits.errors import ParameterError

optimise, stats = later("scipy.optimize"), later("scipy.stats")

LIMIT = 0.05  # of p
POWER = 0.8  # the convention of the field
_NEAR = 1e-9  # of a share to 0 and 1
_FAR = 1e3  # standard deviations, beyond every effect that is asked for


def binomial_power(count: int, true: float, null: float = 0.5, limit: float = LIMIT) -> float:
    """Probability that an exact binomial test of `count` events tells the share `true` from `null`.

    Parameters
    ----------
    count
        Events, or pairs that differ.
    true
        Share of them that is so, from 0 to 1.
    null
        Share under the hypothesis that is tested; one half for pairs.
    limit
        Of the two-sided p, a half of it on either side.

    Raises
    ------
    ParameterError
        There are fewer than no events, or a share is not from 0 to 1.
    """
    if count < 0 or not (0.0 <= true <= 1.0 and 0.0 < null < 1.0):
        raise ParameterError(
            f"power: {count} events, shares {true:g}, {null:g}, must be at least 0, and 0 to 1; count again"
        )
    k = np.arange(count + 1)
    few = stats.binom.cdf(k, count, null) <= 0.5 * limit
    many = stats.binom.sf(k - 1, count, null) <= 0.5 * limit
    return float(stats.binom.pmf(k, count, true)[few | many].sum())


def detectable_share(count: int, null: float = 0.5, limit: float = LIMIT, power: float = POWER) -> float:
    """Smallest share above `null` that `count` events tell from it; not a number where none is large enough.

    Arguments are those of `binomial_power`; `power` is the probability with which it is found, from 0 to 1.
    """
    if binomial_power(count, 1.0 - _NEAR, null, limit) < power:
        return math.nan
    return float(optimise.brentq(lambda x: binomial_power(count, x, null, limit) - power, null, 1.0 - _NEAR))


def detectable_ratio(
    first: float, second: float, events: int, limit: float = LIMIT, power: float = POWER
) -> float:
    """Smallest ratio of two rates, above 1, that `events` of both together tell from 1.

    Not a number where none is. Under equal rates the share of the events that are the first's is that of its
    exposure.

    Parameters
    ----------
    first, second
        Exposures, in any unit that they share, as m of way.
    events
        Events of both together.
    limit
        Of the two-sided p.
    power
        Probability with which the ratio is found, from 0 to 1.
    """
    if not (first > 0.0 and second > 0.0):
        return math.nan
    share = detectable_share(events, first / (first + second), limit, power)
    return share / (1.0 - share) * second / first


def mean_power(count: int, effect: float, limit: float = LIMIT) -> float:
    """Probability that Student's test of `count` values tells a mean that is off its null by `effect`.

    It is 0 below two values. `effect` is in standard deviations of the values; `limit` is of the two-sided p.
    """
    if count < 2:
        return 0.0
    edge, shift = float(stats.t.isf(0.5 * limit, count - 1)), effect * math.sqrt(count)
    return float(stats.nct.sf(edge, count - 1, shift) + stats.nct.cdf(-edge, count - 1, shift))


def detectable_mean(count: int, limit: float = LIMIT, power: float = POWER) -> float:
    """Smallest distance of a mean from its null that `count` values tell, in deviations of the values.

    Not a number below two values. `limit` and `power` are those of the other functions.
    """
    if count < 2:
        return math.nan
    return float(optimise.brentq(lambda x: mean_power(count, x, limit) - power, 0.0, _reach(count, limit)))


def _reach(count: int, limit: float) -> float:
    """An effect that is found for sure: twice the test's edge, and as much again for the scatter."""
    return min(_FAR, 4.0 * float(stats.t.isf(0.5 * limit, count - 1)) + 4.0)
