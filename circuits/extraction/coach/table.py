"""Files of measurements: a CSV whose columns end with their units, such as `v_out_V` and `n1_counts`."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from circuits.arrays import F64
from circuits.errors import DataError
from circuits.extraction.coach.conditions import CIRCUITS, DATA, Condition, check_set, read_conditions

SET_AND_MEASURED: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "nfet": (("v_g_V",), ("i_s_A",)), "pfet": (("v_g_V",), ("i_d_A",)),
    "converter": (("fine_code",), ("n_counts",)),
    "differential-pair": (("v1_V", "v2_V"), ("n1_counts", "n2_counts", "i1_A", "i2_A")),
    "bump-antibump": (
        ("v1_V", "v2_V"), ("n1_counts", "n2_counts", "nout_counts", "i1_A", "i2_A", "iout_A"),
    ),
    "transamp-n": (("v1_V",), ("v_out_V",)), "transamp-p": (("v1_V",), ("v_out_V",)),
    "wide-range-transamp": (("v1_V",), ("v_out_V",)),
    "transamp-n-copies": (
        ("v1_V", "v2_V"), ("n_plus_counts", "n_minus_counts", "i_plus_A", "i_minus_A"),
    ),
    "follower-integrator": (("t_s",), ("v_out_V",)),
    "ring-converters": (("fine_code",), tuple(f"n{k}_counts" for k in range(16))),
    "ring-inputs": (("v_in_V",), tuple(f"n{k}_counts" for k in range(16))),
    "winner-take-all-ring": (
        ("v_in0_V",), ("v_out0_V", "v_out1_V", "n_iout0_counts", "n_iout1_counts"),
    ),
    "dpi-synapse": (("t_nominal_s",), ("v_syn_V", "n_isyn_counts")),
    "axon-hillock": (("t_nominal_s",), ("v_mem_V",)),
    "adaptive-neuron": (("t_nominal_s",), ("v_mem_V",)),
}  # fmt: skip
"""Columns that were set and that were measured, by circuit; `columns_of` has those of one measurement."""
_UNITS = ("V", "A", "s", "rad", "code", "counts")


def columns_of(condition: Condition) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Columns that were set, and that were measured, in a measurement."""
    given, measured = SET_AND_MEASURED[condition.circuit]
    if condition.settings.get("analysis") == "source search":
        return ("v_g_V",), ("v_s_V",)
    if condition.settings.get("analysis") == "output":
        return ("v_g_V", "v_d_V"), measured
    if condition.settings.get("input") == "sine":
        return ("phase_rad", "v_in_V"), measured
    if condition.name.startswith("wta_hyst"):
        return given, (*measured, "n_iall0_counts", "n_iall1_counts")
    return given, measured


class Table(dict[str, F64]):
    """Columns of a measurement by name, float64[points] each; NaN where a field is empty."""


def read_table(path: Path, condition: Condition) -> Table:
    """Read a measurement.

    path: its file. condition: what was set at it, which says what columns there must be.

    Raises `DataError` where the file cannot be read, lacks a column or has one in another unit, has a field
    that is no number, a voltage or code that cannot be set or is not stated, or another number of rows than
    its condition says.
    """
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            rows = list(csv.reader(stream))
    except OSError as error:
        raise DataError(f"{path}: {error.strerror}; name a folder with the measurements") from None
    except UnicodeDecodeError:
        raise DataError(f"{path}: no UTF-8 text; save it as CSV") from None
    header = rows[0] if rows else []
    given, measured = columns_of(condition)
    _check_header(path, header, (*given, *measured))
    columns: list[list[float]] = [[] for _ in header]
    for line, row in enumerate(rows[1:], 2):
        if len(row) != len(header):
            raise DataError(f"{path}: line {line}: {len(row)} fields, must be {len(header)}; correct it")
        for name, text, column in zip(header, row, columns, strict=True):
            column.append(_number(path, line, name, text))
            if name in given:
                _check_given(path, line, name, column[-1])
    if len(rows) - 1 != condition.points:
        raise DataError(
            f"{path}: {len(rows) - 1} rows, must be {condition.points} as in its condition; correct either"
        )
    return Table({name: np.array(column) for name, column in zip(header, columns, strict=True)})


def _check_header(path: Path, header: Sequence[str], wanted: Sequence[str]) -> None:
    for name in wanted:
        if name in header:
            continue
        quantity = name.rpartition("_")[0]
        other = next((h for h in header if h.rpartition("_")[0] == quantity), None)
        if other is not None:
            raise DataError(
                f"{path}: line 1: column {other}, must be in {name.rpartition('_')[2]} as {name}; convert it"
            )
        raise DataError(f"{path}: line 1: no column {name}, must be there; add it")


def _number(path: Path, line: int, name: str, text: str) -> float:
    if not text.strip():
        return math.nan
    try:
        value = float(text)
    except ValueError:
        value = math.inf
    if not math.isfinite(value):
        raise DataError(f"{path}: line {line}: {name}: {text!r}, must be a finite number; correct it")
    return value


def _check_given(path: Path, line: int, name: str, value: float) -> None:
    if math.isnan(value):
        raise DataError(f"{path}: line {line}: {name}: empty, must be what was set; fill it in")
    check_set(f"{path}: line {line}: {name}", name.rpartition("_")[2], value)


def format_table(columns: Mapping[str, F64]) -> str:
    """Give the text of a table, each number in six digits as in the files of measurements."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow(["" if math.isnan(value) else f"{value:.6g}" for value in row])
    return stream.getvalue()


def read_folder(
    folder: Path | None, split: str, conditions: Mapping[str, Condition] | None = None
) -> dict[str, tuple[Condition, Table]]:
    """Read all measurements of a folder, by name.

    Parameters
    ----------
    folder
        The folder; the package's own of that split unless given.
    split
        `fit` or `predict`: which conditions are meant.
    conditions
        What was set; the package's own unless given.

    Raises
    ------
    DataError
        A file is no measurement, one has no condition, or there is none.
    """
    folder = folder or DATA / split
    known = read_conditions() if conditions is None else conditions
    return dict(_measurements(folder, split, known))


def _measurements(
    folder: Path, split: str, known: Mapping[str, Condition]
) -> Iterator[tuple[str, tuple[Condition, Table]]]:
    paths = sorted(folder.glob("*.csv"))
    if not paths:
        raise DataError(f"{folder}: no CSV files, must be a folder of measurements; name one")
    for path in paths:
        condition = known.get(path.stem)
        if condition is None:
            raise DataError(f"{path}: no condition of that name; add it to the table of conditions")
        if condition.split != split:
            raise DataError(f"{path}: its condition is of {condition.split}, must be of {split}; move it")
        if condition.circuit in CIRCUITS:
            yield path.stem, (condition, read_table(path, condition))
