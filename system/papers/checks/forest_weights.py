"""Forest with weights that depend on the speed setting, beside fixed ones (suggested by Wen & Horiuchi 2022).

No figure of the paper. A bat with fixed weights and one with the weights of `system.forest.weights`, which
were chosen on seeds below 1000, fly at several V_MAX, and the obstacles that they avoid a collision are
compared. The rule is that the bat avoids significantly more (p < 0.05) at each V_MAX where the weights
differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from system.forest.campaign import Case
from system.forest.sweep import Cases, Sweep, differs_row, sweep_experiment
from system.forest.weights import weighted
from system.openspace.law import Bat
from system.statement import Statement

SPEEDS = (1.0, 1.25, 1.5, 2.0, 3.0, 4.0)  # m/s; ours
FIXED, BY_SPEED = "fixed weights", "weights by speed"


def cases(speeds: Sequence[float] = SPEEDS) -> Cases:
    """Both bats at all speeds."""
    return {
        (name, v): Case(weighted(replace(Bat(), max_speed=v), weights))
        for name, weights in ((FIXED, "fixed"), (BY_SPEED, "speed"))
        for v in speeds
    }


def rows(found: Sweep) -> tuple[Statement, ...]:
    """Compare the two bats at each speed at which they are not the same."""
    speeds = list(dict.fromkeys(v for _, v in found))
    return tuple(
        differs_row(f"by_speed_at_{v:g}", found[BY_SPEED, v], found[FIXED, v], 1, FIXED)
        for v in speeds
        if found[BY_SPEED, v].case != found[FIXED, v].case
    )


EXPERIMENT = sweep_experiment("forest-weights", "weights by speed against fixed ones", cases, rows)
