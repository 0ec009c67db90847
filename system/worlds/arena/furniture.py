"""Furniture, people and robots as upright bodies; all sizes are ours but the Pushbot's 10 x 10 cm."""

from __future__ import annotations

import math
from dataclasses import replace

from circuits.errors import ParameterError
from system.worlds.arena.scene import COLOURS, Body, Led, Motion, Point

ROBOT_SIZE = (0.10, 0.10)  # m; the paper's
ROBOT_HEIGHT = 0.09  # m
TRACK_WIDTH, TRACK_HEIGHT = 0.02, 0.05  # m
LEG, LEG_HEIGHT, STRIDE, HIP = 0.11, 0.85, 0.15, 0.18  # m: diameter, height, swing, between the legs
TABLE_LEG, TABLE_TOP, TABLE_INSET = 0.05, 0.04, 0.06  # m: side, thickness, from the edge
CHAIR_FOOT, CHAIR_FOOT_HEIGHT, CHAIR_POST, CHAIR_SEAT = 0.50, 0.06, 0.05, 0.42  # m
CHAIR_LOW, CHAIR_HIGH = 0.42, 0.50  # m: under and upper side of the seat


def robot(
    name: str, at: Point, heading: float, reflectance: float, led: Led | None, motion: Motion | None,
    tracks: float | None = None,
) -> list[Body]:  # fmt: skip
    """Another Pushbot with an LED on top; `tracks` beside its body have a reflectance of their own.

    Raises `ParameterError` for tracks of a robot that moves: covered with paper, as the paper's, it has none.
    """
    if tracks is None:
        return [Body(name, at, ROBOT_SIZE, ROBOT_HEIGHT, reflectance, heading, motion=motion, led=led)]
    if motion is not None:
        raise ParameterError(
            f"{name}.tracks: {tracks:g}, must not be given for a robot that moves; leave it out"
        )
    length, width = ROBOT_SIZE
    middle = (length, width - 2.0 * TRACK_WIDTH)
    aside, track = 0.5 * (width - TRACK_WIDTH), (length, TRACK_WIDTH)
    return [
        Body(name, at, middle, ROBOT_HEIGHT, reflectance, heading, led=led),
        *(
            Body(f"{name}.{side}", placed(at, heading, 0.0, left), track, TRACK_HEIGHT, tracks, heading)
            for side, left in (("left", aside), ("right", -aside))
        ),
    ]  # fmt: skip


def person(name: str, at: Point, heading: float, reflectance: float, motion: Motion | None) -> list[Body]:
    """Two legs that swing against each other as the person walks."""
    side = -0.5 * HIP * math.sin(heading), 0.5 * HIP * math.cos(heading)
    legs = []
    for leg, sign in (("left", 1.0), ("right", -1.0)):
        shift = sign * side[0], sign * side[1]
        moved = None if motion is None else replace(motion, path=_shifted(motion.path, shift))
        legs.append(
            Body(
                f"{name}.{leg}", (at[0] + shift[0], at[1] + shift[1]), (LEG, LEG), LEG_HEIGHT, reflectance,
                heading, is_round=True, motion=moved, swing=sign * STRIDE,
            )
        )  # fmt: skip
    return legs


def table(
    name: str, at: Point, size: tuple[float, float], heading: float, reflectance: float, height: float
) -> list[Body]:
    """Four legs and a top."""
    top = Body(f"{name}.top", at, size, height, reflectance, heading, height - TABLE_TOP)
    half = 0.5 * size[0] - TABLE_INSET, 0.5 * size[1] - TABLE_INSET
    legs = [
        Body(
            f"{name}.leg[{k}]", placed(at, heading, a * half[0], b * half[1]), (TABLE_LEG, TABLE_LEG),
            height - TABLE_TOP, COLOURS["grey"], heading,
        )
        for k, (a, b) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1)))
    ]  # fmt: skip
    return [top, *legs]


def chair(name: str, at: Point, heading: float, reflectance: float) -> list[Body]:
    """An office chair: a cross of two low bars, a post and a seat."""
    bar = (CHAIR_FOOT, CHAIR_FOOT_HEIGHT)
    return [
        Body(f"{name}.bar", at, bar, CHAIR_FOOT_HEIGHT, COLOURS["grey"], heading),
        Body(f"{name}.cross", at, bar, CHAIR_FOOT_HEIGHT, COLOURS["grey"], heading + 0.5 * math.pi),
        Body(f"{name}.post", at, (CHAIR_POST, CHAIR_POST), CHAIR_LOW, COLOURS["black"], is_round=True,
             base=CHAIR_FOOT_HEIGHT),
        Body(f"{name}.seat", at, (CHAIR_SEAT, CHAIR_SEAT), CHAIR_HIGH, reflectance, heading, CHAIR_LOW),
    ]  # fmt: skip


def placed(at: Point, heading: float, ahead: float, left: float) -> Point:
    """Point of a body's frame (m) on the floor."""
    cos, sin = math.cos(heading), math.sin(heading)
    return at[0] + cos * ahead - sin * left, at[1] + sin * ahead + cos * left


def _shifted(path: tuple[Point, ...], by: Point) -> tuple[Point, ...]:
    return tuple((x + by[0], y + by[1]) for x, y in path)
