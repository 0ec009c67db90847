"""Campaigns of samples: avoided obstacles a collision of a configuration, and whether two differ.

A configuration is flown until 200 collisions or 2.5e8 pings (a campaign may take fewer), in samples whose
seeds follow each other. A collision is taken for a Poisson event of the number of avoided obstacles: with K
collisions in A avoided obstacles the mean is A / K, and its exact interval follows from quantiles of
chi-squared; samples that ended without a collision count with what they avoided (censored). Given both
exposures, the share of collisions that one of two configurations had is binomial, which is an exact test of
equal means: Przyborowski and Wilenski (1940).

Samples are flown in groups of `GROUP`, each with an equal part of the pings that are left, so that what is
found does not depend on who flies them (`system.study.campaign`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.metadata import version
from itertools import accumulate
from typing import NamedTuple

from circuits.catalogue import later
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.openspace.flight import Sample, fly_sample, planter
from system.openspace.law import Arcs, Bat, arcs_of
from system.openspace.map import OBSTACLES
from system.openspace.senses import IDEAL, Sensing, senses_of
from system.study.campaign import Campaign, Execution, Runs
from system.study.statistics.interval import LEVEL, Estimate, Interval, poisson_interval

stats = later("scipy.stats")

COLLISIONS, PINGS = 200, 250_000_000  # at which a configuration ends
FIRST_SEED = 50_000  # of a report; those below 1000 choose numbers, none between is used
GROUP = 10  # samples that share the pings that are left; ours


def nominal_die(_: int) -> Die:
    """Return the nominal die for every sample."""
    return NOMINAL


def own_mismatch(seed: int) -> Die:
    """Return a die a sample, without what its devices share: as if every die's biases were trimmed."""
    return Die(number=seed, process=False)


@dataclass(frozen=True, slots=True)
class Case:
    """A configuration: a bat, the number of obstacles, senses, and silicon with a die a seed.

    bias_kind: of the ranging chip's biases; fixed gate voltages, as on the paper's chip.
    """

    bat: Bat = field(default_factory=Bat)
    obstacles: int = OBSTACLES
    sensing: Sensing = IDEAL
    die: Callable[[int], Die] = nominal_die
    temperature_c: float = 27.0
    bias_kind: BiasKind = "gate"


@dataclass(frozen=True, slots=True)
class Limits:
    """Where a configuration ends, and the seed of its first sample.

    collisions : samples that end by a collision, after which it is enough.
    pings : of all samples together, after which it ends too.
    first_seed : of the first sample; the next ones follow.
    """

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
    """Samples of a configuration, in the order of their seeds.

    case : the configuration.
    samples : what each flight came to.
    """

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


class Flight(NamedTuple):
    """The key of a sample: the label of its configuration, its seed, and how many pings it may have."""

    case: str
    seed: int
    pings: int


@dataclass(frozen=True, slots=True)
class Flights:
    """Flies samples of configurations, which have labels."""

    cases: Mapping[str, Case]

    def __call__(self, key: Flight) -> Sample:
        """Fly until a collision, or all pings."""
        case, seed = self.cases[key.case], (key.seed, 0)
        silicon = Silicon(AMI_1500_IDEAL, temperature_c=case.temperature_c, die=case.die(key.seed))
        senses = senses_of(case.sensing, case.bat, silicon, seed, bias_kind=case.bias_kind)
        return fly_sample(_arcs(case.bat), planter(case.obstacles), seed, key.pings, senses=senses)[0]

    def campaign(self, name: str) -> Campaign[Flight, Sample]:
        """All of them under a name."""
        cases = (
            (label, c.bat, c.obstacles, c.sensing, c.die.__qualname__, c.temperature_c, c.bias_kind)
            for label, c in self.cases.items()
        )
        return Campaign(name, self, Flight, Sample, (version("noctule"), *cases))


@lru_cache(maxsize=2)  # samples of a configuration follow each other
def _arcs(bat: Bat) -> Arcs:
    return arcs_of(bat)


@dataclass(frozen=True, slots=True)
class Flying:
    """Configurations whose samples can be asked for, while their campaign is open."""

    cases: Mapping[str, Case]
    runs: Runs[Flight, Sample]

    def until(self, label: str, limits: Limits) -> Tally:
        """Fly samples of a configuration until the limits; more collisions lengthen what is kept."""
        samples: list[Sample] = []
        left, met = limits.pings, 0
        while met < limits.collisions and left >= GROUP:
            first = limits.first_seed + len(samples)
            flown = list(self.runs.of(Flight(label, first + k, left // GROUP) for k in range(GROUP)))
            flown = flown[: _enough([s.collided for s in flown], limits.collisions - met)]
            samples += flown
            met += sum(s.collided for s in flown)
            left -= sum(s.pings for s in flown)
        return Tally(self.cases[label], tuple(samples))


@contextmanager
def flying(execution: Execution, name: str, cases: Mapping[str, Case]) -> Iterator[Flying]:
    """Begin the campaign of a name over configurations by their labels, or go on with it."""
    with execution.open(Flights(cases).campaign(name)) as runs:
        yield Flying(cases, runs)


def fly_all(
    execution: Execution,
    name: str,
    cases: Mapping[str, Case],
    limits: Limits,
    progress: Callable[[float], object],
) -> dict[str, Tally]:
    """Fly every configuration until the limits; `progress` takes the share that is done."""
    found: dict[str, Tally] = {}
    with flying(execution, name, cases) as open_cases:
        for label in cases:
            found[label] = open_cases.until(label, limits)
            progress(len(found) / len(cases))
    return found


def mean_avoided(avoided: int, collisions: int, level: float = LEVEL) -> Estimate:
    """Avoided obstacles a collision, with the exact interval of Poisson events."""
    met = poisson_interval(collisions, level)
    interval = Interval(avoided / met.high, avoided / met.low if collisions else math.inf)
    return Estimate(avoided / collisions if collisions else math.inf, interval)


def differ_p(a: Tally, b: Tally) -> float:
    """Two-sided probability of collisions so unlike if both had the same mean; 1 where nothing was flown."""
    met, flown = a.collisions + b.collisions, a.avoided + b.avoided
    if met == 0 or flown == 0:
        return 1.0
    return float(stats.binomtest(a.collisions, met, a.avoided / flown).pvalue)


def equivalent_p(a: Tally, b: Tally, factor: float) -> float:
    """P of two one-sided tests that the means differ by a factor or more, the larger of both.

    1 where nothing was met. If the mean of `a` were so many times that of `b`, a's share of the collisions
    would be what its avoided obstacles over that factor are of those of both: exact binomial tests.
    """
    met = a.collisions + b.collisions
    if not a.avoided or not b.avoided or not met:
        return 1.0

    def one_sided(ratio: float, alternative: str) -> float:
        expected = a.avoided / ratio
        share = expected / (expected + b.avoided)
        return float(stats.binomtest(a.collisions, met, share, alternative=alternative).pvalue)

    return max(one_sided(factor, "greater"), one_sided(1.0 / factor, "less"))


def _enough(collided: Sequence[bool], wanted: int) -> int:
    """How many samples it takes to so many collisions, or all."""
    reached = [k for k, met in enumerate(accumulate(map(int, collided))) if met >= wanted]
    return reached[0] + 1 if reached else len(collided)
