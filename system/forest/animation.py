"""Animation of a flight through the forest: a frame a ping, with the field of view and the chosen arc.

A GIF by matplotlib's own writer. The picture follows the bat; obstacles beyond the borders are the torus's.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import animation
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.files.writing import check_folder
from system.openspace.flight import Run
from system.openspace.law import Bat, arcs_of
from system.openspace.map import SIDE
from system.openspace.picture import draw_discs, draw_path, draw_sight

FRAMES = 150  # first pings that are shown; ours
HALF = 7.0  # m that are shown to each side of the bat; ours
RATE = 10  # frames a second: twice real time at 5 Hz; ours
_TAIL = 60  # pings of the path that are shown


def check_animation(path: str) -> None:
    """Raise before anything is computed if no animation can be written to `path`.

    Raises `ParameterError` for another suffix than .gif, `DataError` where there is no such folder.
    """
    if Path(path).suffix.lower() != ".gif":
        raise ParameterError(f"animate: {path}, must end with .gif; choose another name")
    check_folder(path)


def save_animation(path: str, bat: Bat, run: Run, end: str = "", frames: int = FRAMES) -> int:
    """Write the first pings of a bat's run; returns how many frames there are.

    end: what the frame of the run's last ping says, empty where the run goes on after it.
    """
    log = run.log[:frames]
    figure = Figure(figsize=(4.6, 4.8), dpi=80, layout="constrained")
    FigureCanvasAgg(figure)
    ax = figure.subplots()
    place = _around(run.forest.place)

    def frame(k: int) -> tuple[Any, ...]:
        ax.clear()
        last = end if k + 1 == len(run.log) else ""
        _draw(bat, place, log, k, ax, last)
        return ()

    shown = animation.FuncAnimation(figure, frame, frames=len(log), blit=False)
    shown.save(path, writer=animation.PillowWriter(fps=RATE))
    return len(log)


def _draw(bat: Bat, place: F64, log: F64, k: int, ax: Axes, end: str) -> None:
    """Fill the axes with one ping."""
    time, x, y, heading = log[k, :4]
    near = np.abs(place - np.array([x, y])).max(axis=1) < HALF + bat.zone
    draw_discs(place[near], bat.zone, ax)
    draw_path(_unbroken(log[max(0, k - _TAIL) : k + 1, 1:3]), ax, 1.2)
    draw_sight(bat, arcs_of(bat), (x, y, heading), int(log[k, 4]), int(log[k, 5]), ax)
    ax.plot(x, y, marker="o", color="red", markersize=4, zorder=5)
    ax.set(xlim=(x - HALF, x + HALF), ylim=(y - HALF, y + HALF), xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal")
    title = f"{time:.1f} s{', scanning' if log[k, 7] else ''}"
    ax.set_title(f"{title}\n{end}" if end else title, fontsize=9)


def _unbroken(path: F64) -> F64:
    """A path on the torus without jumps, which ends where the bat is, float64[n, 2], m."""
    steps = np.diff(path, axis=0)
    steps -= SIDE * np.round(steps / SIDE)
    back = np.concatenate([np.cumsum(steps[::-1], axis=0)[::-1], np.zeros((1, 2))])
    return np.asarray(path[-1] - back)


def _around(place: F64) -> F64:
    """Obstacles and their copies in the eight neighbouring tori."""
    shifts = SIDE * np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    return np.asarray((place[None] + shifts[:, None]).reshape(-1, 2))
