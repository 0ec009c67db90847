"""Table 1 of Milde et al. 2017: distance at the obstacle line by speed and turn factor and by colour.

The robot drives towards a block 1 m straight ahead, 20 trials a cell of the table on 10 dies with noise of
their own, and mean distances and collisions are compared with the paper's. A trial that touches
something counts 0, as in the paper; one that does not pass the line in time has no distance and is counted.
Rules were written before the dies and seeds that report were run. Biases were chosen on others with the blue
and red rows in view, and how bright yellow is with its own: all are marked as fitted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot, inf, isfinite

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import norm

from system.experiment import Experiment, Progress, Report
from system.papers.conditions import IDEAL_CURRENTS
from system.papers.milde2017.null import ROBOTS, runs_of
from system.papers.milde2017.picture import SHADES
from system.plot import INK, sized_axes
from system.pushbot.campaign import (
    Drive,
    Runs,
    Summary,
    drive_repeats,
    mean_sd,
    share_of,
    standard_error,
    summaries_of,
)
from system.pushbot.scenario import Scenario
from system.rule import Measured, above, at_least, at_most, significant, within
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.study.statistics.share import Share
from system.verdict.family import family
from system.verdict.null import nulls_of

CELLS = ((0.1, 0.5), (0.5, 0.5), (1.0, 0.5), (1.0, 1.0), (1.5, 1.0), (2.0, 1.0), (3.0, 1.0))
TRIALS, DIES = 20, 10
PAPER_TRIALS = 3
CONSTANT = "one answer a colour"
NULLS = (*ROBOTS, CONSTANT)
PAPER: Mapping[str, tuple[float, ...]] = {  # cm, means of three trials; 0 where all collided
    "blue": (7.0, 10.3, 7.7, 19.3, 16.3, 10.8, 0.0),
    "red": (0.0, 2.3, 4.7, 10.7, 9.7, 5.0, 0.0),
    "yellow": (0.0, 0.0, 0.0, 7.0, 0.0, 0.0, 0.0),
}
FEW, MOST = 0.1, 0.5  # share of collisions that counts as avoided, and from which on as colliding; ours
P = 0.05  # of a difference of two means, in their standard errors; ours
ERRORS = 2.0  # standard errors by which a cell may be behind the best one; ours
CLOSE = 5.0  # cm, or half of the paper's distance, within which a cell is told to agree; ours


@dataclass(frozen=True, slots=True)
class Cell:
    """A colour at factors: distance (cm), its sigma, of how many, and collisions."""

    colour: str
    factors: tuple[float, float]
    distance: float
    sigma: float
    count: int
    collided: Share

    @property
    def error(self) -> float:
        """Standard error of the distance."""
        return standard_error(self.sigma, self.count)

    @property
    def label(self) -> str:
        """As `blue_1/0.5`."""
        return f"{self.colour}_{self.factors[0]:g}/{self.factors[1]:g}"


Cells = Mapping[tuple[str, tuple[float, float]], Cell]
Found = Mapping[tuple[str, tuple[float, float]], Sequence[Summary]]


def reproduce(
    progress: Progress, execution: Execution = ALONE, count: int = TRIALS, dies: int = DIES,
    colours: Sequence[str] = tuple(PAPER),
) -> Report:  # fmt: skip
    """Drive every trial of every colour and pair of factors."""
    drives = {
        (colour, (speed, turn)): Drive(
            Scenario(
                colour=colour, speed_factor=speed, turn_factor=turn, silicon_noise="off", **IDEAL_CURRENTS
            )
        )
        for colour in colours
        for speed, turn in CELLS
    }
    asked, usual = Runs(count, dies), Runs(TRIALS, DIES)
    driven = drive_repeats(execution, EXPERIMENT.name, drives, asked, usual, progress)
    found = summaries_of(driven)
    cells = cells_of(found)
    nulls = {name: cells_of(runs) for name, runs in _nulls(found).items()}
    paper = cells_of({key: list(map(_answer, _papers(*key))) for key in drives})
    return Report(
        rows(cells), lambda figure: _draw(cells, figure), notes(cells), nulls_of(rows, nulls), rows(paper)
    )


def _nulls(found: Found) -> dict[str, Found]:
    """Robots that sense nothing, and one distance a colour: the mean of the paper's, or that all collide."""
    constant = {key: [_answer(_constant(key[0]))] * len(runs) for key, runs in found.items()}
    return {**runs_of(ROBOTS, found), CONSTANT: constant}


def _constant(colour: str) -> float:
    """The mean of a colour's distances, cm; 0 where most of them are."""
    distances = PAPER[colour]
    return float(np.mean(distances)) if 2 * distances.count(0.0) < len(distances) else 0.0


def _papers(colour: str, factors: tuple[float, float]) -> list[float]:
    """The paper's mean of three trials, as often."""
    return [PAPER[colour][CELLS.index(factors)]] * PAPER_TRIALS


def _answer(distance: float) -> Summary:
    """A run that passes at a distance, cm, or collides at none."""
    return {"distance_cm": distance, "collided": float(distance == 0.0), "crossed": float(distance > 0.0)}


def cells_of(found: Found) -> Cells:
    """Sum up the runs of every cell."""
    return {key: _cell(*key, runs) for key, runs in found.items()}


def _cell(colour: str, factors: tuple[float, float], found: Sequence[Summary]) -> Cell:
    mean, sigma, count = mean_sd(found, "distance_cm")
    return Cell(colour, factors, mean, sigma, count, share_of(found, "collided"))


def rows(cells: Cells) -> tuple[Statement, ...]:
    """Make the paper's statements, then those about its distances."""
    blue = [cells["blue", f] for f in CELLS]
    found = [
        Statement(f"{c.label}_collided", "none", c.collided.measured(), at_most(FEW), fitted=True)
        for c in blue[:-1]
    ]
    last = blue[-1].collided.measured()
    found.append(Statement("blue_3/1_collided", "all", last, at_least(MOST), fitted=True))
    for colour in ("blue", "red"):
        if (colour, CELLS[0]) in cells:
            of = {f: cells[colour, f] for f in CELLS}
            found.append(_further(f"{colour}_turn_1_over_0.5", of[1.0, 1.0], of[1.0, 0.5]))
            found.append(_best(f"{colour}_farthest", CELLS, of, (1.0, 1.0)))
            best = (0.5, 0.5) if colour == "blue" else (1.0, 0.5)
            found.append(_best(f"{colour}_farthest_at_turn_0.5", CELLS[:3], of, best))
            found.append(_further(f"{colour}_0.1_drops", of[0.5, 0.5], of[0.1, 0.5]))
    if ("red", CELLS[0]) in cells:
        nearer = sum(cells["red", f].distance < cells["blue", f].distance for f in CELLS[:-1])
        rule = at_least(5.0, f"at least {{limit:g}} of {len(CELLS) - 1}")
        found.append(Statement("cells_with_red_nearer_than_blue", 6.0, float(nearer), rule, fitted=True))
    if ("yellow", CELLS[0]) in cells:
        of_yellow = [cells["yellow", f].collided for f in CELLS]
        share = Share(sum(s.passed for s in of_yellow), sum(s.of for s in of_yellow))
        found.append(Statement("yellow_collided", "mostly", share.measured(), above(MOST), fitted=True))
    return family((*found, *(_distance(cell) for cell in cells.values())))


def _further(name: str, more: Cell, less: Cell) -> Statement:
    """A distance that is larger than another, in standard errors of their difference."""
    apart = more.distance - less.distance
    error = hypot(more.error, less.error)
    p = float(2.0 * norm.sf(abs(_in_errors(apart, error))))
    ours = Measured(apart, f"{apart:+.1f} +- {error:.1f}, p {p:.2g}", p=p)
    return Statement(f"{name}_cm", "larger", ours, significant(1, P, "above the other"), fitted=True)


def _best(
    name: str, among: Sequence[tuple[float, float]], of: Mapping[tuple[float, float], Cell],
    best: tuple[float, float],
) -> Statement:  # fmt: skip
    """Which cell has the largest distance; as good as it is one within two standard errors."""
    top = max(among, key=lambda f: of[f].distance if isfinite(of[f].distance) else -1.0)
    behind = of[top].distance - of[best].distance
    ours = Measured(_in_errors(behind, hypot(of[top].error, of[best].error)), f"{top[0]:g}/{top[1]:g}")
    rule = within(ERRORS, "the paper's within {limit:g} standard errors", of=0.0)
    return Statement(name, f"{best[0]:g}/{best[1]:g}", ours, rule, fitted=True)


def _in_errors(apart: float, error: float) -> float:
    """A difference in standard errors, infinite where the error is none."""
    return apart / error if error else inf * apart if apart else 0.0


def _distance(cell: Cell) -> Statement:
    """A cell beside the paper's."""
    paper = PAPER[cell.colour][CELLS.index(cell.factors)]
    near = max(CLOSE, 0.5 * paper)
    rule = within(near, "within {limit:g} cm")
    return Statement(f"{cell.label}_cm", paper, cell.distance, rule, fitted=True)


def notes(cells: Cells) -> tuple[str, ...]:
    """Tell every cell with its spread, its collisions, and the trials that did not get past the line."""
    return tuple(
        f"{c.label}: {c.distance:.1f} +- {c.sigma:.1f} cm, collided {c.collided}, not past it"
        f" {c.collided.of - c.count}"
        for c in cells.values()
    )


def _draw(cells: Cells, figure: Figure) -> None:
    ax = sized_axes(figure, 7.2, 4.2)
    colours = list(dict.fromkeys(colour for colour, _ in cells))
    for k, colour in enumerate(colours):
        mine = [cells[colour, f] for f in CELLS]
        x = [i + 0.22 * (k - 1) for i in range(len(CELLS))]
        ax.errorbar(
            x, [c.distance for c in mine], [c.sigma for c in mine], color=SHADES[colour], marker="o",
            linestyle="", markersize=4, capsize=2, label=f"{colour}, ours",
        )  # fmt: skip
        ax.plot(x, PAPER[colour], color=SHADES[colour], marker="_", markersize=12, linestyle="",
                label=f"{colour}, paper")  # fmt: skip
    ax.set_xticks(range(len(CELLS)), [f"{s:g}/{t:g}" for s, t in CELLS])
    ax.set(xlabel="speed factor / turn factor", ylabel="distance at the line (cm)")
    ax.axhline(0.0, color=INK, linewidth=0.5)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=3, fontsize=8)


EXPERIMENT = Experiment(
    "milde2017-table1", "distance at the obstacle line by speed, turn factor and colour", reproduce,
    {"count": TRIALS, "dies": DIES}, NULLS,
)  # fmt: skip
