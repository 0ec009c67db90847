"""Loops of the latency chip's flights: whether the network repeats them from the same place.

No figure of a paper. Compared is whether network and chip stay in the same loops. The nominal chip flies
forests from seed 1006 on, until as many flights as wanted are caught in a loop
(`system.spiking_bat.circling`). From how the bat stood after the last emergency, when nothing is remembered,
the published network, integrate-and-fire neurons alone, the chip itself and the analog model fly `PINGS`
pings: what stays within 2 m all that time repeats the loop. Rule, stated before the run: the lower 95 % limit
of the share of loops that the network repeats is above one half, so that loops are the network's and not the
chip's.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from matplotlib.figure import Figure

from system.experiment import Experiment, Progress, Report
from system.openspace.flight import margin_of
from system.openspace.kernel import COLLIDED
from system.openspace.kernel import fly as fly_analog
from system.openspace.law import DIRECTIONS, Arcs, Bat, arcs_of
from system.openspace.map import Forest, cells_of
from system.openspace.picture import draw_forest, draw_path
from system.openspace.senses import EXACT
from system.openspace.state import ARC, HEAD, TIME, X, Y, new_flight
from system.papers.checks.latency_forests import FIRST_SEED
from system.rule import above
from system.spiking_bat.brain import Brain, network_brain
from system.spiking_bat.campaign import CROSSINGS, PINGS, Build, Maker, chip_maker, decided_by
from system.spiking_bat.circling import REACH, WINDOW, stays
from system.spiking_bat.flight import Flown, Standing, fly
from system.spiking_bat.lif import all_lif
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.run import place
from system.spiking_bat.scenario import Scenario
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered
from system.study.statistics.power import detectable_share
from system.study.statistics.share import share_where
from system.verdict.null import nulls_of

LOOPS = 20  # of the chip's, ours
AGAIN = 60  # pings that are flown from each
HALF = 0.5
NULLS = ("never moves", "never repeats", "tosses a coin")
NAMES = ("network", "integrate-and-fire", "chip", "analog")


@dataclass(frozen=True, slots=True)
class Search:
    """A flight of the chip: who repeats its loop, by name, None where it was caught in none."""

    repeated: dict[str, bool] | None


@dataclass(frozen=True, slots=True)
class Loop:
    """A flight that was caught in a loop, and which networks repeat it."""

    seed: int
    repeated: Mapping[str, bool]


@dataclass(frozen=True, slots=True)
class Flights:
    """Flies the chip through the forest of a seed, and a loop that it finds again, so many pings."""

    pings: int

    def __call__(self, key: Numbered) -> Search:
        """Fly once."""
        forest, flown = _flight(key.number)
        if not flown.caught or flown.turned is None:
            return Search(None)
        chip = _chip()(key.number)
        return Search(_repeated(_arcs(), Numbers(), forest, flown.turned, chip, self.pings))


def reproduce(
    progress: Progress,
    execution: Execution = ALONE,
    loops: int = LOOPS,
    first: int = FIRST_SEED,
    pings: int = AGAIN,
) -> Report:
    """Find loops, and fly them again."""
    found: list[Loop] = []
    campaign = Campaign(EXPERIMENT.name, Flights(pings), Numbered, Search, (*decided_by(), pings))
    keys = (Numbered("chip", seed) for seed in itertools.count(first))
    with closing(execution.results(campaign, keys)) as flights:
        for seed, flight in enumerate(flights, first):
            if flight.repeated is None:
                continue
            found.append(Loop(seed, flight.repeated))
            progress(len(found) / loops)
            if len(found) == loops:
                break
    notes = tuple(
        f"{name}: repeats {sum(x.repeated[name] for x in found)} of {len(found)} loops" for name in NAMES
    )
    flown = f"{found[-1].seed - first + 1} flights of the chip"
    power = (
        f"power: {len(found)} loops tell a share of {detectable_share(len(found)):.2f} from one half (80 %,"
        " two-sided 5 % as the rule)"
    )
    nulls = nulls_of(rows, _nulls(found))
    return Report(rows(found), lambda figure: _draw(found, figure), (*notes, flown, power), nulls)


def _nulls(found: Sequence[Loop]) -> dict[str, list[Loop]]:
    """Who stands stays within any reach; who flies on straight repeats nothing; a coin does so in a half."""
    random = np.random.default_rng(FIRST_SEED)
    tossed = [replace(x, repeated={name: bool(random.integers(2)) for name in NAMES}) for x in found]
    stays, leaves = (
        [replace(x, repeated=dict.fromkeys(NAMES, said)) for x in found] for said in (True, False)
    )
    return dict(zip(NULLS, (stays, leaves, tossed), strict=True))


def _flight(seed: int) -> tuple[Forest, Flown]:
    """The chip's flight through the forest of a seed."""
    forest, start = place(Scenario(seed=seed), _arcs())
    return forest, fly(_chip()(seed), _arcs(), forest, start, PINGS, CROSSINGS, patience=WINDOW)


@lru_cache(maxsize=1)
def _chip() -> Maker:
    return chip_maker(Build(own=False))


@lru_cache(maxsize=1)
def _arcs() -> Arcs:
    return arcs_of(Bat(ping_rate=1.0 / Numbers().ping_period))


def rows(found: Sequence[Loop]) -> tuple[Statement, ...]:
    """Make the statements about the share of the loops that networks repeat, by its lower limit."""
    made = []
    for name in NAMES[:2]:
        share = share_where(x.repeated[name] for x in found)
        rule = above(HALF, "above one half").beside(share)
        made.append(Statement(f"{name}_repeats_lower_limit", HALF, share.interval.low, rule))
    return tuple(made)


def _repeated(
    arcs: Arcs, numbers: Numbers, forest: Forest, standing: Standing, chip: Brain, pings: int
) -> dict[str, bool]:  # fmt: skip
    brains: dict[str, Callable[[], Brain]] = {
        NAMES[0]: lambda: network_brain(arcs, numbers),
        NAMES[1]: lambda: network_brain(arcs, numbers, all_lif),
        NAMES[2]: lambda: chip,
    }
    found = {}
    for name, make in brains.items():
        flown = fly(make(), arcs, forest, standing, pings)
        time = np.append(flown.log[:, 0], flown.time_s)
        found[name] = not flown.collided and stays(time, flown.path, flown.time_s)
    return found | {NAMES[3]: _analog_stays(arcs, forest, standing, pings)}


def _analog_stays(arcs: Arcs, forest: Forest, standing: Standing, pings: int) -> bool:
    """Whether the analog model, from the same stand on the nearest of its arcs, stays within reach."""
    flight = new_flight(*standing.place, standing.heading, DIRECTIONS, len(forest.place), 0)
    flight.counts[HEAD] = standing.head
    flight.counts[ARC] = int(np.abs(arcs.curvature - standing.curvature).argmin())
    cells, been = cells_of(forest, margin_of(arcs)), [flight.pose[[TIME, X, Y]]]
    for _ in range(pings):
        if fly_analog(arcs, EXACT, cells, flight, 1) == COLLIDED:
            return False
        been.append(flight.pose[[TIME, X, Y]])
    rows = np.array(been)
    return stays(rows[:, 0], rows[:, 1:], float(rows[-1, 0]))


def _draw(found: Sequence[Loop], figure: Figure) -> None:
    """Surroundings of the first six loops, with the last minute of each flight."""
    shown = found[:6]
    figure.set_size_inches(10.0, 7.0)
    for loop, ax in zip(shown, figure.subplots(2, 3, squeeze=False).ravel(), strict=False):
        forest, flown = _flight(loop.seed)
        draw_forest(forest.place, Bat().zone, ax)
        draw_path(flown.path, ax, 0.9)
        x, y = flown.end
        ax.set(xlim=(x - 2.0 * REACH, x + 2.0 * REACH), ylim=(y - 2.0 * REACH, y + 2.0 * REACH))
        names = [name for name in NAMES if loop.repeated[name]]
        ax.set_title(f"forest {loop.seed}: {', '.join(names) or 'nobody'}", fontsize=8)


EXPERIMENT = Experiment(
    "latency-loops", "loops of the latency chip, and who repeats them", reproduce, {"loops": LOOPS}, NULLS
)
