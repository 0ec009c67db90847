"""Figure 11D of Wen & Horiuchi 2022: immediacy functions, equation (11), against speed.

Rules, at each V_MAX: "Steep" (R_MAX0 = 3 m) avoids significantly fewer (p < 0.05) than control, "Flat" and
"Squared"; "Squared" has the lowest mean of the other three. "Flat" (R_MAX0 = 7 m) is significantly worse than
the control at 1.5 to 2 m/s and significantly better above 2 m/s. The speeds are ours. The bat's numbers were
chosen, on other seeds, with the claims on "Flat" at 2 to 3 m/s in view: those rows are fitted. Looked for
where "Flat" is no better: with P of 0, 1, 2 and 3 its means were within the control's noise at 3 and 4 m/s.
"""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from system.experiment import Experiment, Progress, Report
from system.forest.campaign import COLLISIONS, Limits
from system.forest.sweep import COUNTS, PINGS, Sweep, at_speeds, differs_row, draw_sweep, fly_sweep, lines
from system.openspace.law import Bat
from system.papers.wen2022.fig11c import CONTROL, FLAT, SQUARED, STEEP, groups
from system.rule import Measured, below
from system.statement import Statement
from system.study.campaign import ALONE, Execution

SPEEDS = (1.0, 1.5, 1.75, 2.0, 2.5, 3.0)  # m/s; ours
WORSE, BETTER = (1.5, 2.0), 2.0  # m/s, where Flat is worse, and above which it is better; the paper's
FLAT_FITTED = (2.0, 2.5, 3.0)  # m/s


def reproduce(
    progress: Progress,
    execution: Execution = ALONE,
    collisions: int = COLLISIONS,
    pings: int = PINGS,
    speeds: Sequence[float] = SPEEDS,
) -> Report:
    """Fly all four bats at all speeds."""
    cases = at_speeds(groups(Bat()), speeds)
    found = fly_sweep(execution, EXPERIMENT.name, cases, Limits(collisions, pings), progress)
    return Report(rows(found), lambda figure: _draw(found, figure), lines(found))


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


def _draw(found: Sweep, figure: Figure) -> None:
    ax = figure.subplots()
    draw_sweep(found, ax)
    ax.legend()


EXPERIMENT = Experiment("wen2022-fig11d", "immediacy functions against speed", reproduce, COUNTS)
