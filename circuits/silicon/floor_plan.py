"""Where the cells of a chip stand on its die, from their instance paths.

A floor plan gives each array of instances rows and columns, a pitch, and a centre. The position of a device
is the sum of the offsets of the instances on its path that the plan names, from the die's centre, x to the
right and y upwards. All devices of a cell stand at the middle of their cell. What a plan does not name stands
where the instance around it does; a block by itself, and a chip without a plan, stand at their die's centre.

All figures are ours, unless a plan says otherwise: none of the papers draws its chip to scale.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from circuits.arrays import F64, I64
from circuits.errors import ParameterError

Path = tuple[tuple[str, tuple[int, ...]], ...]

_UM = 1e-6  # m


@dataclass(frozen=True, slots=True)
class Block:
    """An array of cells, or one cell.

    Attributes
    ----------
    rows, columns : int
        How many cells stand above and beside each other; a cell's index runs along the rows.
    pitch : (float, float)
        Distance from cell to cell, in x and in y, m.
    centre : (float, float)
        Middle of the array from the middle of what it stands in, x and y, m.
    """

    rows: int = 1
    columns: int = 1
    pitch: tuple[float, float] = (0.0, 0.0)
    centre: tuple[float, float] = (0.0, 0.0)

    def offsets(self, row: I64, column: I64) -> tuple[F64, F64]:
        """Offsets x and y (m) of cells; row 0 is on top, column 0 at the left."""
        x = self.centre[0] + (column - 0.5 * (self.columns - 1)) * self.pitch[0]
        y = self.centre[1] - (row - 0.5 * (self.rows - 1)) * self.pitch[1]
        return np.asarray(x), np.asarray(y)


Plan = Mapping[str, Block]


def _square(count: int, columns: int, pitch_um: float, centre_um: tuple[float, float] = (0.0, 0.0)) -> Block:
    """An array of square cells."""
    pitch = pitch_um * _UM
    return Block(-(-count // columns), columns, (pitch, pitch), (centre_um[0] * _UM, centre_um[1] * _UM))


def _column(count: int, pitch_um: float, centre_um: tuple[float, float] = (0.0, 0.0)) -> Block:
    return _square(count, 1, pitch_um, centre_um)


def _line(count: int, pitch_um: float, centre_um: tuple[float, float] = (0.0, 0.0)) -> Block:
    return _square(count, count, pitch_um, centre_um)


# The ranging chip and the sonar head: a MOSIS tiny chip, 2.2 mm by 2.2 mm, of which 1.5 mm are free. ROLLS:
# 256 rows of 22 um on a die of 51.4 mm^2 (Qiao et al. 2015, from memory, unverified), neurons at the right.
# The other chips, which exist nowhere: a round pitch that their cells' devices leave.
FLOOR_PLANS: Mapping[str, Plan] = MappingProxyType({
    "ranging_chip": {"neuron": _column(13, 110.0), "chain": Block(centre=(-500 * _UM, 0.0))},
    "sonar_head": {
        "ear": _line(2, 700.0),
        "level": _column(10, 130.0),
        "lso": _line(2, 300.0, (0.0, -700.0)),
        "bias": Block(centre=(0.0, 750 * _UM)),
    },
    "wavefront_chip": {"cell": _square(400, 20, 250.0), "axon": _square(400, 20, 250.0)},
    "latency_chip": {
        "tap": _line(33, 100.0, (0.0, 1400.0)),
        "memory": _line(33, 100.0, (0.0, 800.0)),
        "unit": _column(32, 40.0),
        "first": _line(33, 100.0, (0.0, -200.0)),
        "second": _line(33, 100.0, (0.0, -600.0)),
        "recurrent": _line(2, 1600.0, (0.0, -900.0)),
        "emergency": Block(centre=(0.0, -900 * _UM)),
    },
    "nef_chip": {
        "neuron": _square(8192, 128, 40.0),
        "stage": _square(8192, 128, 40.0),
    },
    "rolls_chip": {
        "row": _column(256, 22.0),
        "neuron": Block(centre=(3200 * _UM, 0.0)),
        "synapse": _line(256, 12.0, (-1600.0, 0.0)),
        **dict.fromkeys(
            ("depression_exc", "depression_exc0", "depression_exc1"), _line(256, 12.0, (-1600.0, 0.0))
        ),
        "plastic_synapse": _line(256, 12.0, (1450.0, 0.0)),
        "extender": _line(256, 12.0, (-1600.0, 2900.0)),
        "plastic_extender": _line(256, 12.0, (1450.0, 2900.0)),
        "virtual_exc": _line(4, 12.0, (-3200.0, 0.0)),
        "virtual_inh": _line(4, 12.0, (-3260.0, 0.0)),
    },
})  # fmt: skip
"""The plan of each chip, by the name of its circuit."""

BOARDS = frozenset({
    "centroid_board", "vocalization_controller", "first_target_isolation", "envelope_detector",
    "onset_neuron", "high_threshold_neuron",
})  # fmt: skip
"""Circuits on a board, whose capacitors and resistors are parts of their own that no die changes."""


def positions(place: Path, paths: Sequence[Path]) -> tuple[F64, F64]:
    """Positions of devices from the die's centre, x and y, m, float64[places] each.

    Parameters
    ----------
    place
        Where the circuit stands, ((chip, ()), (instance, index), ...).
    paths
        Paths from there on, ((name, shape), ...); places are counted path after path, row-major.

    Raises
    ------
    ParameterError
        An index is beyond its array's rows or columns.
    """
    plan = FLOOR_PLANS.get(place[0][0], {}) if place else {}
    x0, y0 = 0.0, 0.0
    for name, index in place[1:]:
        dx, dy = _offsets(place[0][0], plan, name, tuple(np.array([i]) for i in index))
        x0, y0 = x0 + float(dx[0]), y0 + float(dy[0])
    found = [_along(place[0][0] if place else "", plan, path) for path in paths]
    x = np.concatenate([np.zeros(0), *(each[0] for each in found)])
    y = np.concatenate([np.zeros(0), *(each[1] for each in found)])
    return x0 + x, y0 + y


def _along(chip: str, plan: Plan, path: Path) -> tuple[F64, F64]:
    """Offsets of all places of a path."""
    shape = tuple(n for _, dimensions in path for n in dimensions)
    count = int(np.prod(shape, dtype=np.int64))
    index = np.indices(shape, dtype=np.int64).reshape(len(shape), count)
    x, y, start = np.zeros(count), np.zeros(count), 0
    for name, dimensions in path:
        own = tuple(index[start : start + len(dimensions)])
        start += len(dimensions)
        dx, dy = _offsets(chip, plan, name, own)
        x, y = x + dx, y + dy
    return x, y


def _offsets(chip: str, plan: Plan, name: str, index: tuple[I64, ...]) -> tuple[F64, F64]:
    """Offsets of an instance of the given index, one integer array a dimension."""
    block = plan.get(name)
    if block is None:
        return np.zeros(1), np.zeros(1)
    if len(index) < 2:
        row, column = np.divmod(index[0] if index else np.zeros(1, np.int64), block.columns)
    else:
        row, column = index[-2:]
    if row.max(initial=0) >= block.rows or column.max(initial=0) >= block.columns:
        worst = ",".join(str(int(i.max(initial=0))) for i in index)
        raise ParameterError(
            f"{chip}.{name}[{worst}]: outside of the floor plan's {block.rows} rows and {block.columns}"
            " columns; leave the variation plain, or build as many as the chip has"
        )
    return block.offsets(row, column)
