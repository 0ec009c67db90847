"""Maps of the Bug robot: text, a character a cell (Stöckel 2017, III.A: a low-resolution ASCII bitmap).

`#` is a wall, `S` a start, `G` a goal, a space or `.` free; there may be several starts and goals, numbered
from 0 in reading order. Ours: a cell is 1 map unit wide, the unit of the robot's radius and range; x is east,
y is north, and the first line is the northmost; lines end where they end, what follows is free; a line with
nothing on it is free, the last ones too; outside of the map is wall, so that no robot leaves it. The paper's
own maps are pictures that its text does not give: those here are drawn after its words.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from circuits.arrays import Bools
from circuits.errors import DataError, ParameterError
from system.files.text import map_text

Point = tuple[float, float]

MAPS: dict[str, str] = {
    "bug-cup": "Bug 0 stays in a corner of a cup, with the goal behind its back",
    "bug-field": "large, several obstacles between start and goal",
    "bug-open": "nothing between start and goal",
    "bug-rooms": "four rooms with doors, two starts and two goals",
    "bug-sealed": "the goal is walled in",
    "bug-spiral": "Bug 0 circles around the walls about the goal, past the way in",
}
LARGEST = 1000  # cells along a side; ours

_FOLDER = Path(__file__).parent / "maps"
_FREE, _WALL, _START, _GOAL = " .", "#", "S", "G"


@dataclass(frozen=True, slots=True, eq=False)
class BugMap:
    """A map of walls, with its starts and goals.

    walls : bool[rows, columns], row 0 in the north; starts, goals : centres of their cells, in map units.
    name : what reports call it.
    """

    name: str
    walls: Bools
    starts: tuple[Point, ...]
    goals: tuple[Point, ...]

    @property
    def width(self) -> float:
        """Extent of the map to the east, map units."""
        return float(self.walls.shape[1])

    @property
    def height(self) -> float:
        """Extent of the map to the north, map units."""
        return float(self.walls.shape[0])

    @property
    def diagonal(self) -> float:
        """Largest distance in the map, which senses take for 1."""
        return math.hypot(self.width, self.height)


def load_map(name: str) -> BugMap:
    """Load one of `MAPS`, or the map in a file, with the errors of `map_text` and `read_map`."""
    path, text = map_text(name, MAPS, _FOLDER, "a map of # S G and spaces")
    return read_map(text, path.stem)


def read_map(text: str, name: str) -> BugMap:
    """Map from text; `name` is what errors call it.

    Raises
    ------
    DataError
        Another character than those of a map, no start, no goal, or more than `LARGEST` cells a side.
    """
    lines = text.expandtabs(1).splitlines()
    rows, columns = len(lines), max((len(line) for line in lines), default=0)
    if max(rows, columns) > LARGEST:
        raise DataError(f"{name}: {rows} lines of {columns} cells, must be at most {LARGEST} a side")
    walls = np.zeros((rows, columns), dtype=bool)
    found: dict[str, list[Point]] = {_START: [], _GOAL: []}
    for i, line in enumerate(lines):
        for j, cell in enumerate(line):
            if cell in found:
                found[cell].append((j + 0.5, rows - i - 0.5))
            elif cell == _WALL:
                walls[i, j] = True
            elif cell not in _FREE:
                raise DataError(f"{name}:{i + 1}: {cell!r}, must be # (wall), S (start), G (goal) or free")
    for cell, word in ((_START, "start"), (_GOAL, "goal")):
        if not found[cell]:
            raise DataError(f"{name}: no {word}, must have at least one {cell}; write it where the {word} is")
    return BugMap(name, walls, tuple(found[_START]), tuple(found[_GOAL]))


def pick(points: tuple[Point, ...], text: str, option: str) -> Point:
    """Start or goal of a text: its number from 0, or `X,Y` in map units.

    Raises `ParameterError` naming the option.
    """
    if text.isdecimal() and int(text) < len(points):
        return points[int(text)]
    x, comma, y = text.partition(",")
    try:
        place = (float(x), float(y)) if comma else (math.nan, math.nan)
    except ValueError:
        place = (math.nan, math.nan)
    if not all(map(math.isfinite, place)):
        raise ParameterError(
            f'{option}: "{text}", must be a number from 0 to {len(points) - 1}, which the map has, or X,Y'
        )
    return place
