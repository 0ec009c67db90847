"""Pictures of the Bug robot: obstacles, paths, and the shortest one dotted, as in Figures 6 and 8."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from shapely.geometry import Polygon

from circuits.arrays import F64
from circuits.catalogue import later
from system.bug.world import World
from system.plot import COLOURS, DASHES, INK, PALE, entitle, sized_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.path import Path

patches, paths = later("matplotlib.patches"), later("matplotlib.path")

_INCHES = 7.0  # of the longer side of a map


def draw_world(world: World, ax: Axes) -> None:
    """Draw obstacles; starts are dots, goals are stars."""
    for polygon in world.obstacles.geoms:
        ax.add_patch(patches.PathPatch(_outline(polygon), facecolor=PALE, edgecolor="none", zorder=1))
    ax.scatter([], [], s=60.0, marker="s", color=PALE, label="obstacle")
    for points, mark, size, name in (
        (world.map.starts, "o", 5.0, "start"),
        (world.map.goals, "*", 10.0, "goal"),
    ):
        ax.plot(
            *np.array(points).T, marker=mark, markersize=size, color=INK, linestyle="", zorder=5, label=name
        )
    ax.set_xlim(-0.5, world.map.width + 0.5)
    ax.set_ylim(-0.5, world.map.height + 0.5)
    ax.set_aspect("equal")
    ax.set_xlabel("x (map units)")
    ax.set_ylabel("y (map units)")


def draw_shortest(path: F64 | None, ax: Axes) -> None:
    """Draw the shortest path, float64[n, 2], dotted; nothing for None."""
    if path is not None:
        ax.plot(*path.T, color=INK, linewidth=1.2, linestyle=":", zorder=3, label="shortest path of a point")


def draw_paths(paths: Mapping[str, F64], ax: Axes) -> None:
    """Draw paths, float64[n, 2], by their labels, a colour each."""
    for k, (label, path) in enumerate(paths.items()):
        dashes = DASHES[k % 3]  # dots are the shortest path's
        colour = COLOURS[k % len(COLOURS)]
        ax.plot(*path.T, color=colour, linestyle=dashes, linewidth=1.0, zorder=4, label=label)


def draw_run(world: World, path: F64, shortest: F64 | None, title: str, figure: Figure) -> None:
    """Fill an empty figure with one run."""
    scale = _INCHES / max(world.map.width, world.map.height)
    ax = sized_axes(figure, scale * world.map.width + 1.0, scale * world.map.height + 1.3)
    draw_world(world, ax)
    draw_shortest(shortest, ax)
    draw_paths({"path": path}, ax)
    entitle(title, ax)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=8)


def _outline(polygon: Polygon) -> Path:
    """Path of a polygon with its holes."""
    rings = [np.asarray(ring.coords) for ring in (polygon.exterior, *polygon.interiors)]
    whole: Path = paths.Path.make_compound_path(*(paths.Path(ring, closed=True) for ring in rings))
    return whole
