"""Pictures that several experiments on Milde et al. 2017 draw: a run, and paths in a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.plot import COLOURS
from system.pushbot.campaign import Drive, Runs, drive_again, trials
from system.pushbot.picture import draw_run
from system.pushbot.run import Trace
from system.pushbot.scene_picture import draw_scene
from system.worlds.arena.scene import Scene

SHADES = {"blue": COLOURS[0], "red": COLOURS[1], "yellow": COLOURS[4]}  # of what shows blocks by colour


def draw_trace(trace: Trace, figure: Figure) -> None:
    """Fill `figure` with a run; its title is the reason why the run ended."""
    draw_run(trace.scene, trace.drive, trace.brain, trace.record, trace.reason, figure)


def draw_first(drive: Drive, runs: Runs, figure: Figure) -> None:
    """Fill `figure` with the first of the runs of a drive, which is driven again for it."""
    first, *_ = trials(drive.scenario, *runs)
    draw_trace(drive_again(replace(drive, scenario=first)), figure)


def draw_paths(scene: Scene, paths: Sequence[F64], ax: Axes, time: float = 0.0) -> None:
    """Draw a scene as it is at `time` (s) and paths through it, float64[n, 2] each, in m."""
    draw_scene(scene, ax, time)
    for path in paths:
        ax.plot(path[:, 0], path[:, 1], color=COLOURS[2], linewidth=0.7, alpha=0.6, zorder=4)
