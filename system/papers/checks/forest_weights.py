"""Forest with weights that depend on the speed setting, beside fixed ones (suggested by Wen & Horiuchi 2022).

The weights are those of `system.forest.weights`, chosen on seeds below 1000. Rules: at each V_MAX where they
differ from the fixed ones the bat avoids significantly more (p < 0.05). No figure of the paper.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from matplotlib.figure import Figure

from system.experiment import Experiment, Progress, Report, Row
from system.forest.campaign import Case, Limits, Tally, fly_case
from system.forest.sweep import LIMITS, Sweep, differs_row, draw_sweep, lines
from system.forest.weights import weighted
from system.openspace.law import Bat

SPEEDS = (1.0, 1.25, 1.5, 2.0, 3.0, 4.0)  # m/s; ours
FIXED, BY_SPEED = "fixed weights", "weights by speed"


def reproduce(progress: Progress, speeds: Sequence[float] = SPEEDS, limits: Limits = LIMITS) -> Report:
    """Fly both at all speeds."""
    found: dict[tuple[str, float], Tally] = {}
    for name, weights in ((FIXED, "fixed"), (BY_SPEED, "speed")):
        for v in speeds:
            bat = weighted(replace(Bat(), max_speed=v), weights)
            found[name, v] = fly_case(Case(bat), limits)
            progress(len(found) / (2 * len(speeds)))
    return Report(rows(found), lambda figure: _draw(found, figure), lines(found))


def rows(found: Sweep) -> tuple[Row, ...]:
    """A row a speed at which the two bats are not the same."""
    speeds = list(dict.fromkeys(v for _, v in found))
    return tuple(
        differs_row(f"by_speed_at_{v:g}", found[BY_SPEED, v], found[FIXED, v], 1, FIXED)
        for v in speeds
        if found[BY_SPEED, v].case != found[FIXED, v].case
    )


def _draw(found: Sweep, figure: Figure) -> None:
    ax = figure.subplots()
    draw_sweep(found, ax)
    ax.legend()


EXPERIMENT = Experiment("forest-weights", "weights by speed against fixed ones", reproduce)
