"""Section 3.3 and Figure 9 of Milde et al. 2017: a cup moved into the way, against one that stands there.

The paper reports six runs at speed factors 0.1 to 2 without a collision, and that "avoiding a moving obstacle
is more robust than avoiding a static obstacle". The robot drives towards a cup that is moved into its way and
towards one that stands there, and the shares of collisions are compared. The paper does not say when the mug
came. Here it moves at 0.2 m/s and stands in the
way when a robot that drove straight on would have 0.3 m left to it, at each speed factor; where there is no
time for all of its way, it begins on it. The other cup stands there from the beginning. Rule: at each factor
the share of collisions is at most five points above that with the standing cup, by the upper end of the 95 %
interval over pairs of runs on the same die with the same seed. Besides, by the same rule,
the scene's own timing at factor 0.5: the cup closes the way when such a robot is at it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import hypot

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.experiment import Experiment, Progress, Report
from system.papers.conditions import IDEAL_CURRENTS
from system.papers.milde2017.null import ROBOTS, runs_of
from system.papers.milde2017.picture import draw_paths
from system.pushbot.body import SPEED_OF_FACTOR
from system.pushbot.campaign import Drive, Runs, Summary, World, drive_repeats, share_of, summaries_of
from system.pushbot.scenario import Scenario, scene_of
from system.rule import Measured, at_most
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.study.statistics.comparison import paired_interval
from system.study.statistics.share import Share, share_where
from system.verdict.null import nulls_of
from system.worlds.arena.scene import Body, Motion, Scene

RUNS, DIES = 100, 10
FACTORS = (0.1, 0.5, 1.0, 2.0)  # of speed; the paper's ends, and two between; ours
OWN = 0.5  # factor at which the scene's own timing is driven too
WAY = 0.8  # m of 1.1 that a robot has gone when the cup stands in its way; ours
POINTS = 0.05  # of collisions that moving may cost
SHOWN = 25  # paths in a picture

Found = Mapping[str, tuple[Sequence[Summary], Sequence[Summary]]]


def reproduce(
    progress: Progress, execution: Execution = ALONE, count: int = RUNS, dies: int = DIES
) -> Report:
    """Drive a moving and a standing cup at every factor, and the scene's own timing at `OWN`."""
    cases = [(world, factor) for factor in FACTORS for world in (pushed, standing)]
    cells: dict[tuple[World, float], Drive] = {
        (world, f): Drive(
            Scenario(scene="moving", speed_factor=f, silicon_noise="off", **IDEAL_CURRENTS),
            world=world,
            with_path=f == OWN,
        )
        for world, f in (*cases, (scene_of, OWN))
    }
    parts = drive_repeats(execution, EXPERIMENT.name, cells, Runs(count, dies), Runs(RUNS, DIES), progress)
    told = summaries_of(parts)
    found = _pairs(told)
    nulls = {name: _pairs(runs) for name, runs in runs_of(ROBOTS, told).items()}
    paths = [[d.path for d in parts[world, OWN]] for world in (pushed, standing)]
    return Report(rows(found), lambda figure: _draw(paths, figure), notes(found), nulls_of(rows, nulls))


def _pairs(told: Mapping[tuple[World, float], Sequence[Summary]]) -> Found:
    """Moving and standing cup of each row."""
    found = {f"{factor:g}": (told[pushed, factor], told[standing, factor]) for factor in FACTORS}
    return found | {f"{OWN:g}_at_the_last_moment": (told[scene_of, OWN], told[standing, OWN])}


def pushed(scenario: Scenario) -> Scene:
    """Give the scene with the cup in the way in time for the scenario's speed factor."""
    scene = scene_of(scenario)
    return replace(scene, bodies=tuple(_timed(b, scenario.speed_factor) for b in scene.bodies))


def _timed(body: Body, factor: float) -> Body:
    if body.motion is None:
        return body
    there = WAY / (SPEED_OF_FACTOR * factor)
    return replace(body, motion=replace(body.motion, start=there - length(body.motion) / body.motion.speed))


def length(motion: Motion) -> float:
    """Give the length of a body's way, m."""
    return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(motion.path))


def standing(scenario: Scenario) -> Scene:
    """Give the scene with everything where its motion ends."""
    scene = scene_of(scenario)
    return replace(scene, bodies=tuple(_still(b) for b in scene.bodies))


def _still(body: Body) -> Body:
    return body if body.motion is None else replace(body, at=body.motion.path[-1], motion=None)


def rows(found: Found) -> tuple[Statement, ...]:
    """Make a statement at each factor about what the moving of the cup costs."""
    return tuple(_row(name, *both) for name, both in found.items())


def _row(name: str, moving: Sequence[Summary], static: Sequence[Summary]) -> Statement:
    pairs = [(bool(a["collided"]), bool(b["collided"])) for a, b in zip(moving, static, strict=True)]
    ends = paired_interval(pairs.count((True, False)), pairs.count((False, True)), len(pairs))
    first, second = share_of(moving, "collided"), share_of(static, "collided")
    ours = Measured(ends.high, f"{first} less {second}, at most {ends.high:.3f}")
    rule = at_most(POINTS, "upper end of the interval at most {limit:g} (ours)")
    return Statement(f"collided_moving_less_static_at_{name}", "fewer", ours, rule)


def notes(found: Found) -> tuple[str, ...]:
    """Tell the events of both cups, and how many runs get past."""

    def events(runs: Sequence[Summary]) -> float:
        return float(np.mean([(s["events"] or 0.0) / (s["time_s"] or 1.0) for s in runs]))

    return tuple(
        f"factor {name.replace('_', ' ')}, moving and standing cup: events a second {events(moving):.0f} and"
        f" {events(static):.0f}; past the line {_past(moving)} and {_past(static)}"
        for name, (moving, static) in found.items()
    )


def _past(runs: Sequence[Summary]) -> Share:
    return share_where(s["passed"] is not None for s in runs)


def _draw(paths: Sequence[Sequence[F64]], figure: Figure) -> None:
    figure.set_size_inches(9.0, 3.4)
    worlds = (
        pushed(Scenario(scene="moving", silicon_noise="off", **IDEAL_CURRENTS)),
        standing(Scenario(scene="moving", silicon_noise="off", **IDEAL_CURRENTS)),
    )
    names = ("moving", "standing")
    for ax, mine, scene, name in zip(figure.subplots(1, 2), paths, worlds, names, strict=True):
        draw_paths(scene, mine[:SHOWN], ax, 3.0)
        shown = f"{min(len(mine), SHOWN)} of {len(mine)} runs, factor {OWN:g}"
        ax.set_title(f"{name} cup, {shown}", fontsize=9)


EXPERIMENT = Experiment(
    "milde2017-moving", "a cup moved into the way, against a standing one, by speed factor", reproduce,
    {"count": RUNS, "dies": DIES}, tuple(ROBOTS),
)  # fmt: skip
