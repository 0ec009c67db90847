"""The car's three forests of pipes, Figure 15: a corridor, and 21 pipes on 1.8 or 1.4 x 1.8 m.

x is the way through, from 0; y is across, 0 in the middle. The pipes of the two forests are drawn, one after
the other, no two nearer than `SPACING` between their middles (ours: Figure 15 shows one arrangement of each).
The corridor is two lines of evenly spaced pipes; its sizes are ours. A file has pipes of one's own, a line
`x_m,y_m` each after that header: the forest is as long as the farthest, and as wide as twice the outermost.

A robot starts `BEFORE` m before the forest, somewhere across and in some direction, both drawn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.car.numbers import PIPE_RADIUS
from system.option import required
from system.rows import read_rows

FORESTS = ("corridor", "open", "dense")
PIPES = 21  # the paper's
LONG = {"corridor": 2.4, "open": 1.8, "dense": 1.8}  # m along x; the corridor's ours
WIDE = {"corridor": 0.9, "open": 1.8, "dense": 1.4}  # m across; the corridor's, between its lines, ours
_CORRIDOR_STEP = 0.3  # m between the pipes of a line; ours
SPACING = 0.28  # m between any two pipes; ours
BEFORE = 0.6  # m before the forest where a robot starts: its sonar then has the first pipes in sight; ours
_START_ACROSS = 0.25  # of the width, to either side of the middle; ours
_START_TURN = math.radians(10.0)  # to either side of straight ahead; ours

LARGEST = 100.0  # m, of a file's forest, along and to either side; ours
LEAST_WIDE = WIDE["corridor"]  # m, that a file's forest counts as wide at least; ours

_TRIES = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class Pipes:
    """A forest of pipes.

    place : float64[n, 2], middles of the pipes, x and y in m; long, wide : extent along x and across, m.
    name : what reports call it.
    """

    name: str
    place: F64
    long: float
    wide: float


def check_forest(name: str) -> None:
    """Raise `ParameterError` unless it is a forest's name, or that of a file as `own.csv`."""
    if name not in FORESTS and not is_file(name):
        known = f"{', '.join(FORESTS[:-1])} or {FORESTS[-1]}"
        raise ParameterError(f"forest: {name}, must be {known}; or a file as own.csv")


def is_file(name: str) -> bool:
    """Whether a name is a file's: it has an ending, or a folder."""
    path = Path(name)
    return name not in FORESTS and (path.suffix != "" or path.parent != Path())


def number_of(name: str) -> int:
    """Number of a forest, by which the draws of a seed differ from one to another; files have the same."""
    return FORESTS.index(name) if name in FORESTS else len(FORESTS)


def read_pipes(path: str) -> Pipes:
    """Pipes of a file; raises `DataError` naming file and line where it is no map."""
    place = np.array([(row.x_m, row.y_m) for _, row in read_rows(path, _Place)])
    wide = max(2.0 * float(np.abs(place[:, 1]).max()), LEAST_WIDE)
    return Pipes(Path(path).stem, place, float(place[:, 0].max()), wide)


@dataclass(frozen=True, slots=True)
class _Place:
    """A row of a file: the place of a pipe's middle."""

    x_m: float = required("place along the way through", unit="m", least=0.0, below=LARGEST)
    y_m: float = required("place across", unit="m", least=-LARGEST, below=LARGEST)


def forest_of(name: str, random: np.random.Generator) -> Pipes:
    """A forest by its name, its pipes drawn from `random`, or of a file.

    Raises `ParameterError` for another name, `DataError` for a file that is no map.
    """
    check_forest(name)
    if is_file(name):
        return read_pipes(name)
    long, wide = LONG[name], WIDE[name]
    place = _corridor(long, wide) if name == "corridor" else _plant(long, wide, random)
    return Pipes(name, place, long, wide)


def clearance(forest: Pipes, x: float, y: float) -> float:
    """Distance (m) from a place to the nearest surface of a pipe, negative inside one."""
    return float(np.hypot(forest.place[:, 0] - x, forest.place[:, 1] - y).min()) - PIPE_RADIUS


def start_of(
    forest: Pipes, random: np.random.Generator, radius: float, at: tuple[float, float] | None = None
) -> tuple[float, float, float]:
    """Pose (m, m, rad) of a start for a body of `radius` (m), at a place or drawn; the direction is drawn.

    Raises `ParameterError` where the body would touch a pipe, or is behind the forest or beside it already.
    """
    y = _START_ACROSS * forest.wide * random.uniform(-1.0, 1.0)
    heading = _START_TURN * random.uniform(-1.0, 1.0)
    if at is None:
        return -BEFORE, y, heading
    if at[0] > forest.long or (at[0] > 0.0 and abs(at[1]) > 0.5 * forest.wide):
        raise ParameterError(
            f"start: {at[0]:g},{at[1]:g}, must be before the forest's end at {forest.long:g} m, and within"
            f" {0.5 * forest.wide:g} m of its middle once behind 0 m; start elsewhere"
        )
    room = clearance(forest, *at)
    if room < radius:
        raise ParameterError(
            f"start: {at[0]:g},{at[1]:g}, a pipe's surface is {room:.3g} m away, must be at least"
            f" {radius:g} m, the body's radius; start elsewhere"
        )
    return *at, heading


def _corridor(long: float, wide: float) -> F64:
    x = np.arange(0.0, long + 1e-9, _CORRIDOR_STEP)
    side = np.full(x.size, 0.5 * wide)
    return np.concatenate([np.stack([x, side], axis=1), np.stack([x, -side], axis=1)])


def _plant(long: float, wide: float, random: np.random.Generator) -> F64:
    low, high = np.array([0.0, -0.5 * wide]), np.array([long, 0.5 * wide])
    place = np.empty((0, 2))
    for _ in range(_TRIES):
        drawn = random.uniform(low, high)
        if not len(place) or np.hypot(*(place - drawn).T).min() >= SPACING:
            place = np.concatenate([place, drawn[None]])
        if len(place) == PIPES:
            return place
    raise ParameterError(f"robot_forest.spacing: {SPACING:g} m, {PIPES} pipes found no place; choose less")
