"""Figure 13 of Wen & Horiuchi 2022: flights through dense forests, steered by spikes of network or chip.

The paper: among 1,400 obstacles at 2 m/s and 10 pings a second the bat crossed the left border four times
without a collision, in the one example that it shows. Here a few forests are flown by the network and by
the nominal latency chip, with seeds from 1000 on, each until four crossings, a collision or `PINGS`; the
statement is that each of both reaches four in one of them. Their numbers were chosen on seeds below. How
they do in many forests is `latency-forests`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from system.experiment import Experiment, Progress, Report
from system.openspace.law import Arcs, Bat, arcs_of
from system.openspace.map import OBSTACLES, SIDE, Forest, clearance, plant
from system.openspace.picture import draw_forest, draw_path
from system.plot import COLOURS, mark_end
from system.rule import at_least
from system.spiking_bat.brain import Brain, network_brain
from system.spiking_bat.campaign import decided_by
from system.spiking_bat.chip_brain import chip_brain
from system.spiking_bat.flight import fly
from system.spiking_bat.numbers import Numbers
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered
from system.verdict.null import nulls_of

FIRST_SEED, FORESTS = 1003, 3
CROSSINGS = 4  # the paper's
PINGS = 4000  # of a flight; ours
BAT = Bat(ping_rate=10.0)  # 2 m/s, as the paper's
CLEAR = 1.0  # m about a start; ours
NULLS = ("always collides", "never moves")
MODELS: Mapping[str, Callable[[Arcs, Numbers], Brain]] = {"network": network_brain, "chip": chip_brain}


@dataclass(frozen=True, slots=True)
class Trip:
    """A flight: what was counted, whether it ended by a collision, and its path, m."""

    laps: int
    avoided: int
    pings: int
    emergencies: int
    collided: bool
    path: tuple[tuple[float, float], ...]


Trips = Mapping[str, Sequence[Trip]]  # by model, in the order of the seeds


@dataclass(frozen=True, slots=True)
class Flights:
    """Flies a model through the forest of a seed, so many pings at most."""

    pings: int

    def __call__(self, key: Numbered) -> Trip:
        """Fly once."""
        arcs, (forest, start) = arcs_of(BAT), _planted(key.number)
        flown = fly(MODELS[key.condition](arcs, Numbers()), arcs, forest, start, self.pings, CROSSINGS)
        path = tuple((x, y) for x, y in flown.path.tolist())
        return Trip(flown.laps, flown.avoided, flown.pings, flown.emergencies, bool(flown.collided), path)


def reproduce(
    progress: Progress,
    execution: Execution = ALONE,
    forests: int = FORESTS,
    first: int = FIRST_SEED,
    pings: int = PINGS,
) -> Report:
    """Fly all forests."""
    keys = [Numbered(model, first + k) for model in MODELS for k in range(forests)]
    numbers = (*decided_by(), BAT, CROSSINGS, pings)
    campaign = Campaign(EXPERIMENT.name, Flights(pings), Numbered, Trip, numbers)
    trips = execution.by_condition(campaign, keys, progress)
    nulls = nulls_of(rows, {name: _nowhere(trips, collided=k == 0) for k, name in enumerate(NULLS)})
    return Report(rows(trips), lambda figure: _draw(trips, first, figure), notes(trips, first), nulls)


def _nowhere(trips: Trips, *, collided: bool) -> Trips:
    """Flights that come to no border."""
    return {model: [replace(t, laps=0, collided=collided) for t in each] for model, each in trips.items()}


def rows(trips: Trips) -> tuple[Statement, ...]:
    """Crossings without a collision, at best, of each model."""
    made = []
    for model in MODELS:
        best = max((t.laps for t in trips[model] if not t.collided), default=0)
        made.append(
            Statement(
                f"{model}_crossings_without_collision",
                float(CROSSINGS),
                float(best),
                at_least(float(CROSSINGS), "at least the paper's, in one forest"),
            )
        )
    return tuple(made)


def notes(trips: Trips, first: int) -> tuple[str, ...]:
    """A line a flight."""
    return tuple(
        f"{model}, seed {seed}: {t.laps} crossings, {t.avoided} obstacles avoided,"
        f" {t.pings} pings, {t.emergencies} emergencies,"
        f" {'collided' if t.collided else 'no collision'}"
        for model, each in trips.items()
        for seed, t in enumerate(each, first)
    )


def _planted(seed: int) -> tuple[Forest, tuple[float, float]]:
    """The forest of a seed, and a drawn place with room about it."""
    random = np.random.default_rng((seed, 0, 0))
    forest = plant(OBSTACLES, random)
    while True:
        x, y = SIDE * random.random(), SIDE * random.random()
        if clearance(forest, x, y) >= CLEAR:
            return forest, (x, y)


def _draw(trips: Trips, first: int, figure: Figure) -> None:
    """A forest and its path a panel, a model a row."""
    columns = len(trips["chip"])
    figure.set_size_inches(5.2 * columns, 5.4 * len(MODELS))
    axes = figure.subplots(len(MODELS), columns, squeeze=False)
    for line, (model, each) in zip(axes, trips.items(), strict=True):
        for seed, (trip, ax) in enumerate(zip(each, line, strict=True), first):
            path = np.array(trip.path)
            draw_forest(_planted(seed)[0].place, BAT.zone, ax)
            draw_path(path, ax, 0.9)
            ax.plot(*path[0], marker="o", color=COLOURS[2], markersize=6, linestyle="", zorder=4)
            mark_end(path[-1], ax, succeeded=not trip.collided)
            ended = "a collision" if trip.collided else "no collision"
            ax.set_title(f"{model}, seed {seed}: {trip.laps} crossings, {ended}", fontsize=9)


EXPERIMENT = Experiment(
    "wen2022-fig13", "flights steered by the spike-latency network and chip", reproduce, {"forests": FORESTS},
    NULLS,
)  # fmt: skip
