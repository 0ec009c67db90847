"""Figure 13 of Wen & Horiuchi 2022: flights through dense forests, steered by spikes of network or chip.

The paper: among 1,400 obstacles at 2 m/s and 10 pings a second the bat crossed the left border four times
without a collision, in the one example that it shows. Here a few forests are flown by the network and by
the nominal latency chip, with seeds from 1000 on, each until four crossings, a collision or `PINGS`; the
statement is that each of both reaches four in one of them. Their numbers were chosen on seeds below. How
they do in many forests is `latency-forests`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from system.experiment import Experiment, Progress, Report, Row
from system.openspace.law import Arcs, Bat, arcs_of
from system.openspace.map import OBSTACLES, SIDE, Forest, clearance, plant
from system.openspace.picture import draw_forest, draw_path
from system.plot import COLOURS, mark_end
from system.spiking_bat.brain import Brain, network_brain
from system.spiking_bat.chip_brain import chip_brain
from system.spiking_bat.flight import Flown, fly
from system.spiking_bat.numbers import Numbers

SEEDS = (1003, 1004, 1005)
CROSSINGS = 4  # the paper's
PINGS = 4000  # of a flight; ours
BAT = Bat(ping_rate=10.0)  # 2 m/s, as the paper's
CLEAR = 1.0  # m about a start; ours
MODELS: Mapping[str, Callable[[Arcs, Numbers], Brain]] = {"network": network_brain, "chip": chip_brain}


@dataclass(frozen=True, slots=True)
class Trip:
    """A forest and a model's flight through it."""

    model: str
    seed: int
    forest: Forest
    flown: Flown


def reproduce(progress: Progress, seeds: Sequence[int] = SEEDS, pings: int = PINGS) -> Report:
    """Fly all forests."""
    arcs, numbers = arcs_of(BAT), Numbers()
    trips = []
    for k, (model, seed) in enumerate((model, seed) for model in MODELS for seed in seeds):
        brain = MODELS[model](arcs, numbers)
        random = np.random.default_rng((seed, 0, 0))
        forest = plant(OBSTACLES, random)
        start = _start(forest, random)

        def part(done: float, before: int = k) -> None:
            progress((before + done) / (len(MODELS) * len(seeds)))

        trips.append(Trip(model, seed, forest, fly(brain, arcs, forest, start, pings, CROSSINGS, part)))
    progress(1.0)
    return Report(rows(trips), lambda figure: _draw(trips, figure), notes(trips))


def rows(trips: Sequence[Trip]) -> tuple[Row, ...]:
    """Crossings without a collision, at best, of each model."""
    made = []
    for model in MODELS:
        mine = [t.flown for t in trips if t.model == model]
        best = max((flown.laps for flown in mine if not flown.collided), default=0)
        made.append(
            Row(
                f"{model}_crossings_without_collision", float(CROSSINGS), float(best),
                "the paper's, in one forest", float(CROSSINGS), fitted=False, agrees=best >= CROSSINGS,
            )
        )  # fmt: skip
    return tuple(made)


def notes(trips: Sequence[Trip]) -> tuple[str, ...]:
    """A line a flight."""
    return tuple(
        f"{t.model}, seed {t.seed}: {t.flown.laps} crossings, {t.flown.avoided} obstacles avoided,"
        f" {t.flown.pings} pings, {t.flown.emergencies} emergencies,"
        f" {'collided' if t.flown.collided else 'no collision'}"
        for t in trips
    )


def _start(forest: Forest, random: np.random.Generator) -> tuple[float, float]:
    """A drawn place with room about it."""
    while True:
        x, y = SIDE * random.random(), SIDE * random.random()
        if clearance(forest, x, y) >= CLEAR:
            return x, y


def _draw(trips: Sequence[Trip], figure: Figure) -> None:
    """A forest and its path a panel, a model a row."""
    columns = len(trips) // len(MODELS)
    figure.set_size_inches(5.2 * columns, 5.4 * len(MODELS))
    for trip, ax in zip(trips, figure.subplots(len(MODELS), columns, squeeze=False).flat, strict=True):
        draw_forest(trip.forest.place, BAT.zone, ax)
        draw_path(trip.flown.path, ax, 0.9)
        ax.plot(*trip.flown.path[0], marker="o", color=COLOURS[2], markersize=6, linestyle="", zorder=4)
        mark_end(trip.flown.path[-1], ax, succeeded=not trip.flown.collided)
        ended = "a collision" if trip.flown.collided else "no collision"
        ax.set_title(f"{trip.model}, seed {trip.seed}: {trip.flown.laps} crossings, {ended}", fontsize=9)


EXPERIMENT = Experiment("wen2022-fig13", "flights steered by the spike-latency network and chip", reproduce)
