"""Picture of a run of the Pushbot, like Figures 6, 8, 10 and 15 of Milde et al. 2017.

Path from above; below it what the sensor sent in 0.5 s before some moments; then spikes of the obstacle and
drive populations, of the target field where it has fired, and the commands by equations (1) and (2).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from circuits.arrays import F64, I64
from circuits.silicon.course import Points
from system.plot import COLOURS, INK, PALE, entitle, silicon_text
from system.pushbot.drive import Run
from system.pushbot.loop import Brain, Record, all_events, all_spikes
from system.pushbot.scene_picture import draw_events, draw_events_key, draw_key, draw_path, draw_scene
from system.worlds.arena.scene import Scene

FRAMES = 4
FRAME = 0.5  # s of events in a frame; the paper's
_SHADES = {"OL": COLOURS[1], "DL": COLOURS[1], "OR": COLOURS[0], "DR": COLOURS[0], "sp": "#666666",
           "GL": COLOURS[1], "GR": COLOURS[0], "target": COLOURS[2]}  # fmt: skip
_MEANT = {"OL": "obstacle left", "OR": "obstacle right", "DL": "drive left", "DR": "drive right",
          "sp": "speed", "GL": "gyro left", "GR": "gyro right", "target": "target field"}  # fmt: skip


def draw_run(
    scene: Scene, drive: Run, brain: Brain, record: Record, ended: str, figure: Figure, course: Points = ()
) -> None:
    """Fill a figure with a run; its title has how it ended, and the temperatures of a course."""
    path = np.array(drive.path)
    end = float(path[-1, 0])
    times, neurons = all_spikes(record)
    moments = _moments(brain, times, neurons, end)
    field = bool(np.isin(neurons, brain.network["target"].neurons).any())
    frames = [f"frame{k}" for k in range(FRAMES)]
    rows: list[Any] = [[name] * FRAMES for name in ("above", "paths", "key", "raster")]
    rows.insert(2, frames)
    heights = [2.2, 0.12, 1.1, 0.12, 1.9]
    if field:
        rows.append(["field"] * FRAMES)
        heights.append(1.1)
    rows.append(["commands"] * FRAMES)
    figure.set_size_inches(8.0, 1.75 * sum(heights) + 1.8)
    axes = figure.subplot_mosaic(rows, height_ratios=[*heights, 1.0])
    above, chip = axes["above"], brain.chip
    draw_scene(scene, above, end)
    draw_path(path, above, moments)
    draw_key(above, axes["paths"])
    said = f"{scene.name}: {scene.summary}" if scene.summary else scene.name
    silicon = chip.silicon
    on = silicon_text(silicon.die, silicon.temperature_c, chip.kind, course, silicon.process.effects)
    entitle(f"{said}; {end:.3g} s\nROLLS on {on}\n{ended}", above)
    _frames(record, moments, axes)
    draw_events_key(axes["key"])
    known = {p.name for p in brain.network.populations}
    names = [n for n in ("OL", "OR", "DL", "DR", "sp", "GL", "GR") if n in known]
    _raster(brain, names, times, neurons, axes["raster"])
    if field:
        _raster(brain, ["target"], times, neurons, axes["field"])
    _commands(record, axes["commands"])
    for name in ("raster", "field", "commands"):
        if name in axes:
            axes[name].set_xlim(0.0, end)
            for k, moment in enumerate(moments):
                axes[name].axvline(moment, color=PALE, linewidth=0.8, zorder=0)
                if name == "raster":
                    axes[name].annotate(str(k + 1), (moment, 1.0), (0, 2), xycoords=("data", "axes fraction"),
                                        textcoords="offset points", ha="center", fontsize=8)  # fmt: skip
    axes["commands"].set_xlabel("time (s)")


def _moments(brain: Brain, times: F64, neurons: I64, end: float) -> list[float]:
    """Moments spread over what the drives do, or over the run where they do nothing, s."""
    drives = [*brain.network["DL"].neurons, *brain.network["DR"].neurons]
    active = np.sort(times[np.isin(neurons, drives)])
    first = float(active[active.size // 50]) if active.size else 0.0
    first = max(first if active.size else end / FRAMES, min(FRAME, end))
    return [float(t) for t in np.linspace(first, end, FRAMES)]


def _frames(record: Record, moments: list[float], axes: dict[str, Axes]) -> None:
    events = all_events(record)
    for k, moment in enumerate(moments):
        ax = axes[f"frame{k}"]
        inside = events.where((events.time > moment - FRAME) & (events.time <= moment))
        draw_events(inside, 128, 128, ax)
        ax.set_title(f"{k + 1}: {moment:.3g} s, {len(inside)} events", fontsize=8)


def _raster(brain: Brain, names: Sequence[str], times: F64, neurons: I64, ax: Axes) -> None:
    """Dots of spikes, a row a neuron, populations named at the left."""
    base, ticks = 0, []
    for name in reversed(names):
        members = np.array(brain.network[name].neurons)
        place = np.full(256, -1)
        place[members] = np.arange(members.size)
        mine = place[neurons]
        shown = mine >= 0
        ax.plot(times[shown], base + mine[shown], linestyle="", marker=",", color=_SHADES[name])
        ax.axhline(base - 0.5, color=PALE, linewidth=0.4)
        ticks.append((base + 0.5 * members.size, f"{name}\n{_MEANT[name]}"))
        base += members.size
    ax.set_yticks([t for t, _ in ticks], [n for _, n in ticks], fontsize=8)
    ax.set_ylim(-0.5, base - 0.5)


def _commands(record: Record, ax: Axes) -> None:
    if not record.commands:
        return
    time, forward, turn = np.array(record.commands).T
    ax.step(time, forward, where="post", color=INK, linewidth=1.0, label="v, forward")
    label = "w, turn: above 0 to the left"
    ax.step(time, turn, where="post", color=COLOURS[1], linewidth=1.0, linestyle="--", label=label)
    ax.set_ylabel("command\n(spikes a neuron x factor)")
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, fontsize=8, borderpad=0.0)
