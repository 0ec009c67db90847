"""Keys of a scene file's tables, with what they are where not given, in m, s and degrees."""

from __future__ import annotations

import math
from typing import Any

from circuits.errors import ParameterError
from system.worlds.arena.keys import (
    REQUIRED,
    Keys,
    colour,
    colours,
    count,
    degrees,
    light,
    many,
    number,
    one,
    pair,
    points,
    taken,
    text,
    whole,
)
from system.worlds.arena.scene import COLOURS, REPEATS, Led, Motion, Tape

WALL_HEIGHT = 0.15  # m; ours: the sensor sees the room above it
ROOM = 2.5  # m from the arena to the walls of the room; ours


def _motion(value: Any, path: str) -> Motion:
    found = taken(value, path, MOTION)
    if found["repeat"] not in REPEATS:
        raise ParameterError(f"{path}.repeat: {found['repeat']}, must be one of {', '.join(REPEATS)}")
    if len(set(found["path"])) == 1:
        raise ParameterError(
            f"{path}.path: {found['path'][0]}, must lead somewhere; give two different points"
        )
    return Motion(**found)


def _led(value: Any, path: str) -> Led | None:
    if isinstance(value, bool):
        return Led() if value else None
    return Led(**taken(value, path, LED))


def _tape(value: Any, path: str) -> Tape | None:
    if value is False:
        return None
    tape = Tape(**taken(value, path, TAPE))
    if tape.low >= tape.high:
        raise ParameterError(f"{path}.low: {tape.low:g} m, must be below high, {tape.high:g} m")
    return tape


_LENGTH = number(0.0, above=True)
_FROM_ZERO = number(0.0)
_PLACE = pair(number(-math.inf))
_SIZE = pair(_LENGTH)
_SHARE = number(0.0, 1.0, above=True)
_HEADING = (degrees, 0.0)

MOTION: Keys = {
    "path": (points(2), REQUIRED),
    "speed": (_LENGTH, REQUIRED),
    "start": (_FROM_ZERO, 0.0),
    "repeat": (text, "stop"),
}
LED: Keys = {
    name: (_SHARE if name == "on" else _LENGTH, getattr(Led(), name))
    for name in ("height", "diameter", "luminance", "period", "on")
}
TAPE: Keys = {
    "low": (_FROM_ZERO, Tape().low),
    "high": (_LENGTH, Tape().high),
    "cell": (_LENGTH, Tape().cell),
    "dark": (_SHARE, Tape().dark),
    "pale": (_SHARE, Tape().pale),
    "seed": (whole, 0),
}
START: Keys = {"at": (_PLACE, REQUIRED), "heading_deg": _HEADING}
ARENA: Keys = {
    "size": (_SIZE, None),
    "corners": (points(3), None),
    "wall_height": (_FROM_ZERO, WALL_HEIGHT),
    "wall_colour": (colour, COLOURS["white"]),
    "tape": (_tape, Tape()),
    "room": (_FROM_ZERO, ROOM),
    "seed": (whole, 0),
}
_MOVED = (_motion, None)
BLOCK: Keys = {
    "at": (_PLACE, REQUIRED),
    "size": (_SIZE, REQUIRED),
    "height": (_LENGTH, REQUIRED),
    "base": (_FROM_ZERO, 0.0),
    "colour": (colour, COLOURS["blue"]),
    "heading_deg": _HEADING,
    "motion": _MOVED,
}
CUP: Keys = {
    "at": (_PLACE, REQUIRED),
    "diameter": (_LENGTH, 0.08),
    "height": (_LENGTH, 0.10),
    "base": (_FROM_ZERO, 0.0),
    "colour": (colour, COLOURS["blue"]),
    "motion": _MOVED,
}
ROBOT: Keys = {
    "at": (_PLACE, REQUIRED),
    "heading_deg": _HEADING,
    "colour": (colour, COLOURS["black"]),
    "tracks": (colour, None),
    "led": (_led, Led()),
    "motion": _MOVED,
}
PERSON: Keys = {
    "at": (_PLACE, REQUIRED),
    "heading_deg": _HEADING,
    "colour": (colour, COLOURS["black"]),
    "motion": _MOVED,
}
TABLE: Keys = {
    "at": (_PLACE, REQUIRED),
    "size": (_SIZE, REQUIRED),
    "heading_deg": _HEADING,
    "colour": (colour, COLOURS["wood"]),
    "height": (_LENGTH, 0.72),
    "shade": (_SHARE, 0.3),
}
CHAIR: Keys = {"at": (_PLACE, REQUIRED), "heading_deg": _HEADING, "colour": (colour, COLOURS["black"])}
SHADE: Keys = {"corners": (points(3), REQUIRED), "factor": (_SHARE, REQUIRED)}
CLUTTER: Keys = {
    "count": (count, REQUIRED),
    "size": (_SIZE, (0.02, 0.02)),
    "height": (_LENGTH, 0.05),
    "colours": (colours, [COLOURS["blue"]]),
    "spacing": (_LENGTH, 0.35),
    "clear": (_FROM_ZERO, 0.6),
}
WALL: Keys = {
    "corners": (points(2), REQUIRED),
    "height": (_LENGTH, WALL_HEIGHT),
    "colour": (colour, COLOURS["white"]),
    "tape": (_tape, Tape()),
}
TOP: Keys = {
    "summary": (text, ""),
    "duration": (_LENGTH, None),
    "light": (light, "normal"),
    "floor": (colour, COLOURS["white"]),
    "sky": (colour, COLOURS["white"]),
    "start": (one(START), REQUIRED),
    "arena": (one(ARENA), REQUIRED),
    "wall": (many(WALL), []),
    "block": (many(BLOCK), []),
    "cup": (many(CUP), []),
    "robot": (many(ROBOT), []),
    "person": (many(PERSON), []),
    "table": (many(TABLE), []),
    "chair": (many(CHAIR), []),
    "shade": (many(SHADE), []),
    "clutter": (one(CLUTTER), None),
}
