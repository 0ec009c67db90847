"""Section 3.3 and Figure 9 of Milde et al. 2017: a cup moved into the way, against one that stands there.

The paper: six runs at speed factors 0.1 to 2 without a collision; "avoiding a moving obstacle is more robust
than avoiding a static obstacle". Here at speed factor 0.5, where the cup at 0.2 m/s comes into the way before
the robot does; the other cup stands where the first one ends. Rule: the share of collisions is at most five
points above that with the standing cup.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from system.arena import Body, Scene
from system.experiment import Experiment, Progress, Report, Row
from system.plot import COLOURS
from system.pushbot import Scenario, Trace, scene_of, summarise
from system.pushbot_campaign import Share, Summary, drive_each, share_of, trials
from system.pushbot_picture import draw_scene

F64 = NDArray[np.float64]

RUNS, DIES = 40, 20
POINTS = 0.05  # of collisions that moving may cost


def reproduce(progress: Progress, count: int = RUNS, dies: int = DIES) -> Report:
    """Drive both."""
    paths: list[list[F64]] = [[], []]
    found: list[list[Summary]] = []
    for k, world in enumerate((scene_of, standing)):

        def keep(trace: Trace, k: int = k) -> Summary:
            paths[k].append(np.array(trace.drive.path)[::10])
            return summarise(trace)

        def part(share: float, k: int = k) -> None:
            progress(0.5 * (k + share))

        found.append(drive_each(trials(Scenario(scene="moving"), count, dies), keep, part, world=world))
    moving, static = found
    return Report(rows(moving, static), lambda figure: _draw(paths, figure), notes(moving, static))


def standing(scenario: Scenario) -> Scene:
    """The scene with everything where its motion ends."""
    scene = scene_of(scenario)
    return replace(scene, bodies=tuple(_still(b) for b in scene.bodies))


def _still(body: Body) -> Body:
    return body if body.motion is None else replace(body, at=body.motion.path[-1], motion=None)


def rows(moving: Sequence[Summary], static: Sequence[Summary]) -> tuple[Row, ...]:
    """What moving costs."""
    first, second = share_of(moving, "collided"), share_of(static, "collided")
    more = first.value - second.value
    return (
        Row(
            "collided_moving_less_static", "fewer", f"{first} less {second}", f"at most {POINTS:g}", POINTS,
            fitted=False, agrees=more <= POINTS,
        ),
    )  # fmt: skip


def notes(moving: Sequence[Summary], static: Sequence[Summary]) -> tuple[str, ...]:
    """Events of both."""

    def events(found: Sequence[Summary]) -> float:
        return float(np.mean([(s["events"] or 0.0) / (s["time_s"] or 1.0) for s in found]))

    past = [Share(sum(s["passed"] is not None for s in f), len(f)) for f in (moving, static)]
    return (
        f"events a second: {events(moving):.0f} (moving cup), {events(static):.0f} (standing cup)",
        f"past the line: {past[0]} and {past[1]}",
    )


def _draw(paths: Sequence[Sequence[F64]], figure: Figure) -> None:
    figure.set_size_inches(9.0, 3.4)
    worlds = (scene_of(Scenario(scene="moving")), standing(Scenario(scene="moving")))
    names = ("moving", "standing")
    for ax, mine, scene, name in zip(figure.subplots(1, 2), paths, worlds, names, strict=True):
        draw_scene(scene, ax, 3.0)
        for path in mine[:25]:
            ax.plot(path[:, 1], path[:, 2], color=COLOURS[2], linewidth=0.7, alpha=0.6, zorder=4)
        ax.set_title(f"{name} cup, {min(len(mine), 25)} of {len(mine)} runs", fontsize=9)


EXPERIMENT = Experiment("milde2017-moving", "a cup moved into the way, against a standing one", reproduce)
