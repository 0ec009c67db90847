"""Animation of a flight through the forest: a frame a ping, with the field of view and the chosen arc.

A GIF by matplotlib's own writer. The picture follows the bat; obstacles beyond the borders are the torus's.
Layout and legend are made once: from frame to frame only places move.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import final

import matplotlib as mpl
import numpy as np
from matplotlib import animation
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.files.writing import check_folder
from system.openspace.flight import Run
from system.openspace.law import Arcs, Bat, arcs_of
from system.openspace.map import SIDE
from system.openspace.picture import Sight, draw_discs, draw_path, draw_sight, move_sight
from system.plot import STYLE, entitle, settle
from system.system import Progress

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


@final
@dataclass(frozen=True, slots=True)
class Film:
    """What moves from frame to frame: the bat's sight and way, and obstacles with their copies about it."""

    bat: Bat
    arcs: Arcs
    log: F64
    sight: Sight
    way: Line2D
    place: F64
    discs: EllipseCollection
    ax: Axes


def save_animation(
    path: str, bat: Bat, run: Run, end: str = "", frames: int = FRAMES, progress: Progress | None = None
) -> int:
    """Write the first pings of a bat's run; returns how many frames there are.

    end: what the frame of the run's last ping says, empty where the run goes on after it. progress: is told
    the share of the frames that are drawn.
    """
    log = run.log[:frames]
    writer = animation.PillowWriter(fps=RATE)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(4.8, 5.6), dpi=80, layout="constrained")
        FigureCanvasAgg(figure)
        film = begin_film(bat, run, figure, end)
        settle(figure)
        figure.set_layout_engine(None)  # the room is made: to make it anew costs as much as the frame
        with writer.saving(figure, path, figure.dpi):
            for k in range(len(log)):
                show_frame(film, k, end if k + 1 == len(run.log) else "")
                writer.grab_frame()
                if progress is not None:
                    progress((k + 1) / len(log))
    return len(log)


def begin_film(bat: Bat, run: Run, figure: Figure, end: str = "") -> Film:
    """Fill an empty figure with the first frame of a run, and its legend; end: what the last frame says."""
    ax = figure.subplots()
    log, arcs = run.log, arcs_of(bat)
    place = _around(run.forest.place)
    discs = draw_discs(place, bat.zone, ax)
    way = draw_path(log[:1, 1:3], ax, 1.2)
    sight = draw_sight(bat, arcs, tuple(log[0, 1:4]), int(log[0, 4]), int(log[0, 5]), ax)
    film = Film(bat, arcs, log, sight, way, place, discs, ax)
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal")
    show_frame(film, 0, end or "-")  # with all lines that a title may have
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)
    return film


def show_frame(film: Film, k: int, end: str = "") -> None:
    """Move all that is shown to ping `k`; end: the second line of the title."""
    log, ax = film.log, film.ax
    time, x, y, heading = log[k, :4]
    near = np.abs(film.place - np.array([x, y])).max(axis=1) < HALF + film.bat.zone
    film.discs.set_offsets(film.place[near])
    film.way.set_data(*_unbroken(log[max(0, k - _TAIL) : k + 1, 1:3]).T)
    move_sight(film.sight, film.bat, film.arcs, (x, y, heading), int(log[k, 4]), int(log[k, 5]))
    ax.set(xlim=(x - HALF, x + HALF), ylim=(y - HALF, y + HALF))
    entitle(f"{time:.1f} s{', scanning' if log[k, 7] else ''}\n{end}", ax)


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
