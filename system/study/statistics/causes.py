"""What failures come from: the die, the world that the robot met, or the noise of one run.

Whether a trial fails is 1 or 0, with the variance q (1 - q) at a failure rate q. Dies are drawn, each meets
worlds of its own, and in each world it runs with several draws of noise; so the variance is a sum

    q (1 - q) = Var(P(fail | die)) + E Var(P(fail | die, world)) + E Var(fail | die, world)

of what dies differ in, of what worlds of the same die differ in, and of what runs in the same world differ
in. The share of each term is called that of the failures which die, world or noise have caused. It has a
plain meaning: after a failure, another world on the same die fails with the chance q + (1 - q) s_die, and
another run on the same die in the same world with q + (1 - q) (s_die + s_world), where q is the chance of any
other die. What a world does to one die alone counts as the world's.

The terms are estimated by the analysis of variance of nested designs, which is unbiased (Searle, Casella and
McCulloch, "Variance Components", 1992, section 3.6); a term that comes out negative counts as 0, and shares
are of the sum. Intervals are percentiles of the bootstrap over dies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, Bools
from system.study.statistics.interval import FEWEST, LEVEL, RESAMPLES, Interval, clopper_pearson

_BATCH = 500_000  # resampled values held at a time


@dataclass(frozen=True, slots=True)
class Cause:
    """A share of the failures.

    name : what caused them: `die`, `world` or `noise`, or two of these that the trials cannot tell apart.
    share : share of all failures, 0 to 1.
    interval : its confidence interval; 0 to 1 for fewer than ten dies.
    """

    name: str
    share: float
    interval: Interval


def causes_of(failed: Bools, rng: np.random.Generator, level: float = LEVEL) -> tuple[Cause, ...]:
    """Split the failures of a mission.

    Parameters
    ----------
    failed
        Whether each run failed, bool[dies, worlds, noises].
    rng
        Generator of the bootstrap.
    level
        Confidence level of the intervals.

    Returns
    -------
    tuple of Cause
        None of them where no trial failed, where all did, or where one die or one run a die tells nothing.
    """
    dies, worlds, noises = failed.shape
    if dies < 2 or worlds * noises < 2 or failed.all() or not failed.any():
        return ()
    terms = _of_each_die(failed.astype(np.float64))
    found = _shares(terms, (worlds, noises))
    ends = np.stack([np.zeros_like(found), np.ones_like(found)])
    if dies >= FEWEST:
        tail = 0.5 * (1.0 - level)
        ends = np.quantile(_resampled(terms, (worlds, noises), rng), [tail, 1.0 - tail], axis=0)
        ends = _unseen(ends, terms, (worlds, noises), level)
    rows = zip(_names(worlds, noises), found, ends.T, strict=True)
    return tuple(Cause(name, float(share), Interval(float(a), float(b))) for name, share, (a, b) in rows)


def _unseen(ends: F64, terms: F64, shape: tuple[int, int], level: float) -> F64:
    """Ends of the intervals where on no die two runs differed, from which no resample can tell that some do.

    As many dies may have two that differ as the interval of Clopper and Pearson has of none; such a pair is
    half of a variance. What the unseen cause may have is taken from the lower ends of the others.
    """
    q, dies = float(terms[:, 0].mean()), len(terms)
    most = min(1.0, 0.5 * clopper_pearson(0, dies, level).high / (q * (1.0 - q)))
    for k, term in enumerate(_terms(*shape)):
        if not terms[:, term].any():
            ends[1, k] = most
            others = np.arange(ends.shape[1]) != k
            ends[0, others] = np.minimum(ends[0, others], 1.0 - most)
    return ends


def _terms(worlds: int, noises: int) -> tuple[int, ...]:
    """Which term of each die tells of each cause."""
    if noises == 1:
        return 0, 1
    return (0, 2) if worlds == 1 else (0, 1, 2)


def _names(worlds: int, noises: int) -> tuple[str, ...]:
    if noises == 1:
        return "die", "world and noise"
    return ("die and world", "noise") if worlds == 1 else ("die", "world", "noise")


def _of_each_die(failed: F64) -> F64:
    """Share that fails, variance between worlds, and variance between runs of a world, float64[dies, 3]."""
    _, worlds, noises = failed.shape
    by_world = failed.mean(axis=2)
    none = np.zeros(len(failed))
    between = by_world.var(axis=1, ddof=1) if worlds > 1 else none
    within = failed.var(axis=2, ddof=1).mean(axis=1) if noises > 1 else none
    return np.stack([by_world.mean(axis=1), between, within], axis=1)


def _shares(terms: F64, shape: tuple[int, int]) -> F64:
    """Shares of the causes, float64[..., causes], of dies in the last axis but one of `terms`."""
    worlds, noises = shape
    between, within = terms[..., 1].mean(axis=-1), terms[..., 2].mean(axis=-1)
    noise = within
    world = between - within / noises
    die = terms[..., 0].var(axis=-1, ddof=1) - (between / worlds if worlds > 1 else within / noises)
    parts = {(False, False): (die, world, noise), (False, True): (die, between), (True, False): (die, noise)}
    found = np.maximum(np.stack(parts[worlds == 1, noises == 1], axis=-1), 0.0)
    total = found.sum(axis=-1, keepdims=True)
    return np.asarray(np.divide(found, total, out=np.full_like(found, np.nan), where=total > 0.0))


def _resampled(terms: F64, shape: tuple[int, int], rng: np.random.Generator) -> F64:
    """Shares of resamples of the dies, float64[resamples, causes], of those in which trials differ."""
    dies = len(terms)
    batch = max(1, _BATCH // dies)
    found = [
        _shares(terms[rng.integers(0, dies, (min(batch, RESAMPLES - k), dies))], shape)
        for k in range(0, RESAMPLES, batch)
    ]
    whole = np.concatenate(found)
    return np.asarray(whole[np.isfinite(whole).all(axis=1)])
