"""Picture of a run of the Pushbot, like Figures 6, 8, 10 and 15 of Milde et al. 2017.

Path from above; below it what the sensor sent in 0.5 s before some moments; then spikes of the obstacle and
drive populations, of the target field where it has fired, and the commands by equations (1) and (2).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from shapely.geometry import Polygon

from chips.rolls.chip import Inputs
from chips.rolls.program.address import NEURONS
from circuits.arrays import F64, I64
from circuits.silicon.course import Points
from system.plot import COLOURS, INK, PALE, entitle, silicon_text
from system.pushbot.drive import Run
from system.pushbot.loop import Brain, Record, all_events, all_spikes, rates
from system.pushbot.readout import LOOK
from system.pushbot.scene_picture import draw_events, draw_events_key, draw_key, draw_path, draw_scene, ink_of
from system.pushbot.wiring import merged, obstacle_inputs, target_inputs
from system.view.film import Eye, Film, Group, Line, Panel, Raster, Shape, Stage, Track, busiest
from system.view.rolls import Heard, neuron_inside
from system.worlds.arena.geometry import Obstacles, obstacles_of, outline_at, robot_outline
from system.worlds.arena.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FRAMES = 4
FRAME = 0.5  # s of events in a frame; the paper's
_FRAME_STEP = 50e-3  # s between the places of a body that moves
_DECIDING = ("DL", "DR", "sp", "OL", "OR")  # populations of which neurons are looked into unless asked
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


def film_of(scene: Scene, drive: Run, brain: Brain, record: Record, asked: tuple[str, ...] | None) -> Film:
    """Return the film of a drive with what is inside the neurons that are asked for.

    Parameters
    ----------
    scene, drive, brain, record
        World, robot, chip and what was kept.
    asked
        Names of neurons, as `neuron[12]`; None for those of the deciding populations that spike most.

    Raises
    ------
    UnknownNameError
        A name is no neuron's.
    """
    path = np.array(drive.path)
    end = float(path[-1, 0])
    times, neurons = all_spikes(record)
    order = np.argsort(times, kind="stable")
    times, neurons = times[order], neurons[order]
    events = all_events(record)
    network = brain.network
    names = [f"neuron[{k}]" for k in range(NEURONS)]
    drives = np.concatenate([np.array(network[n].neurons) for n in _DECIDING])
    chosen = busiest(names, neurons[np.isin(neurons, drives)], asked)
    rate_time, rate = rates(network, record, max(end, LOOK))
    commands = np.array(record.commands, dtype=np.float64).reshape(-1, 3)
    panels = [Panel(title="neurons by their populations", raster=_rows(brain, times, neurons))]
    panels.append(
        Panel(
            title="mean rate of a neuron",
            unit="Hz",
            lines=tuple(
                Line(name=n, time=rate_time, value=rate[n], step=True) for n in _DECIDING if n in rate
            ),
        )
    )
    for k, name in enumerate(("forward", "turn")):
        line = Line(name=name, time=commands[:, 0], value=commands[:, 1 + k], step=True)
        panels.append(Panel(title=f"command: {name}", unit="spikes a neuron x factor", lines=(line,)))
    eye = Eye(name="camera", columns=128, rows=128, time=events.time, x=events.x, y=events.y, on=events.on)
    return Film(
        title="", headline="", duration=end, world=_world(scene, path), panels=tuple(panels), eye=eye,
        neurons=tuple(
            neuron_inside(brain.chip, name, None if asked is None else _heard(brain, record))
            for name in chosen
        ),
    )  # fmt: skip


def _heard(brain: Brain, record: Record) -> Heard | None:
    """What the neurons of a drive got; None where that was not the camera's events alone."""
    if brain.turning is not None or brain.frame is not None or brain.strong is not None:
        return None
    times, neurons = all_spikes(record)
    order, events = np.argsort(times, kind="stable"), all_events(record)

    def inputs(first: float, last: float) -> Inputs:
        seen = events.where((events.time >= first) & (events.time < last))
        parts = [obstacle_inputs(brain.network, seen, brain.wiring, brain.synapses)]
        if brain.target:
            parts.append(target_inputs(brain.network, seen, brain.synapses))
        return merged(parts)

    return Heard(times[order], neurons[order], inputs)


def _rows(brain: Brain, times: F64, neurons: I64) -> Raster:
    """Spikes of all populations' neurons, a row each, the first population on top."""
    rows: list[str] = []
    groups: list[Group] = []
    place = np.full(NEURONS, -1)
    for population in brain.network.populations:
        new = [k for k in population.neurons if place[k] < 0]
        if new:
            groups.append(Group(population.name, len(rows), len(new)))
            place[new] = len(rows) + np.arange(len(new))
            rows += [f"neuron[{k}]" for k in new]
    row = place[neurons]
    return Raster(time=times[row >= 0], row=row[row >= 0], rows=tuple(rows), groups=tuple(groups))


def _world(scene: Scene, path: F64) -> Stage:
    obstacles = obstacles_of(scene)
    shapes = [Shape(role="floor", points=tuple(scene.corners))]
    shapes += [Shape(role="shade", points=tuple(shade.corners)) for shade in scene.shades]
    shapes += [Shape(role="wall", points=tuple(line), closed=False) for line in scene.partitions]
    tracks = [
        Track(
            name="Pushbot", time=path[:, 0], x=path[:, 1], y=path[:, 2], heading=np.unwrap(path[:, 3]),
            outline=_corners(robot_outline((0.0, 0.0, 0.0))), radius=0.03,
        )
    ]  # fmt: skip
    for k, body in enumerate(scene.bodies):
        if body.motion is None:
            shapes.append(
                Shape(
                    role="obstacle",
                    points=_corners(outline_at(obstacles, k, 0.0)),
                    colour=ink_of(body.reflectance),
                    name=body.name,
                )
            )
            continue
        tracks.append(_moving(obstacles, k, body.name, float(path[-1, 0])))
    return Stage(unit="m", shapes=tuple(shapes), tracks=tuple(tracks))


def _moving(obstacles: Obstacles, k: int, name: str, end: float) -> Track:
    """The way of a body that moves."""
    time = np.arange(0.0, end + _FRAME_STEP, _FRAME_STEP)
    places = np.array([outline_at(obstacles, k, float(t)).centroid.coords[0] for t in time])
    middle = places[0]
    outline = tuple((x - middle[0], y - middle[1]) for x, y in _corners(outline_at(obstacles, k, 0.0)))
    return Track(name=name, time=time, x=places[:, 0], y=places[:, 1], outline=outline, role="moving")


def _corners(polygon: Polygon) -> tuple[tuple[float, float], ...]:
    return tuple((float(x), float(y)) for x, y in polygon.exterior.coords[:-1])
