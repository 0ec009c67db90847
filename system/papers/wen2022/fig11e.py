"""Figure 11E of Wen & Horiuchi 2022: ping rates of 5, 10 and 20 Hz against speed.

Bats with the three ping rates fly at several V_MAX, and the obstacles that they avoid a collision are
compared. Rules: at each V_MAX the higher rate avoids significantly more (p < 0.05) than the next lower one;
and the decline (ours: the ratio of the means at the lowest and the highest speed) is smaller at the higher
rate. The speeds are ours. A ratio whose lower speed met no collision takes the lower end of its interval,
which makes the decline at a high rate look smaller: such a row says so. That decay and recency count time
steps was chosen with all rates at 1.5, 3 and 6 m/s in view, on other seeds: those rows are fitted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from system.forest.campaign import Tally
from system.forest.sweep import Cases, Sweep, at_speeds, differs_row, sweep_experiment
from system.openspace.law import Bat
from system.rule import Measured, below
from system.statement import Statement

SPEEDS = (1.5, 2.0, 3.0, 4.0, 6.0)  # m/s; ours
RATES = (5.0, 10.0, 20.0)  # Hz, the paper's
FITTED = (1.5, 3.0, 6.0)  # m/s


def cases(speeds: Sequence[float] = SPEEDS, rates: Sequence[float] = RATES) -> Cases:
    """All rates at all speeds."""
    return at_speeds({f"{rate:g} Hz": Bat(ping_rate=rate) for rate in rates}, speeds)


def rows(found: Sweep) -> tuple[Statement, ...]:
    """Compare each rate with the next lower one."""
    names = list(dict.fromkeys(name for name, _ in found))
    speeds = list(dict.fromkeys(speed for _, speed in found))
    higher = [
        differs_row(f"{b.replace(' ', '_')}_at_{v:g}", found[b, v], found[a, v], 1, a, fitted=v in FITTED)
        for a, b in pairwise(names)
        for v in speeds
    ]
    slow, fast = min(speeds), max(speeds)
    slower = [_decline_row(found, a, b, slow, fast) for a, b in pairwise(names)]
    return (*higher, *slower)


def _decline_row(found: Sweep, lower: str, higher: str, slow: float, fast: float) -> Statement:
    ratios = [_decline(found[name, slow], found[name, fast]) for name in (lower, higher)]
    unsure = "; at least, without collisions" if not found[higher, slow].collisions else ""
    ours = Measured(
        math.nan if unsure else ratios[1], f"{ratios[1]:.4g} times against {ratios[0]:.4g}{unsure}"
    )
    text = f"mean at {slow:g} m/s over that at {fast:g} m/s below that of {lower}, {{limit:.4g}}"
    return Statement(
        f"decline_{higher.replace(' ', '_')}", "slower", ours, below(ratios[0], text), fitted=True
    )


def _decline(slow: Tally, fast: Tally) -> float:
    first = slow.mean.value if slow.collisions else slow.mean.interval.low
    return first / fast.mean.value


EXPERIMENT = sweep_experiment("wen2022-fig11e", "ping rates against speed", cases, rows)
