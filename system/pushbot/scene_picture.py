"""Pictures of a Pushbot's world: the scene from above with a path, and the events of the sensor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from system.plot import COLOURS, INK, PALE
from system.worlds.arena.geometry import obstacles_of, outline_at, robot_outline
from system.worlds.arena.scene import COLOURS as REFLECTANCES
from system.worlds.arena.scene import Scene
from system.worlds.camera.event import Events, frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes

colors, patches = later("matplotlib.colors"), later("matplotlib.patches")

_INKS = {"blue": COLOURS[0], "red": COLOURS[1], "yellow": COLOURS[6], "black": INK, "grey": "#808080",
         "wood": "#C19A6B", "white": "#FFFFFF"}  # fmt: skip
_ON, _OFF = COLOURS[0], COLOURS[1]  # the paper has blue and green, which few tell apart as pale dots
_MOST = 4  # events a pixel that the darkest dot stands for
_PALEST = 0.35  # share of its colour that a dot of one event has at least


def draw_scene(scene: Scene, ax: Axes, time: float = 0.0) -> None:
    """Draw a scene from above: floor, shades, bodies in their colours, paths dotted.

    Parameters
    ----------
    scene
        The scene.
    ax
        Where it is drawn.
    time
        Time of the scene, s.
    """
    ax.add_patch(
        patches.Polygon(
            np.array(scene.corners), closed=True, facecolor="#F7F7F7", edgecolor=INK, linewidth=1.2
        )
    )
    for shade in scene.shades:
        ax.add_patch(
            patches.Polygon(np.array(shade.corners), closed=True, facecolor=PALE, edgecolor="none", zorder=1)
        )
    for line in scene.partitions:
        ax.plot(*np.array(line).T, color=INK, linewidth=1.2, zorder=3)
    obstacles = obstacles_of(scene)
    for k, body in enumerate(scene.bodies):
        outline = np.array(outline_at(obstacles, k, time).exterior.coords)
        high = not obstacles.solid[k]
        ax.add_patch(
            patches.Polygon(
                outline, closed=True, facecolor="none" if high else ink_of(body.reflectance), edgecolor=INK,
                linewidth=0.5, linestyle=":" if high else "-", zorder=3,
            )
        )  # fmt: skip
        if body.motion is not None:
            way = np.array(body.motion.path).T
            ax.plot(*way, color=INK, linewidth=0.7, linestyle=":", zorder=2, label="way of a moving body")
        if body.led is not None:
            middle = outline[:-1].mean(axis=0)
            ax.plot(
                *middle,
                marker="*",
                color=COLOURS[4],
                markersize=7,
                linestyle="",
                zorder=4,
                label="blinking LED",
            )
    corners = np.array(scene.corners)
    (left, low), (right, high_y) = corners.min(axis=0), corners.max(axis=0)
    ax.set_xlim(left - 0.05, right + 0.05)
    ax.set_ylim(low - 0.05, high_y + 0.05)
    ax.set_aspect("equal")
    ax.set_xlabel("x (m)")
    ax.set_ylabel("y (m)")


def draw_path(path: F64, ax: Axes, moments: Sequence[float] = ()) -> None:
    """Draw the path of a robot, with the robot at its start and at numbered moments.

    Parameters
    ----------
    path
        Time (s), place (m, m) and heading (rad), float64[n, 4].
    ax
        Where it is drawn.
    moments
        Times of the moments, s.
    """
    ax.plot(path[:, 1], path[:, 2], color=COLOURS[2], linewidth=1.4, zorder=5, label="path")
    for k, moment in enumerate((path[0, 0], *moments)):
        row = path[min(int(np.searchsorted(path[:, 0], moment - 1e-9)), len(path) - 1)]
        outline = np.array(robot_outline((row[1], row[2], row[3])).exterior.coords)
        label = None if k > 0 else f"robot at its start{' and at 1, 2, ...' if len(moments) else ''}"
        ax.add_patch(
            patches.Polygon(
                outline, closed=True, facecolor="none", edgecolor=COLOURS[2], zorder=5, label=label
            )
        )
        nose = 0.05 * math.cos(row[3]), 0.05 * math.sin(row[3])
        ax.plot(
            [row[1], row[1] + nose[0]], [row[2], row[2] + nose[1]], color=COLOURS[2], linewidth=1.0, zorder=5
        )
        if k > 0:
            ax.annotate(str(k), (row[1], row[2]), (5, 5), textcoords="offset points", fontsize=8, zorder=6)


def draw_events(events: Events, columns: int, rows: int, ax: Axes) -> None:
    """Draw events by pixel as in Figure 8: on events blue, off events orange, darker where there are more.

    A dotted line parts the half that the target field sees, above, from that of the obstacle populations.
    """
    image = np.ones((rows, columns, 3))
    for on, colour in ((True, _ON), (False, _OFF)):
        chosen = events.where(events.on == on)
        count = np.minimum(np.abs(frame(chosen, columns, rows)), _MOST) / _MOST
        seen = np.where(count > 0.0, _PALEST + (1.0 - _PALEST) * count, 0.0)
        image *= 1.0 - seen[:, :, None] * (1.0 - np.array(colors.to_rgb(colour)))
    ax.imshow(np.clip(image, 0.0, 1.0), origin="lower", interpolation="nearest")
    ax.axhline(0.5 * rows - 0.5, color=INK, linewidth=0.8, linestyle=":")
    ax.set_xticks([])
    ax.set_yticks([])


def draw_events_key(ax: Axes) -> None:
    """Fill `ax` with a line that says what frames of events show."""
    for colour, label in ((_ON, "on: brighter"), (_OFF, "off: darker")):
        ax.plot([], [], marker="s", color=colour, linestyle="", markersize=5, label=label)
    label = "below it OL and OR see, above it the target field"
    ax.plot([], [], color=INK, linewidth=0.8, linestyle=":", label=label)
    draw_key(ax, ax)


def draw_key(about: Axes, ax: Axes) -> None:
    """Fill `ax` with the legend of the axes `about`, in one line, each label once."""
    ax.set_axis_off()
    handles, labels = about.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    key = ax.legend(list(once.values()), list(once), loc="center", ncols=len(once) or 1, fontsize=8)
    key.set_in_layout(False)  # a long line must not make the panels narrow


def ink_of(reflectance: float) -> str:
    """Return the colour in which a body of a reflectance is drawn."""
    name = min(REFLECTANCES, key=lambda n: abs(REFLECTANCES[n] - reflectance))
    return _INKS[name]
