"""Section 3.5 and Figure 12 of Milde et al. 2017: same start, other ways round a pair of blocks.

The paper shows three trials of one chip with the same parameters that part: "the robot might avoid the two
obstacles on the right, or on the left side"; it names mismatch, the sensor's noise and its dependence on the
movement. Here the robot drives towards a pair on one die with other noise, of the sensor alone, of the chip's
devices alone, and of both, for some dies; and on other dies with the same noise of the sensor. Compared is on
which side it passes. Rules (ours): over all dies each side is taken in
at least 5 % of the runs past the pair, and on some die with other noise both sides are.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from circuits.silicon.die import Die
from system.experiment import Experiment, Progress, Report
from system.papers.conditions import IDEAL_CURRENTS
from system.papers.milde2017.null import ROBOTS, always, runs_of
from system.plot import COLOURS, PALE, sized_axes
from system.pushbot.campaign import FIRST, Drive, Summary, drive_cells, summaries_of
from system.pushbot.scenario import Scenario
from system.rule import at_least, between
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.study.statistics.share import Share, share_where
from system.verdict.null import nulls_of

REPEATS = 10  # runs of a die and a noise, each with a seed of its own
REPEATED = 4  # dies that are repeated
OTHERS = 30  # dies with the same noise
LEAST = 0.05  # of either side

COIN = "tosses a coin"
ALWAYS = {**ROBOTS, "always goes left": always(passed=1.0)}
NULLS = (*ALWAYS, COIN)

Groups = Mapping[str, Sequence[Summary]]

# noise that differs from run to run: fields of the scenario by a seed
NOISES: Mapping[str, Callable[[int], dict[str, Any]]] = {
    "sensor": lambda seed: {"seed": seed},
    "silicon": lambda seed: {"seed": FIRST, "silicon_noise": "all", "noise_seed": seed},
    "both": lambda seed: {"seed": seed, "silicon_noise": "all"},
}


def reproduce(
    progress: Progress, execution: Execution = ALONE, repeats: int = REPEATS, repeated: int = REPEATED,
    others: int = OTHERS,
) -> Report:  # fmt: skip
    """Drive the same die with other noise, and other dies with the same noise."""
    asked, planned = _cells(repeats, repeated, others), _cells(REPEATS, REPEATED, OTHERS)
    groups = summaries_of(drive_cells(execution, EXPERIMENT.name, asked, planned, progress))
    nulls = {**runs_of(ALWAYS, groups), COIN: _tossed(groups)}
    return Report(rows(groups), lambda figure: _draw(groups, figure), notes(groups), nulls_of(rows, nulls))


def _tossed(groups: Groups) -> Groups:
    """A side at random in every run."""
    random = np.random.default_rng(FIRST)
    return {
        name: [run | {"passed": random.choice((-1.0, 1.0))} for run in runs] for name, runs in groups.items()
    }


def _cells(repeats: int, repeated: int, others: int) -> dict[str, list[Drive]]:
    base = Scenario(scene="pair", silicon_noise="off", **IDEAL_CURRENTS)
    cells: dict[str, list[Drive]] = {}
    for d in range(repeated):
        on_die = replace(base, die=Die(number=FIRST + d))
        for name, fields in NOISES.items():
            cells[f"die {FIRST + d}, {name}"] = [
                Drive(replace(on_die, **fields(FIRST + k))) for k in range(repeats)
            ]
    cells["other dies"] = [Drive(replace(base, die=Die(number=FIRST + d), seed=FIRST)) for d in range(others)]
    return cells


def left_of(found: Sequence[Summary]) -> Share:
    """Count the runs past the pair on the left, of all that got past it."""
    past = [s for s in found if s["passed"] is not None]
    return share_where(s["passed"] == 1.0 for s in past)


def rows(groups: Groups) -> tuple[Statement, ...]:
    """Make the statements about the sides taken over dies, and on one die."""
    others = left_of(groups["other dies"])
    apart = [name for name, found in groups.items() if name != "other dies" and _both(left_of(found))]
    mixed = {name.partition(",")[0] for name in apart}
    return (
        Statement("other_dies_passed_left", "left or right", others.measured(), between(LEAST, 1.0 - LEAST)),
        Statement("dies_that_take_both_sides", "its die does", float(len(mixed)), at_least(1.0)),
    )


def _both(share: Share) -> bool:
    return 0 < share.passed < share.of


def notes(groups: Groups) -> tuple[str, ...]:
    """Tell the share on the left in each group."""
    return tuple(
        f"{name}: past on the left {left_of(found)}, not past {len(found) - left_of(found).of}"
        for name, found in groups.items()
    )


def _draw(groups: Groups, figure: Figure) -> None:
    ax = sized_axes(figure, 6.4, 1.2 + 0.3 * len(groups))
    for row, found in enumerate(groups.values()):
        left = left_of(found)
        counts = (left.passed, left.of - left.passed, len(found) - left.of)
        begin = 0
        for count, shade in zip(counts, (COLOURS[1], COLOURS[0], PALE), strict=True):
            ax.barh(row, count, left=begin, color=shade)
            begin += count
    ax.set_yticks(range(len(groups)), list(groups))
    ax.set_xlabel("runs: left (orange), right (blue), not past (grey)")


EXPERIMENT = Experiment(
    "milde2017-variability", "sides taken by one die and by other dies", reproduce,
    {"repeats": REPEATS, "repeated": REPEATED, "others": OTHERS}, NULLS,
)  # fmt: skip
