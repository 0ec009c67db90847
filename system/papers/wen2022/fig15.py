"""Figure 15 of Wen & Horiuchi 2022: the robot in a corridor and two forests of pipes.

The robot drives through forests of three kinds, and its collisions and the directions of its pings are
compared with the paper's, which shows one collision-free run in each: pings go mostly down the middle of the
corridor, more to the side where it is cluttered. Here a forest and a start are drawn a run, from seeds that
chose no number. Rules (ours): at least 90 % of 100 runs without a collision in each forest; a smaller share
of side pings in the corridor than in either forest, the intervals of the means apart, and below a half,
"mostly". The numbers were chosen, on other seeds, for few collisions and few side pings in the corridor:
those rows count as fitted.

Intervals: the exact one of a share; of a mean the bootstrap's. A run that was cut off by its number of
pings is no collision; how many there were is a note. Some of the same seeds without soft pings, with exact
ranges and with the ranging chip are notes too: they are no part of the figure.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.car.picture import draw_robot
from system.car.run import ENDS, account, run, side_share
from system.car.scenario import Scenario
from system.car.world import FORESTS
from system.experiment import Experiment, Progress, Report
from system.papers.conditions import FIXED_GATES
from system.rule import Measured, apart_above, at_least, below
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered
from system.study.statistics.interval import Estimate, mean_interval
from system.study.statistics.share import Share
from system.verdict.null import Null, nulls_of, shuffled

RUNS, OTHER_RUNS = 100, 30  # in each forest: of the figure, and of each of the other ways
FIRST_SEED = 1000  # those below chose the numbers
LEAST, MOSTLY = 0.9, 0.5
NAMES = {"corridor": "15A", "open": "15B", "dense": "15C"}
FLIGHT = "flight"
COLLIDES, STANDS, DRAWN = "always collides", "never moves, pings all ways alike", "runs drawn anew"
NULLS = (COLLIDES, STANDS, DRAWN)
ALIKE = 2.0 / 3.0  # of pings that go to a side, if of three directions none is preferred
WAYS: Mapping[str, dict[str, Any]] = {
    FLIGHT: {},
    "without soft pings": {"soft_pings": False},
    "exact ranges": {"ranges": "exact"},
    "ranging chip, nominal die": {"ranges": "chip", **FIXED_GATES},
}


@dataclass(frozen=True, slots=True)
class Drive:
    """A run: how it ended (`system.car.run.ENDS`), and the share of its pings that went to a side."""

    ended: str
    side: float


@dataclass(frozen=True, slots=True)
class Found:
    """Runs of one kind in one forest: how many ended how, and share of side pings of each."""

    ends: Mapping[str, int]
    side: F64

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.side)

    @property
    def free(self) -> Share:
        """Share without a collision."""
        return Share(self.runs - self.ends["collided"], self.runs)

    @property
    def side_share(self) -> Estimate:
        """Mean share of the pings that did not go straight ahead."""
        return Estimate(float(self.side.mean()), mean_interval(self.side, np.random.default_rng(0)))


def reproduce(progress: Progress, execution: Execution = ALONE, runs: int = RUNS) -> Report:
    """Drive through all forests, then again in other ways; another way has `OTHER_RUNS` runs at most."""
    counts = {FLIGHT: runs, **{way: min(runs, OTHER_RUNS) for way in WAYS if way != FLIGHT}}
    keys = [
        Numbered(_named(forest, way), FIRST_SEED + k)
        for way, count in counts.items()
        for forest in FORESTS
        for k in range(count)
    ]
    numbers = (version("noctule"), *scenarios().items())
    campaign = Campaign("wen2022-fig15", drive_one, Numbered, Drive, numbers)
    drives = execution.by_condition(campaign, keys, progress)
    found = {forest: summed(drives[_named(forest, FLIGHT)]) for forest in FORESTS}
    notes = tuple(note(name, summed(each)) for name, each in drives.items())
    flown = {forest: drives[_named(forest, FLIGHT)] for forest in FORESTS}
    return Report(rows(found), lambda figure: _draw(found, figure), notes, _nulls(flown))


def _nulls(flown: Mapping[str, Sequence[Drive]]) -> tuple[Null, ...]:
    """A robot that drives straight on, one that stands, and runs that are of any forest."""
    every = [drive for each in flown.values() for drive in each]

    def told(drives: Sequence[Drive]) -> dict[str, Found]:
        ends = np.cumsum([len(each) for each in flown.values()])
        parts = zip(flown, [0, *ends[:-1]], ends, strict=True)
        return {forest: summed(drives[begin:end]) for forest, begin, end in parts}

    constant = {
        COLLIDES: told([Drive("collided", 0.0)] * len(every)),
        STANDS: told([Drive("undecided", ALIKE)] * len(every)),
    }
    return (
        *nulls_of(rows, constant),
        shuffled(DRAWN, rows, lambda order: told([every[k] for k in order]), len(every)),
    )


def scenarios() -> dict[str, Scenario]:
    """What is driven, by forest and way."""
    return {
        _named(forest, way): Scenario(forest=forest, **options)
        for way, options in WAYS.items()
        for forest in FORESTS
    }


def _named(forest: str, way: str) -> str:
    return f"{forest}, {way}"


def drive_one(key: Numbered) -> Drive:
    """Drive a scenario with a seed."""
    drive = run(replace(scenarios()[key.condition], seed=key.number)).drive
    return Drive(drive.ended, side_share(drive))


def summed(drives: Sequence[Drive]) -> Found:
    """What runs came to."""
    ends = {name: sum(d.ended == name for d in drives) for name in ENDS}
    return Found(ends, np.array([d.side for d in drives]))


def rows(found: Mapping[str, Found]) -> tuple[Statement, ...]:
    """Collision-free shares, and where it pings to the side."""
    free = [
        Statement(
            f"{forest}_collision_free",
            None,
            each.free.value,
            at_least(LEAST, "at least {percent:g} %"),
            fitted=True,
        )
        for forest, each in found.items()
    ]
    corridor = found["corridor"].side_share
    mostly = Statement("corridor_side_pings", "few", corridor.value, below(MOSTLY), fitted=True)
    apart = apart_above(corridor, "above the corridor's, intervals apart")
    more = []
    for forest in FORESTS[1:]:
        side = found[forest].side_share
        more.append(
            Statement(f"{forest}_side_pings", "more", Measured(side.value, side.value, side.interval), apart)
        )
    return (*free, mostly, *more)


def note(name: str, found: Found) -> str:
    """A line of what was found."""
    free, side = found.free, found.side_share
    ends = ", ".join(f"{n} {end}" for end, n in found.ends.items() if n)
    return (
        f"{name}: {free} free of collisions ({ends}); side pings {side.value:.2f}"
        f" [{_shown(side.interval.low)}, {_shown(side.interval.high)}]"
    )


def _shown(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


def _draw(found: Mapping[str, Found], figure: Figure) -> None:
    figure.set_size_inches(12.0, 4.6)
    for ax, (forest, each) in zip(figure.subplots(1, len(found)), found.items(), strict=True):
        t = run(replace(scenarios()[_named(forest, FLIGHT)], seed=FIRST_SEED))
        said = account(t)
        zone = t.scenario.robot.zone
        draw_robot(t.forest, t.arcs, t.path, t.drive.log, zone, ax, succeeded=said.succeeded)
        title = f"{NAMES[forest]}, {forest}: {100.0 * each.side[0]:.0f} % side pings"
        ax.set_title(f"{title}\n{said.headline}", fontsize=9)
    handles = {h.get_label(): h for ax in figure.axes for h in ax.get_legend_handles_labels()[0]}
    figure.legend(handles=list(handles.values()), loc="outside lower center", ncols=7, fontsize=8)


EXPERIMENT = Experiment(
    "wen2022-fig15", "the sonar robot in three forests of pipes", reproduce, {"runs": RUNS}, NULLS
)
