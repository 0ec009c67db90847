"""Section 3.2 and Figure 8 of Milde et al. 2017: two and three blocks, at speed factor 0.5.

The robot drives towards two and three blocks, and its collisions and its ways around them are compared with
the paper's words: each configuration was "tested twenty times without crashes", and the robot "tends to go
around a pair of objects, avoiding the space between them". It gives no distances. Ours are pair and triple
with 20 cm between any two blocks, and a loose triple with 27 cm, in a row of 50 cm, whose gaps a robot of 10
cm fits through. Rules: at least 95 % of 100 runs each without touching anything; of the runs past a pair or a
triple at most 5 % between its outer blocks. Between those of the loose one it may pass. There are 25 dies,
and every run has noise of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.experiment import Experiment, Progress, Report
from system.papers.conditions import IDEAL_CURRENTS
from system.papers.milde2017.null import COLLIDES, ROBOTS, always, runs_of
from system.papers.milde2017.picture import draw_paths
from system.pushbot.campaign import Drive, Runs, Summary, drive_repeats, share_of, summaries_of
from system.pushbot.scenario import Scenario
from system.rule import at_least, at_most
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.study.statistics.share import Share
from system.verdict.null import nulls_of
from system.worlds.arena.file import load_scene

SCENES = ("pair", "triple", "triple-loose")
AROUND = ("pair", "triple")
RUNS, DIES = 100, 25
ENOUGH = 0.95  # of runs without a collision; ours
BETWEEN = 0.05  # of those past it; ours
SHOWN = 25  # paths in the picture
PAPER_RUNS = 20  # of each scene
PAPER_RUN: Summary = {"collided": 0.0, "crossed": 1.0, "between": 0.0}
# straight on it fits between the two blocks of a pair, and meets the middle one of a triple
BETWEEN_TWO = always(collided=0.0, crossed=1.0, between=1.0)
STRAIGHT = "drives straight on"
NULLS = (*ROBOTS, STRAIGHT)


def reproduce(
    progress: Progress, execution: Execution = ALONE, count: int = RUNS, dies: int = DIES,
    scenes: Sequence[str] = SCENES,
) -> Report:  # fmt: skip
    """Drive towards pairs and triples of blocks."""
    cells = {
        name: Drive(Scenario(scene=name, silicon_noise="off", **IDEAL_CURRENTS), with_path=True)
        for name in scenes
    }
    runs = drive_repeats(execution, EXPERIMENT.name, cells, Runs(count, dies), Runs(RUNS, DIES), progress)
    found = summaries_of(runs)
    paths = {name: [d.path for d in mine] for name, mine in runs.items()}
    nulls = nulls_of(rows, _nulls(found))
    paper = rows(dict.fromkeys(scenes, [PAPER_RUN] * PAPER_RUNS))
    return Report(rows(found), lambda figure: _draw(paths, figure), notes(found), nulls, paper)


def _nulls(found: Mapping[str, Sequence[Summary]]) -> dict[str, Mapping[str, Sequence[Summary]]]:
    straight = {
        name: [(BETWEEN_TWO if name == "pair" else COLLIDES)(run) for run in runs]
        for name, runs in found.items()
    }
    return {**runs_of(ROBOTS, found), STRAIGHT: straight}


def rows(found: Mapping[str, Sequence[Summary]]) -> tuple[Statement, ...]:
    """Make the statements about collisions in each scene, and about ways around pairs and triples."""
    free = [_free(name, summaries) for name, summaries in found.items()]
    return (*free, *(_around(name, found[name]) for name in AROUND if name in found))


def _around(name: str, found: Sequence[Summary]) -> Statement:
    between = share_of([s for s in found if s["crossed"] and not s["collided"]], "between")
    paper = "around" if name == "pair" else None
    return Statement(f"{name}_passed_between", paper, between.measured(), at_most(BETWEEN))


def _free(name: str, found: Sequence[Summary]) -> Statement:
    collided = share_of(found, "collided")
    free = Share(collided.of - collided.passed, collided.of)
    return Statement(f"{name}_without_collision", "20 of 20", free.measured(), at_least(ENOUGH))


def notes(found: Mapping[str, Sequence[Summary]]) -> tuple[str, ...]:
    """Tell which sides were taken, and how many runs did not get past."""
    out = []
    for name, summaries in found.items():
        left = sum(s["passed"] == 1.0 for s in summaries)
        right = sum(s["passed"] == -1.0 for s in summaries)
        neither = len(summaries) - left - right
        out.append(
            f"{name}: past on the left {left}, on the right {right}, not past {neither}; between two blocks"
            f" {share_of(summaries, 'between')}"
        )
    return tuple(out)


def _draw(paths: Mapping[str, Sequence[F64]], figure: Figure) -> None:
    figure.set_size_inches(4.6 * len(paths), 3.6)
    axes = np.atleast_1d(figure.subplots(1, len(paths)))
    for ax, (name, mine) in zip(axes, paths.items(), strict=True):
        draw_paths(load_scene(name), mine[:SHOWN], ax)
        ax.set_title(f"{name}, {min(len(mine), SHOWN)} of {len(mine)} runs", fontsize=9)


EXPERIMENT = Experiment(
    "milde2017-pairs", "two and three blocks at 0.35 m/s", reproduce, {"count": RUNS, "dies": DIES}, NULLS
)
