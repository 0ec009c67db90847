"""Scene files: a world for a small robot in TOML, which a user can write.

    summary = "text"                                light = "normal" | "dark" | "very-dark" | lux
    floor = "white"                                 sky = "white"
    start = { at = [x, y], heading_deg = 0 }        duration = s of a run, as the robot needs unless given
    [arena]    size = [x, y] or corners = [[x, y], ...]; wall_height; wall_colour; seed;
               tape = false or { low, high, cell, dark, pale, seed }; room = m to the room's walls, 0: none
    [[wall]]   corners = [[x, y], ...] along it, height, colour, tape as of the arena
    [[block]]  at, size = [length, width], height, base, colour, heading_deg, motion
    [[cup]]    at, diameter, height, base, colour, motion
    [[robot]]  at, heading_deg, colour, tracks = colour of both, led = true or { height, diameter, luminance,
               period, on }, motion
    [[person]] at, heading_deg, colour, motion      two legs
    [[table]]  at, size, heading_deg, colour, height, shade = share of the light below it
    [[chair]]  at, heading_deg, colour              a seat on a foot
    [[shade]]  corners = [[x, y], ...], factor
    [clutter]  count = n or [from, to], size, height, colours, spacing = m between any two,
               clear = m about the start
    motion = { path = [[x, y], ...], speed, start, repeat = "stop" | "shuttle" | "loop" }

Lengths are in m, times in s. Colours are names of `system.worlds.arena.scene.COLOURS` or reflectances from 0
to 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np

from circuits.errors import DataError, ParameterError, UnknownNameError, unknown_name
from system.files.document import toml_file
from system.table import read_table
from system.worlds.arena.furniture import block, chair, cup, desk, person, robot
from system.worlds.arena.geometry import check_scene
from system.worlds.arena.scene import Body, Point, Scene, Shade, Tape, Wall, backdrop, light_of, scatter
from system.worlds.arena.tables import ArenaTable, ClutterTable, SceneTable

T = TypeVar("T")

SCENES = Path(__file__).parent / "scenes"
_MARGIN = 0.2  # m that clutter keeps from the walls; ours


def scene_names() -> list[str]:
    """Return the names of the scenes that come with the package."""
    return sorted(path.stem for path in SCENES.glob("*.toml"))


def load_scene(name: str, *, seed: int = 0, light: str | None = None) -> Scene:
    """Return a scene by its name, or that of a file whose name ends with .toml.

    Parameters
    ----------
    name
        Name of one of noctule's scenes, or of a file.
    seed
        Seed of what the scene leaves to chance, the clutter.
    light
        A condition, or text such as `500lux`, instead of the scene's.

    Raises
    ------
    UnknownNameError
        No scene has the name.
    DataError
        The file cannot be read, or is no scene: the text names file and key.
    """
    if not name.endswith(".toml") and name not in scene_names():
        raise UnknownNameError(f"{unknown_name('scene', name, scene_names())}; or a file as own.toml")
    path = Path(name) if name.endswith(".toml") else SCENES / f"{name}.toml"
    content = toml_file(path)
    try:
        scene = _scene(path.stem, read_table(SceneTable, content), seed, light)
        check_scene(scene)
    except ParameterError as error:
        raise DataError(f"{path.name}: {error}") from None
    return scene


def _scene(name: str, top: SceneTable, seed: int, light: str | None) -> Scene:
    arena, start = top.arena, top.start
    corners = _corners(arena)
    below = (Shade(_rectangle(d.at, d.size, d.heading), d.shade) for d in top.desks if d.shade < 1.0)
    return Scene(
        name=name,
        summary=top.summary,
        light=light_of(top.light if light is None else light),
        corners=corners,
        start=(*start.at, start.heading),
        bodies=(*_bodies(top), *_clutter(top.clutter, corners, start.at, seed)),
        walls=_walls(arena, corners)
        + tuple(plane for w in top.walls for plane in _along(w.corners, w.height, w.colour, w.tape)),
        shades=(*top.shades, *below),
        floor=top.floor,
        sky=top.sky,
        partitions=tuple(w.corners for w in top.walls),
        duration=top.duration,
    )


def _corners(arena: ArenaTable) -> tuple[Point, ...]:
    if (arena.size is None) == (arena.corners is None):
        raise ParameterError("arena: must have either size = [x, y] or corners = [[x, y], ...]")
    if arena.size is None:
        return arena.corners or ()
    x, y = arena.size
    return (0.0, 0.0), (x, 0.0), (x, y), (0.0, y)


def _walls(arena: ArenaTable, corners: tuple[Point, ...]) -> tuple[Wall, ...]:
    walls: tuple[Wall, ...] = ()
    if arena.wall_height > 0.0:
        walls = _along((*corners, corners[0]), arena.wall_height, arena.wall_colour, arena.tape)
    return walls + (backdrop(corners, arena.room, arena.seed) if arena.room > 0.0 else ())


def _along(
    corners: tuple[Point, ...], height: float, colour: float, tape: Tape | Literal[False]
) -> tuple[Wall, ...]:
    """Planes from corner to corner, each with a texture of its own."""
    return tuple(
        Wall(start, end, height, colour, replace(tape, seed=tape.seed + 7 * k) if tape else None)
        for k, (start, end) in enumerate(pairwise(corners))
    )


def _bodies(top: SceneTable) -> Iterator[Body]:
    yield from _each("block", top.blocks, block)
    yield from _each("cup", top.cups, cup)
    yield from _each("robot", top.robots, robot)
    yield from _each("person", top.people, person)
    yield from _each("table", top.desks, desk)
    yield from _each("chair", top.chairs, chair)


def _each(key: str, tables: Iterable[T], make: Callable[[str, T], list[Body]]) -> Iterator[Body]:
    """Bodies of an array of tables, named after its key."""
    for k, table in enumerate(tables):
        yield from make(f"{key}[{k}]", table)


def _clutter(
    wanted: ClutterTable | None, corners: tuple[Point, ...], start: Point, seed: int
) -> Iterator[Body]:
    if wanted is None:
        return
    random = np.random.default_rng((seed, 1))
    (left, low), (right, high) = np.array(corners).min(axis=0), np.array(corners).max(axis=0)
    bounds = (left + _MARGIN, low + _MARGIN), (right - _MARGIN, high - _MARGIN)
    least, most = wanted.counts
    count = int(random.integers(least, most + 1))
    places = scatter(random, count, bounds, wanted.spacing, start, wanted.clear)
    for k, (x, y) in enumerate(places):
        colour = wanted.colours[int(random.integers(len(wanted.colours)))]
        heading = float(random.uniform(0.0, math.pi))
        yield Body(f"block[{k}]", (float(x), float(y)), wanted.size, wanted.height, colour, heading)


def _rectangle(at: Point, size: Point, heading: float) -> tuple[Point, ...]:
    cos, sin = math.cos(heading), math.sin(heading)
    half = [(0.5 * a * size[0], 0.5 * b * size[1]) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return tuple((at[0] + cos * x - sin * y, at[1] + sin * x + cos * y) for x, y in half)
