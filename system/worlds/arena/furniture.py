"""Upright bodies of what a scene file names: boxes, cylinders, robots, people and furniture.

All sizes that a file cannot give are ours but the Pushbot's 10 x 10 cm.
"""

from __future__ import annotations

import math
from dataclasses import replace

from system.worlds.arena.scene import COLOURS, Body, Led, Point
from system.worlds.arena.tables import BlockTable, ChairTable, CupTable, DeskTable, PersonTable, RobotTable

ROBOT_SIZE = (0.10, 0.10)  # m; the paper's
ROBOT_HEIGHT = 0.09  # m
TRACK_WIDTH, TRACK_HEIGHT = 0.02, 0.05  # m
LEG, LEG_HEIGHT, STRIDE, HIP = 0.11, 0.85, 0.15, 0.18  # m: diameter, height, swing, between the legs
TABLE_LEG, TABLE_TOP, TABLE_INSET = 0.05, 0.04, 0.06  # m: side, thickness, from the edge
CHAIR_FOOT, CHAIR_FOOT_HEIGHT, CHAIR_POST, CHAIR_SEAT = 0.50, 0.06, 0.05, 0.42  # m
CHAIR_LOW, CHAIR_HIGH = 0.42, 0.50  # m: under and upper side of the seat


def block(name: str, it: BlockTable) -> list[Body]:
    """Return the body of a box."""
    return [Body(name, it.at, it.size, it.height, it.colour, it.heading, it.base, motion=it.motion)]


def cup(name: str, it: CupTable) -> list[Body]:
    """Return the body of a cylinder."""
    size = (it.diameter, it.diameter)
    return [Body(name, it.at, size, it.height, it.colour, base=it.base, is_round=True, motion=it.motion)]


def robot(name: str, it: RobotTable) -> list[Body]:
    """Return the bodies of another Pushbot with an LED on top; tracks have a reflectance of their own."""
    led = Led() if it.led is True else it.led or None
    if it.tracks is None:
        return [Body(name, it.at, ROBOT_SIZE, ROBOT_HEIGHT, it.colour, it.heading, motion=it.motion, led=led)]
    length, width = ROBOT_SIZE
    middle = (length, width - 2.0 * TRACK_WIDTH)
    aside, track = 0.5 * (width - TRACK_WIDTH), (length, TRACK_WIDTH)
    return [
        Body(name, it.at, middle, ROBOT_HEIGHT, it.colour, it.heading, led=led),
        *(
            Body(
                f"{name}.{side}", placed(it.at, it.heading, 0.0, left), track, TRACK_HEIGHT, it.tracks,
                it.heading,
            )
            for side, left in (("left", aside), ("right", -aside))
        ),
    ]  # fmt: skip


def person(name: str, it: PersonTable) -> list[Body]:
    """Return two legs that swing against each other as the person walks."""
    side = -0.5 * HIP * math.sin(it.heading), 0.5 * HIP * math.cos(it.heading)
    legs = []
    for leg, sign in (("left", 1.0), ("right", -1.0)):
        shift = sign * side[0], sign * side[1]
        moved = None if it.motion is None else replace(it.motion, path=_shifted(it.motion.path, shift))
        legs.append(
            Body(
                f"{name}.{leg}", (it.at[0] + shift[0], it.at[1] + shift[1]), (LEG, LEG), LEG_HEIGHT,
                it.colour, it.heading, is_round=True, motion=moved, swing=sign * STRIDE,
            )
        )  # fmt: skip
    return legs


def desk(name: str, it: DeskTable) -> list[Body]:
    """Return the four legs and the top of a table."""
    at, heading = it.at, it.heading
    top = Body(f"{name}.top", at, it.size, it.height, it.colour, heading, it.height - TABLE_TOP)
    half = 0.5 * it.size[0] - TABLE_INSET, 0.5 * it.size[1] - TABLE_INSET
    legs = [
        Body(
            f"{name}.leg[{k}]", placed(at, heading, a * half[0], b * half[1]), (TABLE_LEG, TABLE_LEG),
            it.height - TABLE_TOP, COLOURS["grey"], heading,
        )
        for k, (a, b) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1)))
    ]  # fmt: skip
    return [top, *legs]


def chair(name: str, it: ChairTable) -> list[Body]:
    """Return an office chair: a cross of two low bars, a post and a seat."""
    at, bar = it.at, (CHAIR_FOOT, CHAIR_FOOT_HEIGHT)
    return [
        Body(f"{name}.bar", at, bar, CHAIR_FOOT_HEIGHT, COLOURS["grey"], it.heading),
        Body(f"{name}.cross", at, bar, CHAIR_FOOT_HEIGHT, COLOURS["grey"], it.heading + 0.5 * math.pi),
        Body(f"{name}.post", at, (CHAIR_POST, CHAIR_POST), CHAIR_LOW, COLOURS["black"], is_round=True,
             base=CHAIR_FOOT_HEIGHT),
        Body(f"{name}.seat", at, (CHAIR_SEAT, CHAIR_SEAT), CHAIR_HIGH, it.colour, it.heading, CHAIR_LOW),
    ]  # fmt: skip


def placed(at: Point, heading: float, ahead: float, left: float) -> Point:
    """Return the place on the floor of a point in a body's frame (m)."""
    cos, sin = math.cos(heading), math.sin(heading)
    return at[0] + cos * ahead - sin * left, at[1] + sin * ahead + cos * left


def _shifted(path: tuple[Point, ...], by: Point) -> tuple[Point, ...]:
    return tuple((x + by[0], y + by[1]) for x, y in path)
