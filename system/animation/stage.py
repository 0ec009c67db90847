"""The world of a film and what its camera sends, as artists of matplotlib that are moved to a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from system.plot import COLOURS, INK, PALE
from system.view.film import Eye, Role, Shape, Stage, Track

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.patches import Patch

colors, patches, transforms = (later(f"matplotlib.{name}") for name in ("colors", "patches", "transforms"))


GLOW = 0.04  # s for which an event of a camera stays lit; as in `player.js`
_DOT = 5.0  # points of what is too small to be seen, and half of what its front is long
_MARGIN = 0.04  # of a world's longer side, about it
_AREAS: dict[Role, tuple[str, float]] = {  # colour, and how opaque
    "floor": ("#F4F4F2", 1.0), "shade": ("#DADADA", 1.0), "obstacle": ("#9A9A9A", 1.0), "wall": (INK, 1.0),
    "goal": (COLOURS[2], 0.55), "start": (COLOURS[3], 0.55), "way": (PALE, 1.0), "moving": (COLOURS[1], 1.0),
    "sound": (COLOURS[5], 1.0),
}  # fmt: skip

Mover: TypeAlias = "tuple[Sequence[Artist], Callable[[float], None]]"
"""Artists, and what brings them to a time, s."""


def draw_stage(stage: Stage, ax: Axes) -> list[Mover]:
    """Draw a world from above, and return what moves in it."""
    for shape in stage.shapes:
        _draw_shape(shape, ax)
    points = [np.asarray(s.points) + r for s in stage.shapes for r in (-s.radius, s.radius)]
    points += [np.stack([t.x, t.y], axis=1) for t in stage.tracks]
    every = np.concatenate(points)
    low, high = np.nanmin(every, axis=0), np.nanmax(every, axis=0)
    room = _MARGIN * max(*(high - low), 1e-9)
    ax.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room), aspect="equal")
    ax.set(xlabel=f"x ({stage.unit})", ylabel=f"y ({stage.unit})")
    ax.tick_params(labelsize=7.0)
    if not stage.north:
        ax.invert_yaxis()
    return [_mover(track, ax) for track in stage.tracks]


def draw_eye(eye: Eye, ax: Axes) -> Mover:
    """Draw what a camera sends, brighter in blue and darker in orange."""
    back, on, off = (np.array(colors.to_rgb(c)) for c in ("#F4F4F2", COLOURS[0], COLOURS[1]))
    image = ax.imshow(np.tile(back, (eye.rows, eye.columns, 1)), origin="lower", interpolation="nearest")
    ax.set(xticks=[], yticks=[], title=eye.name)

    def move(t: float) -> None:
        first, last = np.searchsorted(eye.time, (t - GLOW, t), side="right")
        shown = np.tile(back, (eye.rows, eye.columns, 1))
        own = slice(first, last)
        shown[eye.y[own], eye.x[own]] = np.where(eye.on[own, None], on, off)
        image.set_data(shown)

    return (image,), move


def _draw_shape(shape: Shape, ax: Axes) -> None:
    colour, alpha = _AREAS[shape.role]
    colour = shape.colour or colour
    if not shape.closed:
        x, y = zip(*shape.points, strict=True)
        dashes = "--" if shape.role == "way" else "-"
        ax.plot(x, y, color=colour, linewidth=1.4 if shape.role == "wall" else 0.8, linestyle=dashes)
    elif shape.radius > 0.0:
        ax.add_patch(patches.Circle(shape.points[0], shape.radius, color=colour, alpha=alpha, linewidth=0.0))
    elif len(shape.points) == 1:
        ax.plot(*shape.points[0], marker="o", color=colour, alpha=alpha, markersize=_DOT, linestyle="")
    else:
        edge = PALE if shape.role == "floor" else "none"
        ax.add_patch(patches.Polygon(shape.points, facecolor=colour, edgecolor=edge, alpha=alpha))


def _mover(track: Track, ax: Axes) -> Mover:
    robot = track.role == "robot"
    colour = COLOURS[0] if robot else COLOURS[1]
    place = np.stack([track.x, track.y], axis=1)
    steps = np.hypot(*np.diff(place, axis=0).T)
    jumps = steps > (track.longest or np.inf)
    ax.plot(*_broken(place, jumps).T, color=PALE, linewidth=0.8)
    (way,) = ax.plot([], [], color=colour, linewidth=1.8 if robot else 0.0)
    (dot,) = ax.plot([], [], marker="o", color=colour, markersize=_DOT, linestyle="", label=track.name)
    (front,) = ax.plot([], [], color=colour, linewidth=2.0)
    body: Patch = patches.Circle((0.0, 0.0), track.radius, color=colour)
    if track.outline:
        body = patches.Polygon(track.outline, color=colour)
    ax.add_patch(body)
    name = ax.annotate(
        track.name, (0.0, 0.0), xytext=(_DOT, _DOT), textcoords="offset points", fontsize=7, color=colour
    )

    def move(t: float) -> None:
        k, (x, y), heading = _pose(track, jumps, t)
        way.set_data(*_broken(np.append(place[: k + 1], [[x, y]], axis=0), jumps[: k + 1]).T)
        dot.set_data([x], [y])
        body.set_transform(transforms.Affine2D().rotate(heading).translate(x, y) + ax.transData)
        name.xy = x, y
        if track.heading is not None:
            length = max(1.6 * track.radius, 2.0 * _DOT / _points_a_unit(ax))
            front.set_data([x, x + length * np.cos(heading)], [y, y + length * np.sin(heading)])

    return (way, body, dot, front, name), move


def _pose(track: Track, jumps: F64, t: float) -> tuple[int, tuple[float, float], float]:
    """Number of the point before a time, where it is then, and its heading, rad."""
    k = max(0, int(np.searchsorted(track.time, t, side="right")) - 1)
    n = min(k + 1, track.time.size - 1)
    span = float(track.time[n] - track.time[k])
    share = (
        float(np.clip((t - track.time[k]) / span, 0.0, 1.0)) if span > 0.0 and not jumps[k:n].any() else 0.0
    )
    x, y = (float(a[k] + share * (a[n] - a[k])) for a in (track.x, track.y))
    if track.heading is None:
        return k, (x, y), 0.0
    turn = float(track.heading[n] - track.heading[k])
    return k, (x, y), float(track.heading[k]) + share * float(np.arctan2(np.sin(turn), np.cos(turn)))


def _broken(place: F64, jumps: F64) -> F64:
    """A way, float64[n, 2], without the lines over its jumps, bool[n - 1]."""
    return np.insert(place, np.flatnonzero(jumps[: len(place) - 1]) + 1, np.nan, axis=0)


def _points_a_unit(ax: Axes) -> float:
    """Points that one unit of the axes has on the picture."""
    (a, _), (b, _) = ax.transData.transform([(0.0, 0.0), (1.0, 0.0)])
    figure = ax.get_figure(root=True)
    return float(abs(b - a)) * 72.0 / (100.0 if figure is None else figure.dpi)
