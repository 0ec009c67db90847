"""Pictures of forests: zones of collision on the torus, and paths through them."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.openspace.law import ARCS, Arcs, Bat, arc_point, detectable
from system.openspace.map import SIDE
from system.plot import COLOURS, INK, PALE, mark_end

_BEARINGS = np.linspace(-np.pi, np.pi, 361)


def draw_forest(place: F64, zone: float, ax: Axes) -> None:
    """Draw obstacles, float64[n, 2] in m, with the size of the zone of collision (m)."""
    draw_discs(place, zone, ax)
    ax.set_xlim(0.0, SIDE)
    ax.set_ylim(0.0, SIDE)
    ax.set_aspect("equal")
    ax.set_xlabel("x (m)")
    ax.set_ylabel("y (m)")


def draw_discs(place: F64, zone: float, ax: Axes) -> None:
    """Add zones of collision (m) about places, float64[n, 2] in m, to the axes."""
    width = np.full(len(place), 2.0 * zone)
    discs = EllipseCollection(
        width, width, np.zeros(len(place)), units="xy", offsets=place, offset_transform=ax.transData,
        facecolors=PALE, edgecolors="none", zorder=1,
    )  # fmt: skip
    ax.add_collection(discs)


def draw_path(path: F64, ax: Axes, width: float = 0.6) -> None:
    """Draw a path on the torus, float64[n, 2] in m, broken where it leaves by a border."""
    steps = np.abs(np.diff(path, axis=0)).max(axis=1, initial=0.0)
    broken = np.insert(path, np.flatnonzero(steps > 0.5 * SIDE) + 1, np.nan, axis=0)
    ax.plot(*broken.T, color=COLOURS[0], linewidth=width, zorder=2)


def draw_sight(bat: Bat, arcs: Arcs, pose: tuple[float, float, float], head: int, arc: int, ax: Axes) -> None:
    """Draw what a bat at a pose (m, m, rad) can choose: its arcs, the one it flies, and its field of view."""
    for p in range(ARCS):
        s = np.linspace(0.0, arcs.length[p], 60)
        line = placed(pose, *arc_point(np.full(60, arcs.curvature[p]), s))
        chosen = p == arc
        ax.plot(
            *line, color=INK if chosen else PALE, linewidth=1.6 if chosen else 0.6,
            linestyle="-" if chosen else ":", zorder=4 if chosen else 2,
        )  # fmt: skip
    reach = detectable(bat, _BEARINGS)
    bearing = _BEARINGS + arcs.direction[head]
    view = placed(pose, reach * np.cos(bearing), reach * np.sin(bearing))
    ax.plot(*view, color=COLOURS[0], linewidth=1.0, zorder=3)


def draw_bars(values: F64, arcs: Arcs, label: str, ax: Axes, winner: int | None = None) -> None:
    """Draw a number an arc, in a shade a ping direction; a dot is the winner."""
    colours = [COLOURS[int(g)] for g in arcs.group]
    ax.bar(np.arange(ARCS), values, color=colours, width=0.8)
    if winner is not None:
        ax.plot(winner, values[winner], marker="o", markersize=4, color="red", linestyle="", zorder=5)
    ax.set_ylabel(label, fontsize=8)
    ax.tick_params(labelsize=7)


def draw_view_of_run(
    place: F64, zone: float, path: F64, figure: Figure, title: str, *, succeeded: bool | None
) -> None:
    """Fill a figure with a forest and a path, as in Figure 10B; start and end are marked."""
    figure.set_size_inches(6.4, 6.6)
    ax = figure.subplots()
    draw_forest(place, zone, ax)
    draw_path(path, ax)
    ax.plot(*path[0], marker="o", color=COLOURS[2], markersize=6, linestyle="", zorder=4, label="start")
    mark_end(path[-1], ax, succeeded=succeeded)
    ax.set_title(title, fontsize=9)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)


def placed(pose: tuple[float, float, float], ahead: F64, left: F64) -> tuple[F64, F64]:
    """Points of the body's frame (m) in the world of a bat at a pose (m, m, rad)."""
    x, y, heading = pose
    cos, sin = np.cos(heading), np.sin(heading)
    return x + cos * ahead - sin * left, y + sin * ahead + cos * left
