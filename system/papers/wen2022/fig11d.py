"""Figure 11D of Wen & Horiuchi 2022: immediacy functions, equation (11), against speed.

Bats with the four immediacy functions of Figure 11C fly at several V_MAX, and the obstacles that they avoid a
collision are compared. The paper's statements are the rules, at each V_MAX: "Steep" (R_MAX0 = 3 m) avoids
significantly fewer (p < 0.05) than control, "Flat" and "Squared"; "Squared" has the lowest mean of the other
three. "Flat" (R_MAX0 = 7 m) is significantly worse than the control at 1.5 to 2 m/s and significantly better
above 2 m/s. The speeds are ours. The bat's numbers were chosen, on other seeds, with the claims on "Flat" at
2 to 3 m/s in view: those rows are fitted. Looked for where "Flat" is no better: with P of 0, 1, 2 and 3 its
means were within the control's noise at 3 and 4 m/s.
"""

from __future__ import annotations

from collections.abc import Sequence

from system.forest.sweep import Cases, Sweep, at_speeds, differs_row, sweep_experiment
from system.openspace.law import Bat
from system.papers.wen2022.fig11c import CONTROL, FLAT, SQUARED, STEEP, groups
from system.rule import Measured, below
from system.statement import Statement

SPEEDS = (1.0, 1.5, 1.75, 2.0, 2.5, 3.0)  # m/s; ours
WORSE, BETTER = (1.5, 2.0), 2.0  # m/s, where Flat is worse, and above which it is better; the paper's
FLAT_FITTED = (2.0, 2.5, 3.0)  # m/s


def cases(speeds: Sequence[float] = SPEEDS) -> Cases:
    """All four bats at all speeds."""
    return at_speeds(groups(Bat()), speeds)


def rows(found: Sweep) -> tuple[Statement, ...]:
    """Compare Steep with all others, Squared with the rest, and Flat with the control."""
    speeds = list(dict.fromkeys(speed for _, speed in found))
    steep = [
        differs_row(
            f"steep_against_{name.lower()}_at_{v:g}", found[STEEP, v], found[name, v], -1, name,
        )
        for v in speeds
        for name in (CONTROL, FLAT, SQUARED)
    ]  # fmt: skip
    flat = [
        differs_row(
            f"flat_at_{v:g}", found[FLAT, v], found[CONTROL, v], 1 if v > BETTER else -1, CONTROL,
            fitted=v in FLAT_FITTED,
        )
        for v in speeds
        if v > BETTER or WORSE[0] <= v <= WORSE[1]
    ]  # fmt: skip
    return (*steep, *(_second_worst(found, v) for v in speeds), *flat)


def _second_worst(found: Sweep, speed: float) -> Statement:
    means = {name: found[name, speed].mean.value for name in (CONTROL, FLAT, SQUARED)}
    lowest = min(means, key=lambda name: means[name])
    ours = Measured(means[SQUARED], f"{lowest}, {means[lowest]:.4g}")
    rule = below(min(means[CONTROL], means[FLAT]), "lowest mean of Squared, Flat and control")
    return Statement(f"second_worst_at_{speed:g}", SQUARED, ours, rule)


EXPERIMENT = sweep_experiment("wen2022-fig11d", "immediacy functions against speed", cases, rows)
