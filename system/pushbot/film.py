"""A drive of the Pushbot as a film: scene, camera, the chip's populations, commands, and neurons' devices."""

from __future__ import annotations

import numpy as np
from shapely.geometry import Polygon

from chips.rolls.program.address import NEURONS
from circuits.arrays import F64, I64
from system.pushbot.drive import Run
from system.pushbot.loop import Brain, Record, all_events, all_spikes, rates
from system.pushbot.readout import LOOK
from system.pushbot.scene_picture import ink_of
from system.view.film import Eye, Film, Group, Line, Panel, Raster, Shape, Stage, Track, busiest
from system.view.rolls import neuron_inside
from system.worlds.arena.geometry import Obstacles, obstacles_of, outline_at, robot_outline
from system.worlds.arena.scene import Scene

_FRAMES = 50e-3  # s between the places of a body that moves
_DECIDING = ("DL", "DR", "sp", "OL", "OR")  # populations of which neurons are looked into unless asked


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
    panels = [Panel(title="neurons by their populations", raster=_raster(brain, times, neurons))]
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
        neurons=tuple(neuron_inside(brain.chip, name) for name in chosen),
    )  # fmt: skip


def _raster(brain: Brain, times: F64, neurons: I64) -> Raster:
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
                )
            )
            continue
        tracks.append(_moving(obstacles, k, body.name, float(path[-1, 0])))
    return Stage(unit="m", shapes=tuple(shapes), tracks=tuple(tracks))


def _moving(obstacles: Obstacles, k: int, name: str, end: float) -> Track:
    """The way of a body that moves."""
    time = np.arange(0.0, end + _FRAMES, _FRAMES)
    places = np.array([outline_at(obstacles, k, float(t)).centroid.coords[0] for t in time])
    middle = places[0]
    outline = tuple((x - middle[0], y - middle[1]) for x, y in _corners(outline_at(obstacles, k, 0.0)))
    return Track(name=name, time=time, x=places[:, 0], y=places[:, 1], outline=outline, role="moving")


def _corners(polygon: Polygon) -> tuple[tuple[float, float], ...]:
    return tuple((float(x), float(y)) for x, y in polygon.exterior.coords[:-1])
