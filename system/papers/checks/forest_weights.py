"""Forest with weights that depend on the speed setting, beside fixed ones (suggested by Wen & Horiuchi 2022).

The weights are those of `system.forest.weights`, chosen on seeds below 1000. Rules: at each V_MAX where they
differ from the fixed ones the bat avoids significantly more (p < 0.05). No figure of the paper.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from matplotlib.figure import Figure

from system.experiment import Experiment, Progress, Report
from system.forest.campaign import COLLISIONS, Case, Limits
from system.forest.sweep import COUNTS, PINGS, Sweep, differs_row, draw_sweep, fly_sweep, lines
from system.forest.weights import weighted
from system.openspace.law import Bat
from system.statement import Statement
from system.study.campaign import ALONE, Execution

SPEEDS = (1.0, 1.25, 1.5, 2.0, 3.0, 4.0)  # m/s; ours
FIXED, BY_SPEED = "fixed weights", "weights by speed"


def reproduce(
    progress: Progress,
    execution: Execution = ALONE,
    collisions: int = COLLISIONS,
    pings: int = PINGS,
    speeds: Sequence[float] = SPEEDS,
) -> Report:
    """Fly both bats at all speeds."""
    cases = {
        (name, v): Case(weighted(replace(Bat(), max_speed=v), weights))
        for name, weights in ((FIXED, "fixed"), (BY_SPEED, "speed"))
        for v in speeds
    }
    found = fly_sweep(execution, EXPERIMENT.name, cases, Limits(collisions, pings), progress)
    return Report(rows(found), lambda figure: _draw(found, figure), lines(found))


def rows(found: Sweep) -> tuple[Statement, ...]:
    """Compare the two bats at each speed at which they are not the same."""
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


EXPERIMENT = Experiment("forest-weights", "weights by speed against fixed ones", reproduce, COUNTS)
