"""Measured drain currents from a table, and a process that is fitted to them.

The table is CSV with the columns

    polarity,width_m,length_m,temperature_C,v_d,v_g,v_s,current_A

voltages to the bulk in V, a pFET's with their signs turned, the current's magnitude in A. A current that is
not above zero is left out and counted.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from circuits.errors import DataError
from circuits.extraction.points import Points
from circuits.silicon.process import POLARITIES, Polarity

COLUMNS = ("polarity", "width_m", "length_m", "temperature_C", "v_d", "v_g", "v_s", "current_A")
"""Columns of a table, in any order."""


def read_points(path: Path) -> tuple[dict[Polarity, Points], int]:
    """Read a table of drain currents.

    Parameters
    ----------
    path
        The CSV file.

    Returns
    -------
    The points by polarity, and how many rows were left out since their current is not above zero.

    Raises
    ------
    DataError
        The file cannot be read, lacks a column, or a row has a word that is no number or no polarity.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: {getattr(error, 'strerror', None) or 'no text'}; name a CSV file") from None
    rows = csv.DictReader(text.splitlines())
    missing = [name for name in COLUMNS if name not in (rows.fieldnames or ())]
    if missing:
        raise DataError(f"{path}: no column {missing[0]}, must have {', '.join(COLUMNS)}; add it")
    values: dict[Polarity, list[list[float]]] = {}
    dropped = 0
    for k, row in enumerate(rows, start=2):
        polarity, numbers = _row(path, k, row)
        if numbers[-1] > 0.0:
            values.setdefault(polarity, []).append(numbers)
        else:
            dropped += 1
    if not values:
        raise DataError(f"{path}: no current above zero; measure where the device conducts")
    return {p: Points(p, *np.array(values[p]).T) for p in POLARITIES if p in values}, dropped


def _row(path: Path, line: int, row: Mapping[str, str | None]) -> tuple[Polarity, list[float]]:
    """Polarity and numbers of a row, in the order of the columns."""
    polarity = row["polarity"]
    if polarity not in POLARITIES:
        raise DataError(f"{path}: line {line}, polarity: {polarity}, must be n or p; correct it")
    numbers = []
    for name in COLUMNS[1:]:
        try:
            value = float(row[name] or "")
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise DataError(f"{path}: line {line}, {name}: {row[name]}, must be a number; correct it")
        numbers.append(value)
    return polarity, numbers
