"""Pictures of the spike-latency network: scene, spikes of its layers, membranes of a unit (Figure 12)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import F64
from system.openspace.law import ARCS, DIRECTIONS, MIDDLE, Bat
from system.openspace.picture import draw_forest, draw_sight
from system.plot import COLOURS, INK, PALE
from system.spiking_bat.scene import Story

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Places = Sequence[tuple[float, float]]

_LAYERS = (("out", COLOURS[0], "memory", 9), ("wta1", COLOURS[1], "first layer", 26),
           ("wta2", INK, "second layer", 12), ("body", COLOURS[2], "body motor", 9))  # fmt: skip
_UNIT = ("A", "B", "CD", "INH", "integrating")


def draw_figure_12(story: Story, race: Sequence[F64], obstacles: Places, bat: Bat, figure: Figure) -> None:
    """Fill a figure with panels A, B and C; race: latencies without recurrent inhibition at each ping, s."""
    figure.set_size_inches(9.0, 9.6)
    grid = figure.add_gridspec(3, 2, height_ratios=(1.5, 1.5, 1.6))
    scenes = [figure.add_subplot(grid[0, k]) for k in range(2)]
    for k, ax in enumerate(scenes):
        draw_scene(story, k, obstacles, bat, ax)
    figure.legend(*scenes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, fontsize=8)
    draw_raster(story, race, figure.add_subplot(grid[1, :]))
    inner = grid[2, :].subgridspec(len(_UNIT), 1, hspace=0.1)
    _draw_unit(story, [figure.add_subplot(inner[k]) for k in range(len(_UNIT))])


def draw_scene(story: Story, k: int, obstacles: Places, bat: Bat, ax: Axes) -> None:
    """Draw obstacles, arcs and field of view as they are at ping k."""
    at = 25.0
    place = np.array([(at - ahead, at - left) for ahead, left in obstacles])
    draw_forest(place, bat.zone, ax)
    answer = story.answers[k]
    head = DIRECTIONS // 2 if k == 0 or story.answers[0].head is None else story.answers[0].head
    flown = round(float(answer.arcs.mean())) if answer.arcs.size else MIDDLE
    x = at - k * float(story.arcs.speed[MIDDLE]) * story.numbers.ping_period
    draw_sight(bat, story.arcs, (x, at, -np.pi), head, flown, ax)
    ax.set_xlim(at - 5.4, at + 0.6)
    ax.set_ylim(at - 3.2, at + 3.2)
    ax.set_title(f"ping {k + 1}", fontsize=9)


def draw_raster(story: Story, race: Sequence[F64], ax: Axes) -> None:
    """Spikes of memories, both layers and body motors; in grey the race without recurrent inhibition."""
    zero = story.times[0]
    for k in range(2):
        known = race[k] < story.numbers.ping_period
        when = 1e3 * (story.times[k] - zero + race[k][known])
        mark = "without recurrent inhibition" if k == 0 else None
        ax.plot(when, np.flatnonzero(known), marker="|", color=PALE, linestyle="", markersize=6, label=mark)
        ax.axvline(1e3 * (story.times[k] - zero), color=INK, linewidth=0.6, linestyle=":")
    for name, colour, label, size in _LAYERS:
        found = [a.spikes.of(name) for a in story.answers[:2]]
        times = np.concatenate([t for t, _ in found]) - zero
        arcs = np.concatenate([p for _, p in found])
        ax.scatter(1e3 * times, arcs, s=size, color=colour, label=label, zorder=3)
    ax.set_xlim(-3.0, 2e3 * story.numbers.ping_period)
    ax.set_ylim(ARCS, -1)
    ax.set_ylabel("arc, 0 to the left")
    ax.set_xlabel("time after the first ping (ms)")
    ax.legend(fontsize=7, ncols=5, loc="lower center", bbox_to_anchor=(0.5, 1.0))


def _draw_unit(story: Story, axes: Sequence[Axes]) -> None:
    """Membranes of a latency unit over three pings."""
    traces = np.concatenate([a.traces for a in story.answers])
    time = 1e3 * story.network.wiring.step * np.arange(1, len(traces) + 1)
    arc, unit = story.watched
    for k, (name, ax) in enumerate(zip(_UNIT, axes, strict=True)):
        last = k == len(_UNIT) - 1
        ax.plot(
            time, traces[:, k] if last else 1e3 * traces[:, k], color=COLOURS[1 if last else 0], linewidth=0.8
        )
        ax.set_ylabel(name, fontsize=8, rotation=0, ha="right", va="center")
        ax.tick_params(labelsize=7, bottom=last, labelbottom=last)
        ax.set_xlim(0.0, time[-1])
        for answer in range(3):
            ax.axvline(1e2 * answer, color=PALE, linewidth=0.6, linestyle=":")
    axes[0].set_title(f"memory {arc}, unit {unit + 1}: mV; integrating: thresholds", fontsize=9)
    axes[-1].set_xlabel("time after the first ping (ms)")
