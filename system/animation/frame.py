"""Frames of a film: the world and the camera above, the signals below, with a cursor at the time.

All that stands still is drawn once. For a frame it is put back, and only what moves is drawn over it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from circuits.catalogue import later
from system.animation.stage import Mover, draw_eye, draw_stage
from system.plot import COLOURS, INK, PALE, STYLE, settle
from system.view.film import Film, Panel, Raster

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

matplotlib, figures, gridspec = later("matplotlib"), later("matplotlib.figure"), later("matplotlib.gridspec")
agg = later("matplotlib.backends.backend_agg")


DPI = 100.0
MOST = 5  # panels of a frame, the first of a film's; ours
Pixels = NDArray[np.uint8]
_WORLD, _PANEL = 4.0, 1.0  # heights, in relation
_SMALL = 7.0  # points, of texts in a panel
_FEW = 40  # rows of a raster whose events are lines, not dots


@dataclass(frozen=True, slots=True)
class Reel:
    """A film that is drawn, ready to be brought to any time.

    canvas : matplotlib's of Agg. still : what stands still. movers : what moves, the last on top.
    """

    canvas: Any  # matplotlib's own has no types for what is asked of it here
    still: Any
    movers: Sequence[Mover]

    def frame(self, t: float) -> Pixels:
        """The film at a time (s), uint8[height, width, 3]: red, green and blue."""
        self.canvas.restore_region(self.still)
        renderer = self.canvas.get_renderer()
        for artists, move in self.movers:
            move(t)
            for artist in artists:
                artist.draw(renderer)
        return np.array(self.canvas.buffer_rgba())[..., :3]


def begin_reel(film: Film, width: int, height: int, speed: float) -> Reel:
    """Draw what stands still of a film, in pixels; speed: over that of the run, which a frame says."""
    with matplotlib.rc_context(STYLE):
        figure = figures.Figure(figsize=(width / DPI, height / DPI), dpi=DPI, layout="constrained")
        canvas: Any = agg.FigureCanvasAgg(figure)
        movers = _draw(film, figure)
        pace = "" if speed == 1.0 else f", at {speed:g} times its speed"
        figure.suptitle(film.title, fontsize=9.0, x=0.01, ha="left")
        clock = figure.text(0.99, 0.985, "", ha="right", va="top", fontsize=9.0, color=INK)
        end = figure.text(0.99, 0.955, "", ha="right", va="top", fontsize=8.0, color=COLOURS[1])

        def tell(t: float) -> None:
            clock.set_text(f"{t:.2f} s of {film.duration:.4g} s{pace}")
            end.set_text(film.headline if t >= film.duration else "")

        movers.append(((clock, end), tell))
        settle(figure)
        for artists, _ in movers:
            for artist in artists:
                artist.set_animated(True)
        canvas.draw()
    return Reel(canvas, canvas.copy_from_bbox(figure.bbox), movers)


def _draw(film: Film, figure: Figure) -> list[Mover]:
    panels = film.panels[:MOST]
    heights = [_WORLD] * (film.world is not None or film.eye is not None) + [_PANEL] * len(panels)
    grid = gridspec.GridSpec(max(len(heights), 1), 1, figure=figure, height_ratios=heights or [1.0])
    movers: list[Mover] = []
    if film.world is not None or film.eye is not None:
        wide = [3.0] * (film.world is not None) + [1.4] * (film.eye is not None)
        above = grid[0].subgridspec(1, len(wide), width_ratios=wide)
        if film.world is not None:
            movers += draw_stage(film.world, figure.add_subplot(above[0]))
        if film.eye is not None:
            movers.append(draw_eye(film.eye, figure.add_subplot(above[-1])))
    for k, panel in enumerate(panels):
        ax = figure.add_subplot(grid[len(heights) - len(panels) + k])
        movers.append(_draw_panel(panel, film.duration, ax))
        ax.tick_params(labelsize=_SMALL, labelbottom=k == len(panels) - 1)
        if k == len(panels) - 1:
            ax.set_xlabel("time (s)", fontsize=_SMALL + 1.0)
    return movers


def _draw_panel(panel: Panel, duration: float, ax: Axes) -> Mover:
    unit = f" ({panel.unit})" if panel.unit else ""
    ax.set_title(f"{panel.title}{unit}", fontsize=_SMALL + 1.0, loc="left", pad=2.0)
    for k, line in enumerate(panel.lines):
        style = "steps-post" if line.step else "default"
        colour = COLOURS[k % len(COLOURS)]
        ax.plot(line.time, line.value, color=colour, linewidth=1.1, drawstyle=style, label=line.name)
    if len(panel.lines) > 1:
        ax.legend(
            fontsize=_SMALL, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=8, borderaxespad=0.0,
            handlelength=1.2, columnspacing=1.0,
        )  # fmt: skip
    if panel.raster is not None:
        _draw_raster(panel.raster, ax)
    ax.set_xlim(0.0, duration)
    (cursor,) = ax.plot(
        [0.0, 0.0], [0.0, 1.0], color="#C00000", linewidth=1.0, transform=ax.get_xaxis_transform()
    )
    veil = ax.axvspan(0.0, duration, color="white", alpha=0.7, linewidth=0.0)  # over what is to come

    def move(t: float) -> None:
        cursor.set_xdata([t, t])
        veil.set_x(t)
        veil.set_width(max(0.0, duration - t))

    return (veil, cursor), move


def _draw_raster(raster: Raster, ax: Axes) -> None:
    rows = len(raster.rows)
    if rows <= _FEW:
        low, high = raster.row - 0.4, raster.row + 0.4
        ax.vlines(raster.time, low, high, color=INK, linewidth=0.6)
    else:
        ax.plot(raster.time, raster.row, linestyle="", marker=",", color=INK)
    for group in raster.groups:
        ax.axhline(group.first - 0.5, color=PALE, linewidth=0.5)
    named = {g.first + 0.5 * (g.count - 1): g.name for g in raster.groups if g.count > rows / 12.0}
    if not raster.groups and rows <= 4:
        named = dict(enumerate(raster.rows))
    ax.set_yticks(list(named), list(named.values()))
    ax.set_ylim(rows - 0.5, -0.5)
