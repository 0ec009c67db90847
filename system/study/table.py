"""Samples of a study as columns, and their files.

A sample is one die at one corner and temperature in one trial. Rows stand in the order of dies, then corners,
temperatures and trials, whatever the order in which they were measured.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from circuits.errors import DataError
from system.files import replace_atomic

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

FAILED = "failed"
_FORMAT = 1


@dataclass(frozen=True, slots=True)
class Condition:
    """Where every die is measured: corner, temperature (degC), trial (seed of what is not silicon)."""

    corner: str
    temperature_c: float
    trial: int


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """n samples. values: float64[n, metrics], SI, NaN where not defined; a failed sample has a reason."""

    metrics: tuple[str, ...]
    die: I64
    corner: tuple[str, ...]
    temperature_c: F64
    trial: I64
    outcome: tuple[str, ...]
    reason: tuple[str, ...]
    values: F64

    def __len__(self) -> int:
        return self.die.size

    def column(self, metric: str) -> F64:
        """Values of a metric."""
        return np.asarray(self.values[:, self.metrics.index(metric)])


def empty(metrics: Sequence[str]) -> Table:
    """No samples yet."""
    none: tuple[str, ...] = ()
    return Table(
        tuple(metrics), np.zeros(0, np.int64), none, np.zeros(0), np.zeros(0, np.int64), none, none,
        np.zeros((0, len(metrics))),
    )  # fmt: skip


def join(tables: Sequence[Table]) -> Table:
    """Tables of one study, one after the other."""
    return Table(
        tables[0].metrics,
        np.concatenate([t.die for t in tables]),
        tuple(x for t in tables for x in t.corner),
        np.concatenate([t.temperature_c for t in tables]),
        np.concatenate([t.trial for t in tables]),
        tuple(x for t in tables for x in t.outcome),
        tuple(x for t in tables for x in t.reason),
        np.concatenate([t.values for t in tables]),
    )


def select(table: Table, mask: NDArray[np.bool_]) -> Table:
    """The samples that `mask` keeps."""
    keep = np.flatnonzero(mask)
    return Table(
        table.metrics,
        table.die[keep],
        tuple(table.corner[k] for k in keep),
        table.temperature_c[keep],
        table.trial[keep],
        tuple(table.outcome[k] for k in keep),
        tuple(table.reason[k] for k in keep),
        table.values[keep],
    )


def to_dataset(table: Table, units: Sequence[str]) -> xr.Dataset:
    """Labelled columns over the dimension `sample`."""
    columns: dict[str, tuple[str, object]] = {
        "die": ("sample", table.die),
        "corner": ("sample", np.array(table.corner, dtype=object)),
        "temperature_C": ("sample", table.temperature_c),
        "trial": ("sample", table.trial),
        "outcome": ("sample", np.array(table.outcome, dtype=object)),
        "reason": ("sample", np.array(table.reason, dtype=object)),
    }
    data = xr.Dataset(columns, attrs={"format": _FORMAT, "metrics": list(table.metrics)})
    for k, (name, unit) in enumerate(zip(table.metrics, units, strict=True)):
        data[f"metric_{name}"] = ("sample", table.values[:, k])
        data[f"metric_{name}"].attrs["units"] = unit
    return data


def write_table(path: Path, table: Table, units: Sequence[str]) -> None:
    """Write a table as netCDF, whole or not at all; `DataError` where it cannot be written."""
    with replace_atomic(path) as temporary:
        to_dataset(table, units).to_netcdf(temporary, engine="h5netcdf")


def read_table(path: Path) -> Table:
    """Read what `write_table` wrote.

    Raises `DataError` for a file that is missing, broken or of another kind.
    """
    try:
        with xr.open_dataset(path, engine="h5netcdf") as data:
            if data.attrs.get("format") != _FORMAT:
                raise DataError(f"{path}: not a table of samples, format {data.attrs.get('format')}")
            metrics = tuple(str(m) for m in np.atleast_1d(data.attrs["metrics"]))
            words = {k: tuple(str(x) for x in data[k].values) for k in ("corner", "outcome", "reason")}
            values = [np.asarray(data[f"metric_{m}"].values, np.float64) for m in metrics]
            return Table(
                metrics, data["die"].values.astype(np.int64), words["corner"],
                data["temperature_C"].values.astype(np.float64), data["trial"].values.astype(np.int64),
                words["outcome"], words["reason"], np.stack(values, axis=1),
            )  # fmt: skip
    except (OSError, KeyError, ValueError, RuntimeError) as error:
        if isinstance(error, DataError):
            raise
        text = " ".join(str(error).split()) or type(error).__name__
        raise DataError(f"{path}: cannot be read, {text[:200]}; measure it again") from error


def to_csv(table: Table, units: Sequence[str]) -> str:
    """`die,corner,temperature_C,trial,class,METRIC_UNIT ...,reason`; empty where a metric is not defined."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = [f"{n}_{u}" if u else n for n, u in zip(table.metrics, units, strict=True)]
    writer.writerow(["die", "corner", "temperature_C", "trial", "class", *names, "reason"])
    for k in range(len(table)):
        cells = ["" if math.isnan(x) else repr(x) for x in table.values[k].tolist()]
        where = [int(table.die[k]), table.corner[k], repr(float(table.temperature_c[k])), int(table.trial[k])]
        writer.writerow([*where, table.outcome[k], *cells, table.reason[k]])
    return text.getvalue()
