"""Rows of a CSV file, read into a dataclass whose fields are options (`system.option`).

The first line names the columns, in any order. A column is the name of a field's option, and has its unit and
its limits; one whose field has a default may be left out. Numbers are plain digits, text is as it is. Blank
lines are skipped.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping
from dataclasses import MISSING
from pathlib import Path
from typing import Any, TypeVar

from circuits.errors import DataError, ParameterError
from system.files.text import read_text
from system.option import Setting, settings

_SHOWN = 40  # characters of an offending value that an error repeats; ours
_DIGITS = "write it in plain digits, such as 0.25"

T = TypeVar("T")


def read_rows(path: str | Path, kind: type[T]) -> list[tuple[int, T]]:
    """Rows of a file as values of the dataclass `kind`, each with the number of its line.

    Raises
    ------
    DataError
        The file cannot be read, its first line is no header, it has no row, or a cell is not what its column
        takes: one line of file, line, column, value, rule and remedy.
    """
    columns = settings(kind)  # type: ignore[arg-type]  # a type is hashable
    rows = _cells(path)
    _, header = next(rows, (1, []))
    _check_header(path, header, columns)
    found = []
    for line, cells in rows:
        if len(cells) != len(header):
            rule = f"must have {len(header)}"
            raise refusal(path, line, "row", f"{len(cells)} cells", rule, "match the header")
        if cells == header:
            raise refusal(path, line, "row", ",".join(cells), "must be data", "remove the second header")
        given = {
            columns[name].field: _value(path, line, columns[name], text)
            for name, text in zip(header, cells, strict=True)
        }
        found.append((line, kind(**given)))
    if not found:
        raise refusal(path, 2, "row", "end of file", "must have at least one row of data", "add one")
    return found


def refusal(path: str | Path, line: int, what: str, value: str, rule: str, remedy: str) -> DataError:
    """Return the error for what a line has: `path:line: column: 'value', rule; remedy`."""
    return DataError(f"{path}:{line}: {what}: {shortened(value)}, {rule}; {remedy}")


def shortened(value: str) -> str:
    """Return a value in quotes as an error repeats it, long ones cut off."""
    return repr(value if len(value) <= _SHOWN else value[:_SHOWN] + "...")


def _cells(path: str | Path) -> Iterator[tuple[int, list[str]]]:
    """Cells of every line that is not blank, and its number."""
    reader = csv.reader(io.StringIO(read_text(path, "a CSV file"), newline=""), strict=True)
    while True:
        try:
            cells = [cell.strip() for cell in next(reader)]
        except StopIteration:
            return
        except csv.Error as error:
            line = reader.line_num
            raise refusal(path, line, "row", str(error), "must be CSV", "check quotes and commas") from None
        if any(cells):
            yield reader.line_num, cells


def _check_header(path: str | Path, header: list[str], columns: Mapping[str, Setting]) -> None:
    required = [name for name, one in columns.items() if one.default is MISSING]
    optional = "".join(f"[,{name}]" for name in columns if name not in required)
    remedy = f"the first line must be {','.join(required)}{optional}"
    if not header:
        raise refusal(path, 1, "header", "empty file", "must have a header", remedy)
    for name in header:
        if header.count(name) > 1:
            raise refusal(path, 1, "header", name, "must appear once", remedy)
        if name not in columns:
            raise refusal(path, 1, "header", name, "must be a known column", remedy)
    for name in required:
        if name not in header:
            raise refusal(path, 1, "header", ",".join(header), f"must have the column {name}", remedy)


def _value(path: str | Path, line: int, column: Setting, text: str) -> Any:
    """Value of a cell, a text or a number in the column's unit."""
    if column.kind is str:
        if not text:
            raise refusal(path, line, column.name, text, "must not be blank", "give it a name")
        return text
    try:
        number = float(text)
    except ValueError:
        raise refusal(path, line, column.name, text, "must be a number", _DIGITS) from None
    if not math.isfinite(number) or "_" in text:
        raise refusal(path, line, column.name, text, "must be a finite number", _DIGITS)
    try:
        column.check(number)
    except ParameterError as error:
        raise DataError(f"{path}:{line}: {error}; it is the {column.option.help}") from None
    return number
