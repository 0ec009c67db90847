"""What measurements left of a die, as the table `posterior` of its file.

    [[posterior.unknown]]
    name = "differential_pair.m1.v_t0"
    unit = "V"
    kind = "device"
    before = [0.0, 4.9e-3]         # mean and standard deviation before the fit
    after = [2.9e-3, 3.4e-3]       # and after it

    [posterior]
    correlation = [[1.0], [0.2, 1.0]]          # lower triangle, a row an unknown
    noise = { "ndp_run1 n1_counts" = 1.2 }     # factor of the noise of readings that were fitted

Commands take the die's deviations from `deviation`; `noctule predict` takes all of this.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from circuits.errors import DataError
from circuits.extraction.coach.unknown import Kind, Posterior, Unknown

_DIGITS = 10  # of a mean or a standard deviation; correlations have five


class UnknownRow(msgspec.Struct, forbid_unknown_fields=True):
    """An unknown before and after the fit.

    Attributes
    ----------
    name, unit, kind : str
        Its name, unit, and whether it is of the process, a device or the bench.
    before, after : list of float
        Mean and standard deviation, in its unit.
    """

    name: str
    unit: str
    kind: Kind
    before: tuple[float, float]
    after: tuple[float, float]


class PosteriorTable(msgspec.Struct, forbid_unknown_fields=True):
    """What measurements left of a die.

    Attributes
    ----------
    unknown : list
        The unknowns.
    correlation : list of list of float
        Lower triangle of the correlation of all.
    noise : dict
        Factor of the readings' noise, by measurement and column.
    """

    unknown: list[UnknownRow]
    correlation: list[list[float]]
    noise: dict[str, float] = {}


def posterior_table(posterior: Posterior, noise: Mapping[tuple[str, str], float]) -> PosteriorTable:
    """The table of a posterior, and of factors of the noise by measurement and column."""
    rows = [
        UnknownRow(u.name, u.unit, u.kind, (u.mean, u.sd), (_short(mean), _short(sd)))
        for u, mean, sd in zip(posterior.unknowns, posterior.mean, posterior.sd, strict=True)
    ]
    correlation = [
        [round(float(x), 5) + 0.0 for x in row[: k + 1]] for k, row in enumerate(posterior.correlation)
    ]
    return PosteriorTable(rows, correlation, {" ".join(key): round(f, 4) for key, f in noise.items()})


def posterior_of(table: PosteriorTable, where: str) -> tuple[Posterior, dict[tuple[str, str], float]]:
    """The posterior of a table, and factors of the noise.

    Parameters
    ----------
    table
        The table.
    where
        Its file.

    Raises
    ------
    DataError
        The correlation is no lower triangle of the unknowns.
    """
    count = len(table.unknown)
    if [len(row) for row in table.correlation] != list(range(1, count + 1)):
        raise DataError(f"{where}: posterior.correlation: must be a lower triangle of {count} rows")
    correlation = np.zeros((count, count))
    for k, row in enumerate(table.correlation):
        correlation[k, : k + 1] = row
    correlation += np.tril(correlation, -1).T
    mean, sd = np.array([row.after for row in table.unknown]).T
    unknowns = tuple(Unknown(row.name, *row.before, row.unit, row.kind) for row in table.unknown)
    noise: dict[tuple[str, str], float] = {}
    for key, factor in table.noise.items():
        name, _, column = key.partition(" ")
        noise[name, column] = factor
    return Posterior(unknowns, mean, correlation * np.outer(sd, sd)), noise


def _short(value: Any) -> float:
    return float(f"{float(value):.{_DIGITS}g}")
