"""Campaigns of flights by spikes: how often a forest was crossed before a collision, and what that says.

A flight fails by a collision, or by a minute in a loop (`system.spiking_bat.circling`), which would have no
end. It is stopped at `CROSSINGS` crossings of the left border, or at `PINGS` pings (600 s at ten a second),
and counts as censored then. The share of flights that have crossed c times without a failure is the
product-limit estimate over crossings (Kaplan & Meier 1958, scipy.stats.ecdf), with its log-log interval. Two
models fly the same forests from the same starts: a pair whose flights differ names a better one, and the
pairs are a sign test; ties, both stopped among them, say nothing.

The analog model flies with its own loop, its numbers for ten pings a second, on the same first run's forest.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np

from chips.latency.calibration import PARTS, calibrated
from chips.latency.chip import LatencyChip
from chips.latency.design import Biases, Design
from chips.latency.model import BLOCKS, lumped, only, usual_biases
from chips.record import kept_record, record_digest
from circuits.arrays import F64
from circuits.catalogue import later
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.openspace.flight import margin_of
from system.openspace.kernel import COLLIDED, GOING
from system.openspace.kernel import fly as fly_analog
from system.openspace.law import DIRECTIONS, Arcs, Bat, arcs_of
from system.openspace.map import cells_of
from system.openspace.senses import EXACT
from system.openspace.state import LAP, TIME, X, Y, new_flight
from system.openspace.state import PINGS as PINGED
from system.options.noise import Noisy, silicon_noise
from system.spiking_bat.brain import Brain, network_brain
from system.spiking_bat.chip_brain import brain_with, design_of
from system.spiking_bat.circling import WINDOW, stays
from system.spiking_bat.flight import Flown, fly
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.run import place
from system.spiking_bat.scenario import Scenario
from system.study.campaign import Campaign, Numbered

stats = later("scipy.stats")

CROSSINGS, PINGS = 8, 6000  # at which a flight is stopped: the paper had four; 600 s
LEVEL = 0.95
_AT_ONCE = 10  # pings of the analog model between looks at the crossings; a crossing takes 250


@dataclass(frozen=True, slots=True)
class Crossed:
    """What became of a flight through the forest of a seed.

    laps : crossings before it ended; collided : whether it ended by a collision; caught : whether it was
    stopped in a loop, which no collision ends, and which is a failure as a collision is.

    pings : that were made.
    """

    seed: int
    laps: int
    collided: bool
    pings: int
    caught: bool = False

    @property
    def failed(self) -> bool:
        """Whether it collided, or was caught in a loop."""
        return self.collided or self.caught

    @property
    def worth(self) -> tuple[int, int]:
        """Numbers by which flights of a pair are compared: crossings, then pings.

        All flights that were stopped without a failure are equal.
        """
        return (self.laps, self.pings if self.failed else PINGS + 1)


@dataclass(frozen=True, slots=True)
class Build:
    """How a chip is made: kind of biases, calibrated parts, area, temperature and deviating blocks.

    own: a die a flight, of the forest's seed, else the nominal one; process: whether what a die shares
    varies; block: the only one whose deviations count, all unless given.

    calibration : names of the parts whose biases are calibrated on the die at 27 degC.
    temperature_c : at which the chip flies, degC.
    noisy : which noise its devices make, of the forest's seed.
    """

    kind: BiasKind = "gate"
    calibration: tuple[str, ...] = ()
    area: float = 1.0
    temperature_c: float = 27.0
    own: bool = True
    process: bool = True
    block: str | None = None
    noisy: Noisy = "off"

    def chip(self, design: Design, seed: int) -> LatencyChip:
        """The chip that flies the forest of a seed."""
        die = Die(number=seed, process=self.process) if self.own else NOMINAL
        silicon = Silicon(AMI_1500_IDEAL, temperature_c=self.temperature_c, die=die)
        biases = self._biases(design, Silicon(AMI_1500_IDEAL, die=die))
        numbers = None
        if self.block is not None:
            ideal = lumped(design, biases, Silicon(AMI_1500_IDEAL, temperature_c=self.temperature_c))
            numbers = only(lumped(design, biases, silicon, self.area), ideal, self.block)
        noise = silicon_noise(self.noisy, seed)
        return LatencyChip(design, biases, silicon, area=self.area, numbers=numbers, noise=noise)

    def _biases(self, design: Design, reference: Silicon) -> Biases:
        if not self.calibration:
            return usual_biases(design, self.kind)
        return calibrated(design, reference, self.kind, self.calibration, area=self.area)


Maker = Callable[[int], Brain]


def chip_maker(build: Build) -> Maker:
    """Return what makes the brain of a build's chip, by the seed of the forest."""
    numbers, arcs = Numbers(), _arcs()
    design = design_of(arcs, numbers)
    return lambda seed: brain_with(build.chip(design, seed), arcs, numbers)


def network_maker() -> Maker:
    """Return what makes the brain of the published network, whatever the seed."""
    return lambda _: network_brain(_arcs(), Numbers())


def crossed(make: Maker, seed: int) -> Crossed:
    """Fly the forest of a seed and return what became of the flight."""
    arcs = _arcs()
    forest, start = place(Scenario(seed=seed), arcs)
    return judged(seed, fly(make(seed), arcs, forest, start, PINGS, CROSSINGS, patience=WINDOW))


def judged(seed: int, flown: Flown) -> Crossed:
    """Return what a flight through the forest of a seed came to."""
    return Crossed(seed, flown.laps, bool(flown.collided), flown.pings, bool(flown.caught))


def crossed_by_analog(seed: int) -> Crossed:
    """Fly the forest of a seed with the analog model at ten pings a second."""
    arcs = _arcs()
    forest, start = place(Scenario(seed=seed), arcs)
    flight = new_flight(*start, -np.pi, DIRECTIONS, len(forest.place), 0)
    cells, ended = cells_of(forest, margin_of(arcs)), GOING
    been = []
    while ended == GOING and flight.counts[PINGED] < PINGS and flight.counts[LAP] < CROSSINGS:
        ended = fly_analog(arcs, EXACT, cells, flight, _AT_ONCE)
        been.append(flight.pose[[TIME, X, Y]])
    laps = min(int(flight.counts[LAP]), CROSSINGS)
    rows, collided = np.array(been), bool(ended == COLLIDED)
    loop = not collided and bool(stays(rows[:, 0], rows[:, 1:]))
    return Crossed(seed, laps, collided, int(flight.counts[PINGED]), loop)


def flights_of(name: str, one: Callable[[Numbered], Crossed]) -> Campaign[Numbered, Crossed]:
    """Return the campaign of flights by their condition and the seed of their forest."""
    return Campaign(name, one, Numbered, Crossed, decided_by())


def decided_by() -> tuple[object, ...]:
    """Return what a flight depends on besides condition and seed: numbers, and the chip's record."""
    arcs, numbers = _arcs(), Numbers()
    return (
        version("noctule"), numbers, design_of(arcs, numbers), PINGS, CROSSINGS, WINDOW,
        record_digest(kept_record("latency_chip")),
    )  # fmt: skip


def survival(flights: Sequence[Crossed]) -> tuple[F64, F64, F64, F64]:
    """Return the product-limit estimate of crossing c times.

    They are c, the share of flights, and its lower and upper limit, float64[k] each.

    A flight that collided after c crossings, or was caught in a loop, did not cross c + 1 times. Without a
    failure, and where the estimate is 0, the interval is nan. Raises `ParameterError` without flights.
    """
    if not flights:
        raise ParameterError("latency_campaign: no flight, must be one at least")
    failed = [f.laps + 1.0 for f in flights if f.failed]
    stopped = [float(f.laps) for f in flights if not f.failed]
    steps = np.arange(CROSSINGS + 1, dtype=np.float64)
    if not failed:
        return steps, np.ones(steps.size), np.full(steps.size, np.nan), np.full(steps.size, np.nan)
    right = [max(x, 0.5) for x in stopped]  # a flight without a crossing is at risk for none
    found = stats.ecdf(stats.CensoredData(uncensored=failed, right=right)).sf
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # that the interval is nan in places, as said above
        interval = found.confidence_interval(LEVEL, method="log-log")
    share, low, high = (np.asarray(s.evaluate(steps)) for s in (found, interval.low, interval.high))
    return steps, share, low, high


def mean_crossings(flights: Sequence[Crossed]) -> float:
    """Area under the product-limit curve: crossings of a flight on average, `CROSSINGS` at most."""
    return float(survival(flights)[1][1:].sum())


def sign_test(a: Sequence[Crossed], b: Sequence[Crossed]) -> tuple[int, int, float]:
    """Pairs in which a was better, b was, and the two-sided probability of that if neither is.

    Raises `ParameterError` unless both flew the same forests.
    """
    if [f.seed for f in a] != [f.seed for f in b]:
        raise ParameterError("latency_campaign: other forests, must be the same ones in the same order")
    better = sum(x.worth > y.worth for x, y in zip(a, b, strict=True))
    worse = sum(x.worth < y.worth for x, y in zip(a, b, strict=True))
    p = float(stats.binomtest(better, better + worse).pvalue) if better + worse else 1.0
    return better, worse, p


def block_builds(build: Build) -> dict[str, Build]:
    """The same build with the deviations of each block alone."""
    made = {}
    for block in BLOCKS:
        made[block] = Build(
            build.kind, build.calibration, build.area, build.temperature_c, build.own, build.process, block
        )
    return made


def _arcs() -> Arcs:
    return arcs_of(Bat(ping_rate=1.0 / Numbers().ping_period))


USUAL, CALIBRATED = Build(), Build(calibration=PARTS)
