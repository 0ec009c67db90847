"""Campaigns in the forest: avoided obstacles a collision of a configuration, and whether two differ.

A configuration is flown until 200 collisions or 2.5e8 pings (a campaign may take fewer), in samples whose
seeds follow each other. A collision is taken for a Poisson event of the number of avoided obstacles: with K
collisions in A avoided obstacles the mean is A / K, and its exact interval follows from quantiles of
chi-squared; samples that ended without a collision count with what they avoided (censored). Given both
exposures, the share of collisions that one of two configurations had is binomial, which is an exact test of
equal means: Przyborowski and Wilenski (1940).

Samples are flown in groups of `GROUP`, each with an equal part of the pings that are left, so that what is
found does not depend on the number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import accumulate

from scipy import stats

from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from system.openspace.flight import Sample, fly_sample, planter
from system.openspace.law import Bat, arcs_of
from system.openspace.map import OBSTACLES
from system.openspace.senses import IDEAL, Sensing, senses_of
from system.study.statistics.interval import LEVEL, Estimate, Interval

COLLISIONS, PINGS = 200, 250_000_000  # at which a configuration ends
CHIP_PINGS = 25_000_000  # with chips
FIRST_SEED = 50_000  # of a report; those below 1000 choose numbers, none between is used
GROUP = 10  # samples that share the pings that are left; ours


def nominal_die(_: int) -> Die:
    """The nominal die for every sample."""
    return NOMINAL


def own_die(seed: int) -> Die:
    """A die a sample."""
    return Die(number=seed)


def own_mismatch(seed: int) -> Die:
    """A die a sample, without what its devices share: as if every die's biases were trimmed."""
    return Die(number=seed, process=False)


@dataclass(frozen=True, slots=True)
class Case:
    """A configuration: a bat, the number of obstacles, senses, and silicon (degC) with a die a seed."""

    bat: Bat = field(default_factory=Bat)
    obstacles: int = OBSTACLES
    sensing: Sensing = IDEAL
    die: Callable[[int], Die] = nominal_die
    temperature_c: float = 27.0


@dataclass(frozen=True, slots=True)
class Limits:
    """Where a configuration ends, and the seed of its first sample."""

    collisions: int = COLLISIONS
    pings: int = PINGS
    first_seed: int = FIRST_SEED

    def __post_init__(self) -> None:
        if self.collisions < 1 or self.pings < GROUP:
            raise ParameterError(
                f"limits: {self.collisions} collisions, {self.pings} pings, must be at least 1 and {GROUP}"
            )


@dataclass(frozen=True, slots=True)
class Tally:
    """Samples of a configuration, in the order of their seeds."""

    case: Case
    samples: tuple[Sample, ...]

    @property
    def collisions(self) -> int:
        """Number of samples that ended by a collision."""
        return sum(s.collided for s in self.samples)

    @property
    def avoided(self) -> int:
        """Avoided obstacles of all samples."""
        return sum(s.avoided for s in self.samples)

    @property
    def pings(self) -> int:
        """Pings of all samples."""
        return sum(s.pings for s in self.samples)

    @property
    def censored(self) -> int:
        """Number of samples that ended without a collision."""
        return len(self.samples) - self.collisions

    @property
    def mean(self) -> Estimate:
        """Avoided obstacles a collision; inf without any, where the interval has a lower end still."""
        return mean_avoided(self.avoided, self.collisions)


def fly_case(
    case: Case,
    limits: Limits,
    threads: int = 1,
    progress: Callable[[float], None] | None = None,
) -> Tally:
    """Fly samples until the limits."""
    samples: list[Sample] = []
    arcs, forests = arcs_of(case.bat), planter(case.obstacles)

    def fly_one(key: tuple[int, int]) -> Sample:
        seed, pings = key
        senses = senses_of(case.sensing, case.bat, case.die(seed), case.temperature_c, (seed, 0))
        return fly_sample(arcs, forests, (seed, 0), pings, senses=senses)[0]

    left, met = limits.pings, 0
    with ThreadPoolExecutor(threads) as pool:
        while met < limits.collisions and left >= GROUP:
            first = limits.first_seed + len(samples)
            flown = list(pool.map(fly_one, _keys(first, left // GROUP)))
            flown = flown[: _enough([s.collided for s in flown], limits.collisions - met)]
            samples += flown
            met += sum(s.collided for s in flown)
            left -= sum(s.pings for s in flown)
            if progress is not None:
                progress(max(met / limits.collisions, 1.0 - left / limits.pings))
    return Tally(case, tuple(samples))


def mean_avoided(avoided: int, collisions: int, level: float = LEVEL) -> Estimate:
    """Avoided obstacles a collision, with the exact Poisson interval of Garwood (1936)."""
    tail = 0.5 * (1.0 - level)
    most = 0.5 * float(stats.chi2.isf(tail, 2 * collisions + 2))
    least = 0.5 * float(stats.chi2.ppf(tail, 2 * collisions)) if collisions else 0.0
    interval = Interval(avoided / most, avoided / least if collisions else math.inf)
    return Estimate(avoided / collisions if collisions else math.inf, interval)


def differ_p(a: Tally, b: Tally) -> float:
    """Two-sided probability of collisions so unlike if both had the same mean; 1 where nothing was flown."""
    met, flown = a.collisions + b.collisions, a.avoided + b.avoided
    if met == 0 or flown == 0:
        return 1.0
    return float(stats.binomtest(a.collisions, met, a.avoided / flown).pvalue)


def _keys(first: int, pings: int) -> Sequence[tuple[int, int]]:
    return [(first + k, pings) for k in range(GROUP)]


def _enough(collided: Sequence[bool], wanted: int) -> int:
    """How many samples it takes to so many collisions, or all."""
    reached = [k for k, met in enumerate(accumulate(map(int, collided))) if met >= wanted]
    return reached[0] + 1 if reached else len(collided)
