"""Figure 11A of Wen & Horiuchi 2022: avoided obstacles against the number of obstacles, 500 to 1,700.

Bats fly through forests of each density, and the avoided obstacles a collision are compared with the paper's
words: performance rises as density falls, approaching infinity. Rules: of each two neighbouring numbers
the larger has significantly fewer avoided obstacles a collision (p < 0.05); and "steeply" (ours): at 1,700 at
most a tenth of those at 500, the intervals apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

from matplotlib.figure import Figure

from system.experiment import Experiment, Progress, Report
from system.forest.campaign import COLLISIONS, Case, Limits, Tally, fly_all
from system.forest.sweep import COUNTS, NULLS, PINGS, differs_row, draw_means, line, sweep_nulls
from system.rule import Measured, apart_above, at_least
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.verdict.family import family

NUMBERS = (500, 700, 900, 1100, 1300, 1500, 1700)
STEEP = 10.0  # times; ours


def reproduce(
    progress: Progress,
    execution: Execution = ALONE,
    collisions: int = COLLISIONS,
    pings: int = PINGS,
    numbers: Sequence[int] = NUMBERS,
) -> Report:
    """Fly through forests of all densities."""
    cases = {f"{n} obstacles": Case(obstacles=n) for n in numbers}
    tallies = fly_all(execution, EXPERIMENT.name, cases, Limits(collisions, pings), progress)
    notes = tuple(f"{label}: {line(tally)}" for label, tally in tallies.items())
    found = dict(zip(numbers, tallies.values(), strict=True))
    return Report(rows(found), lambda figure: _draw(found, figure), notes, sweep_nulls(rows, found))


def rows(found: Mapping[int, Tally]) -> tuple[Statement, ...]:
    """Compare neighbouring densities, then the lowest with the highest."""
    numbers = list(found)
    falling = [
        differs_row(f"{more}_obstacles", found[more], found[fewer], -1, f"{fewer} obstacles")
        for fewer, more in pairwise(numbers)
    ]
    return family((*falling, _steep(found[numbers[0]], found[numbers[-1]])))


def _steep(few: Tally, many: Tally) -> Statement:
    # where no collision was met among few obstacles, the lower end of what they avoid has to do
    ratio = (few.mean.value if few.collisions else few.mean.interval.low) / many.mean.value
    rule = at_least(STEEP, "at least {limit:g} times") & apart_above(many.mean, "intervals apart")
    ours = Measured(ratio, ratio, few.mean.interval)
    return Statement("fewest_over_most_obstacles", None, ours, rule)


def _draw(found: Mapping[int, Tally], figure: Figure) -> None:
    ax = figure.subplots()
    draw_means([float(n) for n in found], list(found.values()), "ours", 0, ax)
    ax.set(xlabel="obstacles in 50 x 50 m", ylabel="avoided obstacles a collision")


EXPERIMENT = Experiment("wen2022-fig11a", "avoided obstacles against density", reproduce, COUNTS, NULLS)
