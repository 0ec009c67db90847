"""Figure 10 of Wen & Horiuchi 2022: paths through a forest of 1,400 obstacles.

The bat flies through one forest, and which gaps between obstacles it takes is compared with the paper's
words: open areas were travelled more often, yet most of the viable paths were visited. The measure
(`system.forest.coverage`) is ours, and so is how long it is flown. In one forest (seed 50,000) the bat flies
20,000 pings at 2 m/s, some 66 minutes; after a collision or a trap it goes on from another start in the same
forest. It must take more than half of the gaps that are wide enough; half of its crossings are spread over at
least a tenth of them, so that it does not fly a few paths again and again.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.experiment import Experiment, Progress, Report
from system.forest.campaign import FIRST_SEED
from system.forest.coverage import Coverage, coverage, fine_path
from system.openspace.flight import fly_sample
from system.openspace.law import Bat, arcs_of
from system.openspace.map import OBSTACLES, Forest, plant
from system.openspace.picture import draw_forest, draw_path
from system.rule import above, at_least
from system.statement import Statement
from system.verdict.null import nulls_of

SEED, PINGS = FIRST_SEED, 20_000
MOST, SPREAD = 0.5, 0.1
NULLS = ("always through the same gap", "through gaps at random")


def reproduce(progress: Progress, pings: int = PINGS, obstacles: int = OBSTACLES) -> Report:
    """Fly through one forest."""
    bat = Bat()
    arcs = arcs_of(bat)
    # a key of its own: numpy takes keys that differ by zeros at the end for one
    forest = plant(obstacles, np.random.default_rng((SEED, 0, 0, 1)))
    paths: list[F64] = []
    left, starts = pings, 0
    while left > 0:
        first = fly_sample(arcs, lambda _: forest, (SEED, starts), left, rows=left)[1]
        paths.append(fine_path(arcs, first.log))
        left -= len(first.log)
        starts += 1
        progress(1.0 - left / pings)
    found = coverage(forest, bat.zone, paths)
    notes = (f"{pings} pings in {starts} flights; {len(found.gaps)} gaps wider than {2 * bat.zone:g} m.",)
    return Report(
        rows(found),
        lambda figure: _draw(forest, bat.zone, paths, figure),
        notes,
        nulls_of(rows, _nulls(found)),
    )


def _nulls(found: Coverage) -> dict[str, Coverage]:
    """A bat that circles, and as many crossings of gaps that are drawn anew each time."""
    gaps, crossings = sorted(found.gaps), sum(found.taken.values())
    drawn = np.random.default_rng(SEED).integers(0, len(gaps), crossings).tolist()
    at_random = Coverage(found.gaps, dict(Counter(gaps[k] for k in drawn)))
    return dict(zip(NULLS, (Coverage(found.gaps, {gaps[0]: crossings}), at_random), strict=True))


def rows(found: Coverage) -> tuple[Statement, ...]:
    """Make the statements about how many gaps were taken, and how evenly."""
    return (
        Statement("gaps_taken_share", "most", found.share, above(MOST, "more than {limit:g}")),
        Statement("gaps_of_half_the_crossings_share", "not a few", found.busiest, at_least(SPREAD)),
    )


def _draw(forest: Forest, zone: float, paths: list[F64], figure: Figure) -> None:
    figure.set_size_inches(9.6, 5.0)
    for ax, shown in zip(figure.subplots(1, 2), ([], paths), strict=True):
        draw_forest(forest.place, zone, ax)
        for path in shown:
            draw_path(path, ax, 0.4)
    handles, labels = ax.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    figure.legend(list(once.values()), list(once), loc="outside lower center", ncols=2, fontsize=8)


EXPERIMENT = Experiment(
    "wen2022-fig10", "paths through a dense forest: most of the gaps are taken", reproduce, nulls=NULLS
)
