"""Samples of a study as columns, and their files.

A sample is one die at one corner and temperature in one trial. Rows stand in the order of dies, then corners,
temperatures and trials, whatever the order in which they were measured. A file carries the key of the study
that it is of and is sealed: another study's file, or one that was edited, is not believed.
"""

from __future__ import annotations

import csv
import io
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.catalogue import later
from circuits.errors import DataError, ParameterError
from circuits.seal import check_sealed, sealed
from circuits.silicon.die import CORNERS
from circuits.silicon.process import check_temperature
from system.files.writing import write_bytes_atomic

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

h5py = later("h5py")  # which measures nothing

FAILED = "failed"
MOST = 1_000_000  # samples of a table; ours
_ARRAYS, _WORDS = ("die", "temperature_c", "trial", "values"), ("corner", "outcome", "reason")  # of a table
_FORMAT = 2  # 1 had no key of its study
_BROKEN = (
    OSError, KeyError, ValueError, RuntimeError, TypeError, AttributeError, OverflowError, MemoryError,
)  # what HDF5 and its arrays raise for contents that are none  # fmt: skip


@dataclass(frozen=True, slots=True)
class Condition:
    """Where every die of a study is measured.

    Attributes
    ----------
    corner : str
        Corner of the process: `random`, `typical`, `ss`, `ff`, `sf` or `fs`.
    temperature_c : float
        Temperature, degC.
    trial : int
        Seed of what is not silicon.

    Raises
    ------
    ParameterError
        No silicon has the corner or the temperature, or the trial is negative.
    """

    corner: str
    temperature_c: float
    trial: int

    def __post_init__(self) -> None:
        """Check corner, temperature and trial."""
        if self.corner not in CORNERS:
            raise ParameterError(f"corner: {self.corner}, must be one of {', '.join(CORNERS)}")
        check_temperature(self.temperature_c)
        if self.trial < 0:
            raise ParameterError(f"trial: {self.trial}, must be at least 0")


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """The n samples of a study, one in each row.

    Attributes
    ----------
    metrics : tuple of str
        Names of the metrics.
    die : array
        Number of the die, int64[n].
    corner : tuple of str
        Corner of each sample.
    temperature_c : array
        Temperature of each sample, float64[n], degC.
    trial : array
        Trial of each sample, int64[n].
    outcome : tuple of str
        Class of each sample; `failed` where it has none.
    reason : tuple of str
        Why each sample failed, or has no value of a metric; empty where there is nothing to say.
    values : array
        The metrics, float64[n, metrics], in SI units, NaN where not defined.
    """

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

    @property
    def failed(self) -> list[int]:
        """Rows of the samples that failed."""
        return [k for k, outcome in enumerate(self.outcome) if outcome == FAILED]

    def column(self, metric: str) -> F64:
        """Give the values of `metric`, float64[n], in its SI unit, NaN where not defined."""
        return np.asarray(self.values[:, self.metrics.index(metric)])


def unmeasured(table: Table) -> dict[str, int]:
    """How many samples have no value of a metric, by the reasons that they give, the most frequent first."""
    said = (r for r, o in zip(table.reason, table.outcome, strict=True) if r and o != FAILED)
    return counted(each for reason in said for each in reason.split("; "))


def empty(metrics: Sequence[str]) -> Table:
    """Make a table without samples."""
    none: tuple[str, ...] = ()
    return Table(
        tuple(metrics), np.zeros(0, np.int64), none, np.zeros(0), np.zeros(0, np.int64), none, none,
        np.zeros((0, len(metrics))),
    )  # fmt: skip


def join(tables: Sequence[Table]) -> Table:
    """Put tables of one study one after the other."""
    arrays: dict[str, Any] = {name: np.concatenate([getattr(t, name) for t in tables]) for name in _ARRAYS}
    words: dict[str, Any] = {name: tuple(x for t in tables for x in getattr(t, name)) for name in _WORDS}
    return Table(tables[0].metrics, **arrays, **words)


def select(table: Table, mask: Bools) -> Table:
    """Give the samples that `mask` keeps."""
    keep = np.flatnonzero(mask)
    arrays: dict[str, Any] = {name: getattr(table, name)[keep] for name in _ARRAYS}
    words: dict[str, Any] = {name: tuple(getattr(table, name)[k] for k in keep) for name in _WORDS}
    return Table(table.metrics, **arrays, **words)


def counted(words: Iterable[str]) -> dict[str, int]:
    """How often each word is there, the most frequent first, those that are as frequent by the alphabet."""
    return dict(sorted(Counter(words).items(), key=lambda item: (-item[1], item[0])))


def place_text(corner: str, *temperatures_c: float) -> str:
    """Temperatures and a corner in words, as `27 degC, corner ss`; a corner that is drawn is not told."""
    celsius = ", ".join(f"{t:g}" for t in temperatures_c)
    return f"{celsius} degC" + ("" if corner == "random" else f", corner {corner}")


def to_dataset(table: Table, units: Sequence[str], key: str = "") -> xr.Dataset:
    """Labelled columns over the dimension `sample`; `key`: of the study that they are of."""
    columns: dict[str, tuple[str, object]] = {
        "die": ("sample", table.die),
        "corner": ("sample", np.array(table.corner, dtype=object)),
        "temperature_C": ("sample", table.temperature_c),
        "trial": ("sample", table.trial),
        "outcome": ("sample", np.array(table.outcome, dtype=object)),
        "reason": ("sample", np.array(table.reason, dtype=object)),
    }
    data = xr.Dataset(columns, attrs={"format": _FORMAT, "metrics": list(table.metrics), "study": key})
    for k, (name, unit) in enumerate(zip(table.metrics, units, strict=True)):
        data[f"metric_{name}"] = ("sample", table.values[:, k])
        data[f"metric_{name}"].attrs["units"] = unit
    return data


def write_table(path: Path, table: Table, units: Sequence[str], key: str) -> None:
    """Write a study's table as netCDF, whole or not at all; `DataError` where it cannot be written."""
    write_bytes_atomic(path, sealed(to_dataset(table, units, key).to_netcdf(engine="h5netcdf")))


def read_table(path: Path, key: str) -> Table:
    """Read what `write_table` wrote for the study of that key.

    Raises `DataError` for a file that is missing, broken, of another kind or study, or was changed since.
    """
    try:
        with path.open("rb") as contents:
            check_sealed(contents)
        with h5py.File(path, "r") as file:
            found = _read(path, file)
            written_for = _text(file.attrs["study"])
    except _BROKEN as error:
        if isinstance(error, DataError):
            raise
        text = " ".join(str(error).split()) or type(error).__name__
        raise DataError(f"{path}: cannot be read, {text[:200]}; measure it again") from None
    if written_for != key:
        raise DataError(f"{path}: is of another study; measure it again")
    return found


def _read(path: Path, file: Any) -> Table:
    version = np.asarray(file.attrs.get("format", 0)).item()
    if version != _FORMAT:
        raise DataError(f"{path}: is no table of samples, format {version}; measure it again")
    count = int(file["die"].size)
    if count > MOST:
        raise DataError(f"{path}: {count} samples, must be at most {MOST}; measure it again")
    metrics = tuple(_text(m) for m in np.atleast_1d(file.attrs["metrics"]))
    words = {k: _words(file, k, count) for k in ("corner", "outcome", "reason")}
    values = np.empty((count, len(metrics)))
    for k, metric in enumerate(metrics):
        values[:, k] = _column(file, f"metric_{metric}", np.float64, count)
    die, trial = (np.array(_column(file, k, np.int64, count)) for k in ("die", "trial"))
    temperature = np.array(_column(file, "temperature_C", np.float64, count))
    return Table(metrics, die, words["corner"], temperature, trial, words["outcome"], words["reason"], values)


def _words(file: Any, name: str, count: int) -> tuple[str, ...]:
    return tuple(_column(file, name, object, count).asstr()[:]) if count else ()


def _column(file: Any, name: str, kind: type, count: int) -> Any:
    """A column, held against what a table has; `TypeError` for one that is not of its kind and length."""
    column = file[name]
    if column.dtype != kind or column.shape != (count,):
        raise TypeError(f"{name} is {column.dtype}{column.shape}, must be {np.dtype(kind)}({count},)")
    return column


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def to_csv(table: Table, units: Sequence[str]) -> str:
    """Write `die,corner,temperature_C,trial,class,METRIC_UNIT ...,reason`; undefined metrics are empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = [f"{n}_{u}" if u else n for n, u in zip(table.metrics, units, strict=True)]
    writer.writerow(["die", "corner", "temperature_C", "trial", "class", *names, "reason"])
    for k in range(len(table)):
        cells = ["" if math.isnan(x) else repr(x) for x in table.values[k].tolist()]
        where = [int(table.die[k]), table.corner[k], repr(float(table.temperature_c[k])), int(table.trial[k])]
        writer.writerow([*where, table.outcome[k], *cells, table.reason[k]])
    return text.getvalue()
