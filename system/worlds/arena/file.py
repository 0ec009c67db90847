"""Scene files: TOML that a user can write.

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
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from circuits.errors import DataError, ParameterError, unknown_name
from system.files.document import document_bytes, from_toml
from system.worlds.arena.furniture import chair, person, robot, table
from system.worlds.arena.geometry import check_scene
from system.worlds.arena.keys import taken
from system.worlds.arena.scene import Body, Point, Scene, Shade, Tape, Wall, backdrop, light_of, scatter
from system.worlds.arena.tables import TOP

SCENES = Path(__file__).parent / "scenes"
_MARGIN = 0.2  # m that clutter keeps from the walls; ours


def scene_names() -> list[str]:
    """Names of the scenes that come with the package."""
    return sorted(path.stem for path in SCENES.glob("*.toml"))


def load_scene(name: str, *, seed: int = 0, light: str | None = None) -> Scene:
    """Scene by name, or of a file whose name ends with .toml.

    Parameters
    ----------
    seed : of what the scene leaves to chance, the clutter.
    light : a condition, or text such as `500lux`, instead of the scene's.

    Raises
    ------
    UnknownNameError
        No scene has the name.
    DataError
        The file cannot be read, or is no scene: the text names file and key.
    """
    if not name.endswith(".toml") and name not in scene_names():
        raise unknown_name("scene", name, [*scene_names(), "or a file FILE.toml"])
    path = Path(name) if name.endswith(".toml") else SCENES / f"{name}.toml"
    table = _parsed(path)
    try:
        scene = _scene(path.stem, table, seed, light)
        check_scene(scene)
    except ParameterError as error:
        raise DataError(f"{path.name}: {error}") from None
    return scene


def _parsed(path: Path) -> dict[str, Any]:
    remedy = "must be TOML in UTF-8"
    try:
        return from_toml(document_bytes(path, remedy), dict[str, Any], str(path), remedy)
    except FileNotFoundError as error:
        raise DataError(f"{path}: {error.strerror}, must be a readable file; check the path") from None


def _scene(name: str, content: dict[str, Any], seed: int, light: str | None) -> Scene:
    top = taken(content, "", TOP)
    arena, start = top["arena"], top["start"]
    corners = _corners(arena)
    bodies, shades = list(_bodies(top)), [Shade(s["corners"], s["factor"]) for s in top["shade"]]
    shades += [
        Shade(_rectangle(t["at"], t["size"], t["heading_deg"]), t["shade"])
        for t in top["table"]
        if t["shade"] < 1.0
    ]
    if top["clutter"] is not None:
        bodies += _clutter(top["clutter"], corners, start["at"], seed)
    return Scene(
        name=name,
        summary=top["summary"],
        light=light_of(top["light"] if light is None else light),
        corners=corners,
        start=(*start["at"], start["heading_deg"]),
        bodies=tuple(bodies),
        walls=_walls(arena, corners)
        + tuple(plane for k, w in enumerate(top["wall"]) for plane in _planes(k, w)),
        shades=tuple(shades),
        floor=top["floor"],
        sky=top["sky"],
        partitions=tuple(w["corners"] for w in top["wall"]),
        duration=top["duration"],
    )


def _corners(arena: dict[str, Any]) -> tuple[Point, ...]:
    if (arena["size"] is None) == (arena["corners"] is None):
        raise ParameterError("arena: must have either size = [x, y] or corners = [[x, y], ...]")
    if arena["size"] is None:
        corners: tuple[Point, ...] = arena["corners"]
        return corners
    x, y = arena["size"]
    return (0.0, 0.0), (x, 0.0), (x, y), (0.0, y)


def _walls(arena: dict[str, Any], corners: tuple[Point, ...]) -> tuple[Wall, ...]:
    tape, height = arena["tape"], arena["wall_height"]
    walls: tuple[Wall, ...] = ()
    if height > 0.0:
        _check_tape("arena.tape.high", tape, "wall_height", height)
        walls = _along((*corners, corners[0]), height, arena["wall_colour"], tape)
    return walls + (backdrop(corners, arena["room"], arena["seed"]) if arena["room"] > 0.0 else ())


def _planes(k: int, wall: dict[str, Any]) -> tuple[Wall, ...]:
    """Planes of wall k inside the arena."""
    _check_tape(f"wall[{k}].tape.high", wall["tape"], "height", wall["height"])
    for i, (a, b) in enumerate(pairwise(wall["corners"])):
        if a == b:
            raise ParameterError(
                f"wall[{k}].corners[{i + 1}]: {list(b)}, must not be the one before; drop it"
            )
    return _along(wall["corners"], wall["height"], wall["colour"], wall["tape"])


def _along(corners: tuple[Point, ...], height: float, colour: float, tape: Tape | None) -> tuple[Wall, ...]:
    """Planes from corner to corner, each with a texture of its own."""
    return tuple(
        Wall(start, end, height, colour, None if tape is None else replace(tape, seed=tape.seed + 7 * k))
        for k, (start, end) in enumerate(pairwise(corners))
    )


def _check_tape(path: str, tape: Tape | None, name: str, height: float) -> None:
    if tape is not None and height < tape.high:
        raise ParameterError(f"{path}: {tape.high:g} m, must not be above {name}, {height:g} m")


def _bodies(top: dict[str, Any]) -> Iterator[Body]:
    for k, b in enumerate(top["block"]):
        yield Body(
            f"block[{k}]",
            b["at"],
            b["size"],
            b["height"],
            b["colour"],
            b["heading_deg"],
            b["base"],
            motion=b["motion"],
        )
    for k, c in enumerate(top["cup"]):
        yield Body(
            f"cup[{k}]", c["at"], (c["diameter"], c["diameter"]), c["height"], c["colour"], base=c["base"],
            is_round=True, motion=c["motion"],
        )  # fmt: skip
    for k, r in enumerate(top["robot"]):
        yield from robot(
            f"robot[{k}]", r["at"], r["heading_deg"], r["colour"], r["led"], r["motion"], r["tracks"]
        )
    for k, p in enumerate(top["person"]):
        yield from person(f"person[{k}]", p["at"], p["heading_deg"], p["colour"], p["motion"])
    for k, t in enumerate(top["table"]):
        yield from table(f"table[{k}]", t["at"], t["size"], t["heading_deg"], t["colour"], t["height"])
    for k, c in enumerate(top["chair"]):
        yield from chair(f"chair[{k}]", c["at"], c["heading_deg"], c["colour"])


def _clutter(wanted: dict[str, Any], corners: tuple[Point, ...], start: Point, seed: int) -> list[Body]:
    random = np.random.default_rng((seed, 1))
    (left, low), (right, high) = np.array(corners).min(axis=0), np.array(corners).max(axis=0)
    bounds = (left + _MARGIN, low + _MARGIN), (right - _MARGIN, high - _MARGIN)
    least, most = wanted["count"]
    count = int(random.integers(least, most + 1))
    places = scatter(random, count, bounds, wanted["spacing"], start, wanted["clear"])
    return [
        Body(
            f"block[{k}]", (float(x), float(y)), wanted["size"], wanted["height"],
            wanted["colours"][int(random.integers(len(wanted["colours"])))],
            float(random.uniform(0.0, math.pi)),
        )
        for k, (x, y) in enumerate(places)
    ]  # fmt: skip


def _rectangle(at: Point, size: Point, heading: float) -> tuple[Point, ...]:
    cos, sin = math.cos(heading), math.sin(heading)
    half = [(0.5 * a * size[0], 0.5 * b * size[1]) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return tuple((at[0] + cos * x - sin * y, at[1] + sin * x + cos * y) for x, y in half)
