"""Section 3.3 and Figure 9 of Milde et al. 2017: a cup moved into the way, against one that stands there.

The paper: six runs at speed factors 0.1 to 2 without a collision; "avoiding a moving obstacle is more robust
than avoiding a static obstacle". Here the cup comes at 0.2 m/s into the way at each speed factor when a robot
that drove straight on would be where the scene's robot is at factor 0.5; where there is no time for all of
its way, it begins on it. The other cup stands where the first one ends. Rule: at each factor the share of
collisions is at most five points above that with the standing cup.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import hypot

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from system.arena import Body, Motion, Scene
from system.campaign import ALONE, Campaign
from system.experiment import Experiment, Progress, Report, Row
from system.plot import COLOURS
from system.pushbot import Scenario, scene_of
from system.pushbot_campaign import Drive, Summary, drive_all, share_of, trials
from system.pushbot_picture import draw_scene
from system.share import Share, share_where

F64 = NDArray[np.float64]

RUNS, DIES = 40, 10
FACTORS = (0.1, 0.5, 1.0, 2.0)  # of speed; the paper's ends, and two between; ours
OWN = 0.5  # factor at which the scene's cup comes in time
POINTS = 0.05  # of collisions that moving may cost
SHOWN = 25  # paths in a picture

Found = Mapping[float, tuple[Sequence[Summary], Sequence[Summary]]]


def reproduce(
    progress: Progress, campaign: Campaign = ALONE, count: int = RUNS, dies: int = DIES,
    factors: Sequence[float] = FACTORS,
) -> Report:  # fmt: skip
    """Drive both at every factor."""
    drives = [
        Drive(each, world=world, with_path=factor == OWN)
        for factor in factors
        for world in (pushed, standing)
        for each in trials(Scenario(scene="moving", speed_factor=factor), count, dies)
    ]
    driven = drive_all(campaign, EXPERIMENT.name, drives, progress)
    parts = [driven[k : k + count] for k in range(0, len(driven), count)]
    summaries = [[d.summary for d in part] for part in parts]
    found = {f: (summaries[2 * k], summaries[2 * k + 1]) for k, f in enumerate(factors)}
    paths = [[d.path for d in parts[2 * list(factors).index(OWN) + k]] for k in range(2)]
    return Report(rows(found), lambda figure: _draw(paths, figure), notes(found))


def pushed(scenario: Scenario) -> Scene:
    """The scene with the cup in the way in time for the scenario's speed factor."""
    scene = scene_of(scenario)
    return replace(scene, bodies=tuple(_timed(b, scenario.speed_factor) for b in scene.bodies))


def _timed(body: Body, factor: float) -> Body:
    if body.motion is None:
        return body
    needed = way(body.motion) / body.motion.speed
    start = (body.motion.start + needed) * OWN / factor - needed
    return replace(body, motion=replace(body.motion, start=start))


def way(motion: Motion) -> float:
    """Length of a body's way, m."""
    return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in zip(motion.path, motion.path[1:], strict=False))


def standing(scenario: Scenario) -> Scene:
    """The scene with everything where its motion ends."""
    scene = scene_of(scenario)
    return replace(scene, bodies=tuple(_still(b) for b in scene.bodies))


def _still(body: Body) -> Body:
    return body if body.motion is None else replace(body, at=body.motion.path[-1], motion=None)


def rows(found: Found) -> tuple[Row, ...]:
    """What moving costs at each factor."""
    return tuple(_row(factor, *both) for factor, both in found.items())


def _row(factor: float, moving: Sequence[Summary], static: Sequence[Summary]) -> Row:
    first, second = share_of(moving, "collided"), share_of(static, "collided")
    return Row(
        f"collided_moving_less_static_at_{factor:g}", "fewer", f"{first} less {second}",
        f"at most {POINTS:g}", POINTS, fitted=False, agrees=first.value - second.value <= POINTS,
    )  # fmt: skip


def notes(found: Found) -> tuple[str, ...]:
    """Events of both, and how many get past."""

    def events(runs: Sequence[Summary]) -> float:
        return float(np.mean([(s["events"] or 0.0) / (s["time_s"] or 1.0) for s in runs]))

    return tuple(
        f"factor {factor:g}, moving and standing cup: events a second {events(moving):.0f} and"
        f" {events(static):.0f}; past the line {_past(moving)} and {_past(static)}"
        for factor, (moving, static) in found.items()
    )


def _past(runs: Sequence[Summary]) -> Share:
    return share_where(s["passed"] is not None for s in runs)


def _draw(paths: Sequence[Sequence[F64]], figure: Figure) -> None:
    figure.set_size_inches(9.0, 3.4)
    worlds = (pushed(Scenario(scene="moving")), standing(Scenario(scene="moving")))
    names = ("moving", "standing")
    for ax, mine, scene, name in zip(figure.subplots(1, 2), paths, worlds, names, strict=True):
        draw_scene(scene, ax, 3.0)
        for path in mine[:SHOWN]:
            ax.plot(path[:, 0], path[:, 1], color=COLOURS[2], linewidth=0.7, alpha=0.6, zorder=4)
        shown = f"{min(len(mine), SHOWN)} of {len(mine)} runs, factor {OWN:g}"
        ax.set_title(f"{name} cup, {shown}", fontsize=9)


EXPERIMENT = Experiment(
    "milde2017-moving", "a cup moved into the way, against a standing one, by speed factor", reproduce,
    {"count": RUNS, "dies": DIES},
)  # fmt: skip
