"""Forests: obstacles on a square torus, placed from a seed or read from a file.

The paper (Wen & Horiuchi 2022, section 4.1) puts 1,400 identical obstacles at random places of 50 x 50 m with
periodic boundaries. Ours: no two are nearer than `SPACING`, placed one after the other, each where it is
drawn unless that is too near an earlier one. An obstacle is a point; the zone of collision is the bat's.

A map is a CSV file with the header `x_m,y_m` and an obstacle a line, from 0 up to but not including 50 m.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled
from circuits.errors import ParameterError
from system.option import option, required
from system.reader import Reader, place
from system.rows import read_rows

SIDE = 50.0  # m, the paper's
OBSTACLES = 1400  # the paper's, where it is not varied
SPACING = 0.6  # m between any two obstacles; ours
CELL = 1.0  # m, side of a cell of the list; ours: a few obstacles a cell at most

_TRIES = 400  # draws an obstacle, on average, before a forest counts as too dense
_FULL = 0.547  # share of a plane that discs placed one after the other cover at most; Feder (1980)

_compiled = compiled()


@dataclass(frozen=True, slots=True, eq=False)
class Forest:
    """Obstacles on a square torus.

    place : float64[obstacles, 2], x and y in m, from 0 to `SIDE`.
    name : what reports call it.
    """

    name: str
    place: F64


class Cells(NamedTuple):
    """Obstacles by cell, with copies beyond the borders, so that a search near them needs no wrapping.

    x, y (m) and number: [copies], cell after cell along x, row after row along y; begin: int64[rows, across
    + 1], where each cell's copies begin; margin: m that the cells reach beyond each border.
    """

    x: F64
    y: F64
    number: I64
    begin: I64
    margin: float


def plant(obstacles: int, random: np.random.Generator, spacing: float = SPACING) -> Forest:
    """Place obstacles at random, no two nearer than `spacing` (m), and return their forest.

    Raises
    ------
    ParameterError
        There are none, or so many that they find no place.
    """
    check_count(obstacles, spacing)
    place = np.empty((obstacles, 2))
    across = max(
        int(SIDE / max(spacing, CELL)), 3
    )  # cells no smaller than the spacing, 3 so that they differ
    held = np.full((across, across, 8 + int(16.0 * obstacles / across**2)), -1, dtype=np.int64)
    placed, drawn = 0, 0
    while placed < obstacles:
        draws = SIDE * random.random((obstacles, 2))
        placed = _place(draws, place, placed, held, spacing)
        drawn += obstacles
        if drawn > _TRIES * obstacles and placed < obstacles:
            raise _too_dense(obstacles, spacing)
    return Forest("forest", place)


def check_count(obstacles: int, spacing: float = SPACING) -> None:
    """Raise `ParameterError` unless so many obstacles may find a place."""
    if obstacles < 1:
        raise ParameterError(f"obstacles: {obstacles}, must be at least 1; the paper has 500 to 1700")
    if obstacles > densest(spacing):
        raise _too_dense(obstacles, spacing)


def check_source(given: Mapping[str, Any]) -> None:
    """Raise `ParameterError` where fields of a scenario name a file of obstacles and a number to plant."""
    if given.get("map") is not None and "obstacles" in given:
        raise ParameterError("obstacles: not with `map`, which has its own; leave one out")


def densest(spacing: float = SPACING) -> int:
    """How many obstacles can be placed one after the other, on average: discs cover 0.547 of a plane."""
    return int(_FULL * 4.0 * SIDE**2 / (math.pi * spacing**2))


def map_option() -> Any:
    """Make the field of a scenario for a file of obstacles, None where they are planted."""
    return option(None, "Obstacles, x_m,y_m a line; else planted", metavar="FILE", study=True)


def obstacles_option() -> Any:
    """Make the field of a scenario for the number of obstacles that are planted from its seed."""
    return option(OBSTACLES, "How many are planted from the seed", study=True)


def start_option(read: Reader) -> Any:
    """Make the field of a scenario for the place (m) where it starts, None where that is drawn.

    read : makes the place of a text, and refuses one outside of the forest.
    """
    return option(None, "As 40m,25m; drawn unless given", read=read, metavar="X,Y", key="start_m")


def read_place(text: str, option: str) -> tuple[float, float]:
    """Place of `X,Y`, m; raises `ParameterError` naming the option."""
    x, y = place(text, option)
    if not (0.0 <= x < SIDE and 0.0 <= y < SIDE):
        raise ParameterError(
            f'{option}: "{text}", must be from 0m to below {SIDE:g}m; write as in `{option}=40m,25m`'
        )
    return x, y


def read_forest(path: str) -> Forest:
    """Obstacles of a file; raises `DataError` naming file and line where it is no map."""
    rows = read_rows(path, _Place)
    return Forest(Path(path).stem, np.array([(row.x_m, row.y_m) for _, row in rows]))


@dataclass(frozen=True, slots=True)
class _Place:
    """A row of a map: the place of an obstacle."""

    x_m: float = required("place along x", unit="m", least=0.0, below=SIDE)
    y_m: float = required("place along y", unit="m", least=0.0, below=SIDE)


def cells_of(forest: Forest, margin: float) -> Cells:
    """Sort obstacles and their copies up to `margin` (m) beyond the borders into cells."""
    reach = CELL * math.ceil(margin / CELL)
    if reach >= SIDE:
        raise ParameterError(
            f"bat.max_range: a margin of {margin:g} m, must be below the forest's side of {SIDE:g} m"
        )
    x, y, number = (np.concatenate(each) for each in zip(*_copies(forest.place, reach), strict=True))
    across = round((SIDE + 2.0 * reach) / CELL)
    column, row = (np.floor((v + reach) / CELL).astype(np.int64).clip(0, across - 1) for v in (x, y))
    order = np.lexsort((x, column, row))
    begin = np.searchsorted((row * across + column)[order], np.arange(across * across + 1))
    ends = np.stack([begin[across * k : across * (k + 1) + 1] for k in range(across)])
    return Cells(x[order], y[order], number[order], np.ascontiguousarray(ends.astype(np.int64)), reach)


def clearance(forest: Forest, x: float, y: float) -> float:
    """Distance (m) from a place to the nearest obstacle, round the torus."""
    apart = np.abs(forest.place - np.array([x, y]))
    apart = np.minimum(apart, SIDE - apart)
    return float(np.hypot(apart[:, 0], apart[:, 1]).min())


def _copies(place: F64, reach: float) -> list[tuple[F64, F64, I64]]:
    """Obstacles in the torus and its eight neighbours, as far as they lie within `reach` of it."""
    found = []
    for shift_x in (-SIDE, 0.0, SIDE):
        for shift_y in (-SIDE, 0.0, SIDE):
            x, y = place[:, 0] + shift_x, place[:, 1] + shift_y
            near = np.flatnonzero(
                (x >= -reach) & (x < SIDE + reach) & (y >= -reach) & (y < SIDE + reach)
            ).astype(np.int64)
            found.append((x[near], y[near], near))
    return found


@_compiled
def _place(draws: F64, place: F64, placed: int, held: I64, spacing: float) -> int:
    """Accept draws in their order until all obstacles are placed; returns how many are."""
    across = held.shape[0]
    size = SIDE / across
    for k in range(draws.shape[0]):
        if placed == place.shape[0]:
            break
        x, y = draws[k, 0], draws[k, 1]
        i, j = min(int(x / size), across - 1), min(int(y / size), across - 1)
        if _is_free(x, y, i, j, place, held, spacing):
            place[placed, 0], place[placed, 1] = x, y
            for slot in range(held.shape[2]):
                if held[i, j, slot] < 0:
                    held[i, j, slot] = placed
                    placed += 1
                    break
    return placed


@_compiled
def _is_free(x: float, y: float, i: int, j: int, place: F64, held: I64, spacing: float) -> bool:
    """Whether no obstacle in the nine cells about (i, j) is nearer than the spacing."""
    across = held.shape[0]
    for a in range(i - 1, i + 2):
        for b in range(j - 1, j + 2):
            cell = held[a % across, b % across]
            for slot in range(cell.size):
                k = cell[slot]
                if k < 0:
                    break
                dx, dy = abs(place[k, 0] - x), abs(place[k, 1] - y)
                dx, dy = min(dx, SIDE - dx), min(dy, SIDE - dy)
                if dx * dx + dy * dy < spacing * spacing:
                    return False
    return True


def _too_dense(obstacles: int, spacing: float) -> ParameterError:
    return ParameterError(
        f"obstacles: {obstacles}, must fit {SIDE:g} x {SIDE:g} m at least {spacing:g} m apart; up to about"
        f" {int(0.9 * densest(spacing))} do"
    )
