"""Cost maps: what it costs to traverse each cell of a grid (Hwu et al. 2018, section II.E).

A map is a text file of whole numbers, a line a row from north to south, separated by spaces or commas; 0
marks a blocked cell. The four maps of the paper's Figure 4 are drawn here from its text (ours): map 1 is a
round lawn (3) inside a region of 9, in two variants with the paved road around it (1) and in one with
benches, bushes and trees near the road (6); map 2 has an asphalt road (1) that roughly follows map 1's,
gravel paths (2), trees and brush (10) and an outer region of 6.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from circuits.arrays import I64
from circuits.errors import DataError, ParameterError
from system.files.text import map_text

Cell = tuple[int, int]  # row and column, from 0, row 0 at the north

CELL_SIZE = 6.0  # m, ours: 20 cells are 120 m, a fifth of the 19 acre park
STRETCH = 1.5  # ours: map 2 is wider than high, the paper says stretched without a figure
MAPS: dict[str, tuple[float, float]] = {  # name: width and height of a cell, m
    "map1-without-road": (CELL_SIZE, CELL_SIZE),
    "map1-road": (CELL_SIZE, CELL_SIZE),
    "map1-road-obstacles": (CELL_SIZE, CELL_SIZE),
    "map2": (STRETCH * CELL_SIZE, CELL_SIZE),
}
_PASSABLE = 3  # largest cost of a place to stand on: road, gravel and grass; ours
TREES = 6  # smallest cost of what hides the sky or stands in the way: benches, bushes, trees; ours
MAX_CODE = 31  # of a chip's axon delay, 5 bit
MAX_COST = 1_000_000  # so that sums along any path stay exact; ours
APART = 5.0  # cells between the ends of a random route, Euclidean; the paper's
NEEDS = ("energy", "speed")

_FOLDER = Path(__file__).parent / "maps"
_CELL = re.compile(r"\s*([0-9]{1,9})\s*,\s*([0-9]{1,9})\s*")
_WHOLE = re.compile(r"[+-]?[0-9]+")
_TRIES = 1000  # draws a pair
_SHOWN = 20  # characters of an offending value that an error repeats


@dataclass(frozen=True, slots=True, eq=False)
class CostMap:
    """A grid of costs.

    Attributes
    ----------
    costs : array
        Cost of each cell, int64[rows, columns], 0 where it is blocked.
    cell_width, cell_height : float
        Extent of a cell to the east and to the north, m.
    name : str
        What reports call it.
    """

    name: str
    costs: I64
    cell_width: float = CELL_SIZE
    cell_height: float = CELL_SIZE

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, columns = self.costs.shape
        return rows, columns


def load_map(name: str) -> CostMap:
    """Load one of `MAPS` by its `name`, or the map in a file, with errors of `map_text` and `read_map`."""
    path, text = map_text(name, MAPS, _FOLDER, "a map of whole numbers")
    return CostMap(path.stem, read_map(text, str(path)), *MAPS.get(name, ()))


def read_map(text: str, source: str) -> I64:
    """Read the costs of a map from `text`, int64[rows, columns]; `source` is what errors call it.

    Raises
    ------
    DataError
        No numbers, rows of different lengths, or what is not a whole number from 0 to `MAX_COST`.
    """
    rows: list[list[int]] = []
    first = 0
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip():
            continue
        fields = [f.strip() for f in line.split(",")] if "," in line else line.split()
        row = [_cost(field, f"{source}: line {number}") for field in fields]
        if rows and len(row) != len(rows[0]):
            raise DataError(
                f"{source}: line {number} has {len(row)} numbers, must be {len(rows[0])} as in line {first};"
                " give every row as many"
            )
        first = first or number
        rows.append(row)
    if not rows:
        raise DataError(f"{source}: empty, must have a row of whole numbers a line; 0 is a blocked cell")
    return np.array(rows, dtype=np.int64)


def check_codes(cost_map: CostMap) -> None:
    """Raise `ParameterError` if a cost has no code on a chip."""
    over = np.argwhere(cost_map.costs > MAX_CODE)
    if len(over):
        row, column = (int(v) for v in over[0])
        raise ParameterError(
            f"{cost_map.name}[{row},{column}]: {cost_map.costs[row, column]}, must be at most {MAX_CODE} on a"
            " chip; scale the map, or use `cells=ideal`"
        )


def check_cell(cost_map: CostMap, cell: Cell, option: str) -> None:
    """Raise `ParameterError` naming `option` unless `cell` is a free cell of the map."""
    rows, columns = cost_map.shape
    row, column = cell
    if not (0 <= row < rows and 0 <= column < columns):
        raise ParameterError(
            f"{option}: {row},{column}, must be in the map of {rows} x {columns}, row and column from 0"
        )
    if cost_map.costs[row, column] == 0:
        raise ParameterError(f"{option}: {row},{column}, must not be blocked; choose a cell above 0")


def read_cell(text: str, option: str) -> Cell:
    """Row and column of `ROW,COLUMN`; raises `ParameterError` naming the option."""
    found = _CELL.fullmatch(text)
    if found is None:
        raise ParameterError(f'{option}: "{text}", must be ROW,COLUMN from 0; write as in {option} 2,10')
    return int(found[1]), int(found[2])


def for_need(cost_map: CostMap, need: str) -> CostMap:
    """Return the map as a need sees it; ours, the paper names the needs and no numbers.

    `energy`: the map itself, so that smooth roads are worth a detour. `speed`: what can be driven on costs 1
    alike, for there a cell takes the same time; the rest as it is.

    Raises `ParameterError` for another need.
    """
    if need not in NEEDS:
        raise ParameterError(f"need: {need}, must be {' or '.join(NEEDS)}")
    if need == "energy":
        return cost_map
    drivable = (cost_map.costs > 0) & (cost_map.costs <= _PASSABLE)
    costs = np.where(drivable, 1, cost_map.costs)
    return CostMap(cost_map.name, costs, cost_map.cell_width, cost_map.cell_height)


def in_bounds(cost_map: CostMap) -> I64:
    """Cells of the park where a robot can stand, int64[n, 2] of (row, column): cost 1 to `_PASSABLE`."""
    return np.argwhere((cost_map.costs > 0) & (cost_map.costs <= _PASSABLE)).astype(np.int64)


def random_pairs(
    cost_map: CostMap, pairs: int, random: np.random.Generator, places: I64 | None = None
) -> I64:
    """Pairs of places, those in bounds unless given, more than `APART` cells apart, int64[pairs, 2, 2].

    Raises `ParameterError` where hardly any pair of places is that far apart.
    """
    places = in_bounds(cost_map) if places is None else places
    drawn: list[I64] = []
    for _ in range(_TRIES * pairs):
        if len(places) < 2 or len(drawn) == pairs:
            break
        pair = places[random.choice(len(places), 2, replace=False)]
        if np.hypot(*(pair[0] - pair[1])) > APART:
            drawn.append(pair)
    if len(drawn) < pairs:
        raise ParameterError(
            f"{cost_map.name}: {len(places)} places, must have pairs more than {APART:g} cells"
            " apart; take a larger map"
        )
    return np.array(drawn).reshape(-1, 2, 2)


def _cost(field: str, where: str) -> int:
    shown = field if len(field) <= _SHOWN else f"{field[:_SHOWN]}..."
    if not _WHOLE.fullmatch(field):
        raise DataError(f'{where}: "{shown}", must be a whole number; 0 is a blocked cell')
    if len(field) > _SHOWN or not 0 <= int(field) <= MAX_COST:
        raise DataError(f"{where}: {shown}, must be from 0 to {MAX_COST}; 0 is a blocked cell")
    return int(field)
