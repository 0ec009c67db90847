"""Crossings of the forest by latency chips on dies: area, temperature, calibration, each block's share.

No figure of a paper. Chips with several kinds of biases, areas, calibrations and temperatures fly through
forests, and their mean numbers of crossings without a collision are compared. Every forest has a die of its
own, both numbered from 1006 on, with 1,400 obstacles, 2 m/s and ten pings a second; each flight is stopped at
8 crossings, 600 s or a minute in a loop. Biases are ideal currents unless said otherwise, and dies have
mismatch and process variation. Rules, stated before the run: calibration by codes makes the mean of crossings
larger; so does 16 times the area without calibration; with fixed gates and no calibration it is smaller than
with ideal currents; each by a sign test over the forests as well, of which the three are one family.

Contributions are those of the mismatch of one block at a time, with all others nominal, the biases'
copies and no process variation: what is lost against the nominal die on the same forests.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from matplotlib.figure import Figure

from chips.latency.calibration import PARTS
from circuits.arrays import I64
from system.experiment import Experiment, Progress, Report
from system.papers.checks.latency_forests import described
from system.plot import COLOURS, sized_axes
from system.rule import Measured, significant
from system.spiking_bat.campaign import (
    Build,
    Crossed,
    Maker,
    block_builds,
    chip_maker,
    crossed,
    flights_of,
    mean_crossings,
    sign_test,
)
from system.statement import Statement
from system.study.campaign import ALONE, Execution, Numbered
from system.verdict.family import family
from system.verdict.null import Null, nulls_of, shuffled

FIRST = 1006
DIES, BLOCK_DIES = 100, 30  # of each build, and of each block's; ours

NOMINAL = "nominal die"
BUILDS: Mapping[str, Build] = {
    NOMINAL: Build(own=False),
    "ideal": Build("ideal"),
    "ideal, area 16": Build("ideal", area=16.0),
    "gate": Build("gate"),
    "ideal, calibrated": Build("ideal", PARTS),
    "gate, calibrated": Build("gate", PARTS),
    "ideal, calibrated, 10 degC": Build("ideal", PARTS, temperature_c=10.0),
    "ideal, calibrated, 44 degC": Build("ideal", PARTS, temperature_c=44.0),
    "gate, calibrated, 44 degC": Build("gate", PARTS, temperature_c=44.0),
}
# name, the build that is better, the one that is worse
RULES = (
    ("calibration_gains", "ideal, calibrated", "ideal"),
    ("area_gains", "ideal, area 16", "ideal"),
    ("ideal_over_gate", "ideal", "gate"),
)

P = 0.05  # of a sign test over forests; ours
COLLIDES, ALIKE, DRAWN = "always collides", "every build is alike", "builds drawn anew"
NULLS = (COLLIDES, ALIKE, DRAWN)

Flights = Mapping[str, Sequence[Crossed]]


def reproduce(
    progress: Progress, execution: Execution = ALONE, dies: int = DIES, block_dies: int = BLOCK_DIES
) -> Report:
    """Fly all builds, then single blocks."""
    counts = {name: dies if name in BUILDS else block_dies for name in _builds()}
    keys = [Numbered(name, FIRST + k) for name, count in counts.items() for k in range(count)]
    flights = execution.by_condition(flights_of("latency-dies", fly_one), keys, progress)
    return Report(rows(flights), lambda figure: _draw(flights, figure), notes(flights), _nulls(flights))


def _nulls(flights: Flights) -> tuple[Null, ...]:
    """Bats that collide at once, builds that fly as the nominal die, and builds that change their places."""
    names = list(BUILDS)
    nowhere: Flights = {
        name: [replace(f, laps=0, collided=True, pings=1) for f in flights[name]] for name in names
    }
    alike: Flights = dict.fromkeys(names, flights[NOMINAL])

    def drawn(order: I64) -> Flights:
        return {name: flights[names[k]] for name, k in zip(names, order, strict=True)}

    return (
        *nulls_of(rows, {COLLIDES: nowhere, ALIKE: alike}),
        shuffled(DRAWN, rows, drawn, len(names)),
    )


def fly_one(key: Numbered) -> Crossed:
    """Fly a build on the die of a number, through the forest of that seed."""
    name, number = key
    return crossed(_maker(name), number)


def _builds() -> dict[str, Build]:
    """All builds: of whole dies, and with the deviations of one block each."""
    alone = block_builds(Build("ideal", process=False))
    return {**BUILDS, **{f"only {name}": build for name, build in alone.items()}}


@lru_cache(maxsize=2)  # a build's dies follow each other
def _maker(name: str) -> Maker:
    return chip_maker(_builds()[name])


def rows(flights: Flights) -> tuple[Statement, ...]:
    """Make the statements about calibration, area and kind of bias."""
    made = []
    for name, better, worse in RULES:
        gain = mean_crossings(flights[better]) - mean_crossings(flights[worse])
        won, lost, p = sign_test(flights[better], flights[worse])
        shown = f"{gain:+.2f}, {won} forests better, {lost} worse, p {p:.2g}"
        rule = significant(1, P, f"{better} above {worse}")
        made.append(Statement(f"{name}_crossings", None, Measured(gain, shown, p=p), rule))
    return family(made)


def notes(flights: Flights) -> tuple[str, ...]:
    """Tell how far each build flew."""
    return tuple(described(name, each) for name, each in flights.items())


def _draw(flights: Flights, figure: Figure) -> None:
    """Mean crossings of each build; blocks alone in another colour."""
    ax = sized_axes(figure, 7.6, 6.0)
    names = list(flights)
    values = [mean_crossings(flights[name]) for name in names]
    colours = [COLOURS[1] if name.startswith("only") else COLOURS[0] for name in names]
    ax.barh(np.arange(len(names)), values, color=colours)
    ax.set_yticks(np.arange(len(names)), [f"{n} ({len(flights[n])})" for n in names], fontsize=8)
    ax.invert_yaxis()
    ax.set_xlabel("crossings without a collision, mean up to 8 (product limit)")


EXPERIMENT = Experiment(
    "latency-dies", "crossings by latency chips on dies", reproduce,
    {"dies": DIES, "block_dies": BLOCK_DIES}, NULLS,
)  # fmt: skip
