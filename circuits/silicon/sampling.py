"""Draws that a sampling plan of a study puts in the place of a die's own.

A plan (Latin hypercube, Sobol, importance sampling) chooses the standard normals of a whole range of dies
together. It gives `Die.sampling` a table with a row for each die and a column for each labelled draw. A draw
that the table does not have stays the die's own, so that a plan made for one block leaves the rest of a chip
alone.

A label is a path with the parameter last: `rebound_neuron.inhibition.mi5.v_t0`, `chip.neuron[2].m1.beta`, and
`process.n.shared.v_t0` for what all devices of a polarity share on a die.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from circuits.arrays import F64, I64
from circuits.errors import ParameterError

Path = tuple[tuple[str, tuple[int, ...]], ...]

_ABSENT = -1


@dataclass(frozen=True, slots=True, eq=False)
class Sampling:
    """Standard normals of the dies `first`, `first + 1`, ... under a plan called `name`.

    columns: the column of each label. rows: float64[dies, columns]. added: whether these are added to the
    die's own draws.
    """

    name: str
    first: int
    columns: Mapping[str, int]
    rows: F64
    added: bool = False
    _found: dict[tuple[Path, tuple[Path, ...], str], I64] = field(default_factory=dict, repr=False)

    def __reduce__(self) -> tuple[object, ...]:
        """Leave what was looked up behind."""
        return Sampling, (self.name, self.first, self.columns, self.rows, self.added)

    def draws(self, number: int, place: Path, paths: Sequence[Path], parameter: str, own: F64) -> F64:
        """Standard normals of die `number`, with those of `own` where the plan has none.

        place, paths, parameter: as of `circuits.silicon.die.standard_normals`. Raises `ParameterError` for a
        die that the plan does not have.
        """
        row = number - self.first
        if not 0 <= row < len(self.rows):
            last = self.first + len(self.rows) - 1
            raise ParameterError(f"die: {number}, the plan {self.name} has {self.first} to {last}")
        key = (place, tuple(paths), parameter)
        if key not in self._found:
            known = [self.columns.get(label, _ABSENT) for label in labels(place, paths, parameter)]
            self._found[key] = np.array(known, dtype=np.int64)
        column = self._found[key]
        given = self.rows[row, column] + own if self.added else self.rows[row, column]
        return np.where(column == _ABSENT, own, given)


def labels(place: Path, paths: Sequence[Path], parameter: str) -> list[str]:
    """Label of every draw of `parameter` at the paths, in the order of the draws."""
    prefix = ".".join(_element(name, index) for name, index in place)
    found = []
    for path in paths:
        shape = tuple(n for _, dimensions in path for n in dimensions)
        for index in np.ndindex(shape):
            rest, parts = index, [prefix]
            for name, dimensions in path:
                parts.append(_element(name, rest[: len(dimensions)]))
                rest = rest[len(dimensions) :]
            found.append(".".join([*parts, parameter]))
    return found


def _element(name: str, index: tuple[int, ...]) -> str:
    return f"{name}[{','.join(map(str, index))}]" if index else name
