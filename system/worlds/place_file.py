"""Files of obstacles: CSV with the header `x_m,y_m`, then the place of an obstacle a line, in m."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from circuits.arrays import F64
from circuits.errors import DataError

HEADER = ("x_m", "y_m")
_SHOWN = 30  # characters of an offending value that an error repeats

Range = tuple[float, float]  # m, from and to below


def read_places(path: str, x: Range, y: Range) -> F64:
    """Places, float64[n, 2] in m, with x and y in their ranges; empty lines are none.

    Raises
    ------
    DataError
        The file cannot be read, or is no such map: the text names file and line.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise _not_a_map(path, 1, "bytes that are not UTF-8") from None
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise DataError(f"{path}: {reason}, must be a readable file; check path and permissions") from None
    rows = [(k, row) for k, row in enumerate(_rows(path, text), start=1) if any(cell.strip() for cell in row)]
    if not rows or tuple(cell.strip() for cell in rows[0][1]) != HEADER:
        shown = ",".join(rows[0][1])[:_SHOWN] if rows else "an empty file"
        raise _not_a_map(path, rows[0][0] if rows else 1, shown)
    if len(rows) == 1:
        raise DataError(f"{path}: no obstacle, must have at least one line of x_m,y_m after the header")
    return np.array([_point(path, line, row, (x, y)) for line, row in rows[1:]])


def _rows(path: str, text: str) -> list[list[str]]:
    try:
        return list(csv.reader(text.splitlines(), strict=True))
    except csv.Error as error:
        raise _not_a_map(path, 1, str(error)) from None


def _point(path: str, line: int, row: list[str], ranges: tuple[Range, Range]) -> tuple[float, float]:
    if len(row) != len(HEADER):
        raise _not_a_map(path, line, ",".join(row)[:_SHOWN])
    values = []
    for name, text, (low, high) in zip(HEADER, row, ranges, strict=True):
        try:
            value = float(text)
        except ValueError:
            raise _not_a_map(path, line, text.strip()[:_SHOWN]) from None
        if not low <= value < high:
            raise DataError(f"{path}:{line}: {name}: {value:g} m, must be from {low:g} to below {high:g} m")
        values.append(value)
    return values[0], values[1]


def _not_a_map(path: str, line: int, shown: str) -> DataError:
    return DataError(
        f"{path}:{line}: {shown!r}, must be a map of a forest: the header x_m,y_m, then two numbers a line"
    )
