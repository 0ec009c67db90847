"""Picture of a drive: the way through pipes, and the directions of pings, as in Figure 15."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from system.car.arcs import Arcs
from system.car.numbers import PIPE_RADIUS
from system.car.world import Pipes
from system.openspace.picture import draw_discs
from system.plot import COLOURS, INK, mark_end

if TYPE_CHECKING:
    from matplotlib.axes import Axes

collections = later("matplotlib.collections")

NAMES = ("left", "middle left", "middle", "middle right", "right")
RAY = 0.12  # m, of the line that shows a ping's direction
_SHADES = (1, 4, 2, 5, 0)  # of `COLOURS`, a direction; green for the middle, as in the paper


def draw_robot(
    forest: Pipes, arcs: Arcs, path: F64, log: F64, zone: float, ax: Axes, *, succeeded: bool | None = None
) -> None:
    """Draw zones of collision (m) about pipes, the path (m) and a ray a ping; mark start and end."""
    draw_discs(forest.place, zone, ax)
    pipe = np.linspace(0.0, 2.0 * np.pi, 40)
    for x, y in forest.place:
        ax.fill(x + PIPE_RADIUS * np.cos(pipe), y + PIPE_RADIUS * np.sin(pipe), color=INK, zorder=2)
    ax.scatter([], [], s=12.0, color=INK, label=f"pipe, radius {100.0 * PIPE_RADIUS:g} cm")
    for d, name in enumerate(NAMES):
        at = log[log[:, 4] == d]
        if not len(at):
            continue
        angle = at[:, 3] + arcs.direction[d]
        tip = at[:, 1:3] + RAY * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        rays = np.stack([at[:, 1:3], tip], axis=1)
        ax.add_collection(
            collections.LineCollection(
                list(rays), colors=COLOURS[_SHADES[d]], linewidths=0.6, zorder=3, label=f"ping {name}"
            )
        )
    ax.plot(*path.T, color=INK, linewidth=1.4, zorder=4, label="path")
    ax.plot(*path[0], marker="o", color=INK, markersize=5, linestyle="", zorder=5, label="start")
    mark_end(path[-1], ax, succeeded=succeeded)
    ax.set_aspect("equal")
    shown = np.concatenate([forest.place - zone, forest.place + zone, path - RAY, path + RAY])
    ax.set_xlim(shown[:, 0].min(), shown[:, 0].max())
    ax.set_ylim(shown[:, 1].min(), shown[:, 1].max())
    ax.set_xlabel("x (m)")
    ax.set_ylabel("y (m)")
