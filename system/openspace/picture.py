"""Pictures of forests: zones of collision on the torus, and paths through them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from system.openspace.law import ARCS, Arcs, Bat, arc_point, detectable
from system.openspace.map import SIDE
from system.plot import COLOURS, INK, PALE, entitle, mark_end, sized_axes
from system.view.film import NO_YES, Film, Shape, Stage, Track, circles, signal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import EllipseCollection
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

collections = later("matplotlib.collections")

_BEARINGS = np.linspace(-np.pi, np.pi, 361)
_STEPS = 60  # points of a drawn arc


def draw_forest(place: F64, zone: float, ax: Axes) -> None:
    """Draw obstacles, float64[n, 2] in m, with the size of the zone of collision (m)."""
    draw_discs(place, zone, ax)
    ax.set_xlim(0.0, SIDE)
    ax.set_ylim(0.0, SIDE)
    ax.set_aspect("equal")
    ax.set_xlabel("x (m)")
    ax.set_ylabel("y (m)")


def draw_discs(place: F64, zone: float, ax: Axes) -> EllipseCollection:
    """Add zones of collision (m) about places, float64[n, 2] in m, to the axes, and return them."""
    width = np.full(len(place), 2.0 * zone)
    discs: EllipseCollection = collections.EllipseCollection(
        width, width, np.zeros(len(place)), units="xy", offsets=place, offset_transform=ax.transData,
        facecolors=PALE, edgecolors="none", zorder=1,
    )  # fmt: skip
    ax.add_collection(discs)
    # A legend knows no ellipses: a dot without a place stands for them.
    ax.scatter([], [], s=60.0, color=PALE, label=f"zone of collision, radius {zone:g} m")
    return discs


def draw_path(path: F64, ax: Axes, width: float = 0.6) -> Line2D:
    """Draw a path on the torus, float64[n, 2] in m, broken where it leaves by a border; returns its line."""
    steps = np.abs(np.diff(path, axis=0)).max(axis=1, initial=0.0)
    broken = np.insert(path, np.flatnonzero(steps > 0.5 * SIDE) + 1, np.nan, axis=0)
    (line,) = ax.plot(*broken.T, color=COLOURS[0], linewidth=width, zorder=2, label="path")
    return line


def draw_sight(bat: Bat, arcs: Arcs, pose: tuple[float, float, float], head: int, arc: int, ax: Axes) -> None:
    """Draw what a bat at a pose (m, m, rad) can choose: its arcs, the one it flies, and its field of view."""
    ways = []
    for p in range(ARCS):
        s = np.linspace(0.0, arcs.length[p], _STEPS)
        ways.append(np.stack(placed(pose, *arc_point(np.full(_STEPS, arcs.curvature[p]), s)), axis=1))
    others = ways[:arc] + ways[arc + 1 :]
    ax.add_collection(
        collections.LineCollection(
            others, colors=PALE, linewidths=0.7, linestyles=":", zorder=2, label="arcs to choose from"
        )
    )
    ax.plot(*ways[arc].T, color=INK, linewidth=1.6, zorder=4, label="chosen arc")
    reach = detectable(bat, _BEARINGS)
    bearing = _BEARINGS + arcs.direction[head]
    view = placed(pose, reach * np.cos(bearing), reach * np.sin(bearing))
    ax.plot(
        *view, color=COLOURS[1], linewidth=1.0, linestyle="--", zorder=3, label="field of view of the ping"
    )
    ax.plot(*pose[:2], marker="o", color=INK, markersize=5, linestyle="", zorder=5, label="bat")


def draw_bars(values: F64, arcs: Arcs, label: str, ax: Axes, winner: int | None = None) -> None:
    """Draw a number an arc, in a shade a ping direction; a triangle is the winner."""
    colours = [COLOURS[int(g)] for g in arcs.group]
    ax.bar(np.arange(ARCS), values, color=colours, width=0.8)
    if winner is not None:
        ax.plot(
            winner,
            values[winner],
            marker="v",
            markersize=5,
            color=INK,
            linestyle="",
            zorder=5,
            label="winner",
        )
    ax.set_ylabel(label, fontsize=8)
    ax.tick_params(labelsize=7)


def draw_view_of_run(
    place: F64, zone: float, path: F64, figure: Figure, title: str, *, succeeded: bool | None
) -> None:
    """Fill a figure with a forest and a path, as in Figure 10B; start and end are marked."""
    ax = sized_axes(figure, 6.4, 6.6)
    draw_forest(place, zone, ax)
    draw_path(path, ax, 1.0)
    ax.plot(*path[0], marker="o", color=COLOURS[2], markersize=6, linestyle="", zorder=4, label="start")
    mark_end(path[-1], ax, succeeded=succeeded)
    entitle(title, ax)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)


def placed(pose: tuple[float, float, float], ahead: F64, left: F64) -> tuple[F64, F64]:
    """Points of the body's frame (m) in the world of a bat at a pose (m, m, rad)."""
    x, y, heading = pose
    cos, sin = np.cos(heading), np.sin(heading)
    return x + cos * ahead - sin * left, y + sin * ahead + cos * left


def film_of_flight(
    place: F64, zone: float, log: F64, end: tuple[float, float], time_s: float, arcs: Arcs
) -> Film:
    """Return the film of a flight: the forest, the bat's way, and what it decided at each ping.

    Parameters
    ----------
    place
        Obstacles, float64[n, 2], m.
    zone
        Radius of their zones of collision, m.
    log
        As `system.openspace.state` has it, float64[pings, 8].
    end
        Where it ended, m.
    time_s
        When it ended, s.
    arcs
        Its arcs.
    """
    pings = log[:, 0]
    shapes = [Shape(role="floor", points=((0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)))]
    shapes += circles("obstacle", place, zone, "zone of collision")
    bat = Track(
        name="bat", time=np.append(pings, max([time_s, *pings[-1:]])), x=np.append(log[:, 1], end[0]),
        y=np.append(log[:, 2], end[1]), heading=np.unwrap(np.append(log[:, 3], log[-1:, 3])), radius=0.05,
        longest=0.5 * SIDE,
    )  # fmt: skip
    seen = np.degrees(arcs.direction[log[:, 4].astype(np.int64)])
    decided = (
        signal("direction of the ping, left above", "deg", pings, seen, "ping"),
        signal("chosen arc, 0 to the left", "", pings, log[:, 5], "arc"),
        signal("only the head turns", "", pings, log[:, 7], "scanning", NO_YES),
    )
    stage = Stage(unit="m", shapes=tuple(shapes), tracks=(bat,))
    return Film(title="", headline="", duration=float(bat.time[-1]), panels=decided, world=stage)
