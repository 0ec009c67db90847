"""Picture of a sonar head's run: angles, distance and lost pings, spikes of both sides."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from system.head.loop import LOST, Log
from system.plot import COLOURS, INK, PALE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIDES = ("left", "right")
_LOST = ("x", "|", "^", "s")  # markers of `LOST`


def draw_head(log: Log, figure: Figure) -> None:
    """Fill a figure with a run."""
    figure.set_size_inches(8.0, 6.4)
    angles, distance, counts, raster = figure.subplots(
        4, 1, sharex=True, gridspec_kw={"height_ratios": (3.0, 1.0, 1.4, 1.8)}
    )
    draw_angles(log, angles)
    distance.plot(log.time, log.distance, color=INK, linewidth=1.0)
    distance.set_ylabel("range (m)")
    draw_counts(log, counts)
    draw_raster(log, raster)
    raster.set_xlabel("time (s)")
    figure.align_ylabels()


def draw_angles(log: Log, ax: Axes) -> None:
    """Azimuth of target and head (deg), and pings without an answer."""
    ax.plot(log.time, np.degrees(log.target), color=PALE, linewidth=3.0, label="target")
    ax.plot(log.time, np.degrees(log.head), color=COLOURS[0], linewidth=1.2, label="head")
    why = np.array(log.lost)
    for marker, name in zip(_LOST, LOST, strict=True):
        at = why == name
        if at.any():
            ax.plot(
                log.time[at], np.degrees(log.head[at]), marker, color=COLOURS[1], markersize=5,
                label=f"lost: {name}",
            )  # fmt: skip
    ax.set_ylabel("azimuth (deg)")
    ax.legend(fontsize=8, ncols=6, loc="lower center", bbox_to_anchor=(0.5, 1.0))


def draw_counts(log: Log, ax: Axes) -> None:
    """Spikes counted a ping, the right's below zero."""
    for side, sign in ((0, 1), (1, -1)):
        ax.vlines(log.time, 0, sign * log.heard[:, side], color=COLOURS[side], linewidth=1.0)
    ax.axhline(0.0, color=INK, linewidth=0.5)
    ax.set_ylabel("LSO spikes\nright, left")


def draw_raster(log: Log, ax: Axes) -> None:
    """Spikes of the level units of both ears, the highest thresholds on top."""
    units = int(log.levels[:, 2].max()) + 1 if len(log.levels) else 1
    for side in (0, 1):
        mine = log.levels[log.levels[:, 1] == side]
        row = mine[:, 2] + (units + 1) * (1 - side)
        ax.plot(mine[:, 0], row, "|", color=COLOURS[side], markersize=3, markeredgewidth=0.7)
    ax.set_yticks([0.5 * (units - 1), 1.5 * units + 0.5], [SIDES[1], SIDES[0]])
    ax.set_ylabel("level units")
