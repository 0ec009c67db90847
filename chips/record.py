"""Records: what was measured of a circuit at transistor level for the behavioural model that stands for it.

A record has axes (numbers, or names), tables over them, errors of its model on dies that were not used, and
a box, outside which the model is not valid. Its key is a hash of what was measured: circuits, process,
version of the measurement and grid. Beside it stands the law that it was measured by, as numbers at a fixed
lattice (`chips.law_lattice`). When one of them changes the record is stale, and `noctule characterise`
measures it again.

In its file, which is netCDF (`chips.record_file`), axes are coordinates and tables variables; an error is an
attribute `error_NAME`, a side of the box `box_NAME` with its least and its greatest value. The law's numbers
are the variable `law`, whatever else there is of it the attribute of that name. An axis is a side
of the box too, from its first to its last number, unless the box has one of that name. Units are SI,
temperatures in degC; names of errors and of the box's sides end in their unit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, cast

import numpy as np

from chips.law_lattice import Law, changed, law_from, law_text
from chips.record_file import Contents, load_record, record_file, record_name, save_record, stale
from circuits.arrays import F64
from circuits.catalogue import later
from circuits.circuit import Circuit
from circuits.errors import DataError
from circuits.silicon.process import AMI_1500_IDEAL, Process

xr = later("xarray")  # which is for those who write

_REMEDY = "run noctule characterise"
_ERROR, _BOX, _LAW = "error_", "box_", "law"
WITHOUT_BIASES = ("name", "ports", "devices")  # parts of a circuit that a key may depend on
WHOLE = (*WITHOUT_BIASES, "biases")

Axis = tuple[float, ...] | tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Table:
    """Numbers over axes.

    Attributes
    ----------
    axes : tuple of str
        Names of the axes, the outermost first. One need not be an axis of the record, if its places have
        neither number nor name.
    values : array
        The numbers, float64 with one dimension for each axis, in the unit of the quantity; its shape is that
        of the axes.
    """

    axes: tuple[str, ...]
    values: F64


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """What was measured of circuits.

    Attributes
    ----------
    key, version
        A hash of what it was measured of, and the version of the measurement, which is a part of the key.
    axes
        Numbers or names along each axis, by its name.
    tables
        Tables by their names.
    errors
        Errors of the model on dies that were not used, by name with the unit at its end.
    box
        Least and greatest valid value by name, in its unit, beside the ends of the axes.
    law
        The law by which it was measured; None in one that is made by hand.
    """

    key: str
    version: int
    axes: Mapping[str, Axis]
    tables: Mapping[str, Table]
    errors: Mapping[str, float] = field(default_factory=dict)
    box: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    law: Law | None = None

    def __getitem__(self, name: str) -> F64:
        """Return the numbers of a table or an axis.

        Raises `DataError` where the record has none of that name.
        """
        if name in self.tables:
            return self.tables[name].values
        return np.array(self.numbers(name))

    def numbers(self, name: str) -> tuple[float, ...]:
        """Return the numbers of the axis `name`, rising, in the unit of the axis.

        Raises `DataError` where the record has no such axis.
        """
        return cast("tuple[float, ...]", self._axis(name, float))

    def names(self, name: str) -> tuple[str, ...]:
        """Return the names of the axis `name`; raises `DataError` where the record has no such axis."""
        return cast("tuple[str, ...]", self._axis(name, str))

    def limits(self, name: str) -> tuple[float, float]:
        """Return the least and the greatest valid value of the side `name` of the box, in its unit.

        Raises `DataError` where there is none.
        """
        if name in self.box:
            return self.box[name]
        numbers = self.numbers(name)
        return numbers[0], numbers[-1]

    def _axis(self, name: str, kind: type) -> Axis:
        found = self.axes.get(name, ())
        if not found or not isinstance(found[0], kind):
            what = "names" if kind is str else "numbers"
            raise DataError(f"record.{name}: no axis of {what} is in it, must be; {_REMEDY}")
        return found

    def extended(self, tables: Mapping[str, Table], axes: Mapping[str, Axis] | None = None) -> Record:
        """Return the record with more tables and axes."""
        return replace(self, tables={**self.tables, **tables}, axes={**self.axes, **(axes or {})})


def record_key(*parts: object) -> str:
    """Return the key of a record: a hash of all `parts` that it depends on, by their `repr`."""
    return sha256(repr(parts).encode()).hexdigest()[:32]


def content(circuit: Circuit, parts: tuple[str, ...] = WHOLE) -> tuple[object, ...]:
    """Return what a key depends on of a circuit, and of the circuits in it.

    Parameters
    ----------
    circuit
        The circuit.
    parts
        Which fields count: `WHOLE` or `WITHOUT_BIASES`.
    """
    inner = tuple((i.name, content(i.circuit, parts), dict(i.connections)) for i in circuit.instances)
    return (*(getattr(circuit, part) for part in parts), inner)


def record_digest(record: Record) -> str:
    """Return a hash of what a record says, in hexadecimal: its key, axes, tables, errors and box."""
    tables = {name: (t.axes, t.values.shape, t.values.tobytes()) for name, t in record.tables.items()}
    said = (record.axes, tables, record.errors, record.box)
    text = repr((record.key, record.version, *(sorted(each.items()) for each in said)))
    return sha256(text.encode()).hexdigest()


def write_record(record: Record, path: Path) -> None:
    """Write a record's netCDF file."""
    attributes: dict[str, object] = {"key": record.key, "version": record.version}
    attributes |= {f"{_ERROR}{name}": value for name, value in record.errors.items()}
    attributes |= {f"{_BOX}{name}": list(ends) for name, ends in record.box.items()}
    tables: dict[str, Any] = {name: (table.axes, table.values) for name, table in record.tables.items()}
    if record.law is not None:
        attributes[_LAW], numbers = law_text(record.law)
        tables[_LAW] = ("law_number", numbers)
    save_record(xr.Dataset(tables, {n: list(axis) for n, axis in record.axes.items()}, attributes), path)


def read_record(path: Path) -> Record:
    """Read a record from the netCDF file at `path`; raises `DataError` for a file that is none."""
    data = load_record(path)
    try:
        if "key" not in data.attributes:
            raise ValueError("it has no key")
        with np.errstate(invalid="raise"):  # numbers that no float holds
            return Record(
                str(data.attributes["key"]),
                int(data.attributes.get("version", 0)),
                {name: _axis_of(values) for name, values in data.axes.items()},
                {name: _table_of(data, name) for name in data.tables if name != _LAW},
                {name: float(value) for name, value in _named(data, _ERROR)},
                {name: _ends(value) for name, value in _named(data, _BOX)},
                _law_of(data),
            )
    except (ValueError, TypeError, FloatingPointError) as error:
        reason = " ".join(str(error).split())[:200]
        raise DataError(f"{path}: no record, {reason}; delete it, or {_REMEDY}") from None


def _named(data: Contents, prefix: str) -> Iterator[tuple[str, Any]]:
    """Attributes whose names begin so, by the rest of their names."""
    for name, value in data.attributes.items():
        if name.startswith(prefix):
            yield name.removeprefix(prefix), value


def _law_of(data: Contents) -> Law | None:
    if _LAW not in data.attributes or _LAW not in data.tables:
        return None
    return law_from(str(data.attributes[_LAW]), _table_of(data, _LAW).values)


def _axis_of(values: Any) -> Axis:
    if values.dtype.kind in "OSU":
        return tuple(map(str, values))
    return tuple(float(x) for x in values)


def _table_of(data: Contents, name: str) -> Table:
    dimensions, found = data.tables[name]
    values = np.asarray(found)
    if values.dtype.kind not in "fiu":
        raise ValueError(f"{name} is of {values.dtype}, must be of numbers")
    return Table(dimensions, np.asarray(values, dtype=np.float64))


def _ends(value: Any) -> tuple[float, float]:
    ends = np.ravel(np.asarray(value, dtype=np.float64))
    if ends.size != 2:
        raise ValueError(f"a side of the box has {ends.size} ends, must have two")
    return float(ends[0]), float(ends[1])


_IN_FORCE: ContextVar[Mapping[str, Record] | None] = ContextVar("records", default=None)


@contextmanager
def recorded(block: str, record: Record, process: Process = AMI_1500_IDEAL) -> Iterator[None]:
    """Put a record in force for a block in a process while the context lasts, whatever is kept of it."""
    token = _IN_FORCE.set({**(_IN_FORCE.get() or {}), record_name(block, process): record})
    try:
        yield
    finally:
        _IN_FORCE.reset(token)


@cache
def kept_record(block: str, process: Process = AMI_1500_IDEAL) -> Record:
    """Return the record of a block in a process that is kept, the user's own or else the package's.

    Raises `DataError` without one, and where it was measured by another law than today's.
    """
    record = read_record(record_file(block, process))
    other = changed(record.law) if record.law is not None else "a law that it does not tell"
    if other:
        raise stale(block, other, process)
    return record


def in_force(block: str, process: Process = AMI_1500_IDEAL) -> bool:
    """Return whether `recorded` has put a record in the place of the kept one."""
    return record_name(block, process) in (_IN_FORCE.get() or {})


def current_record(block: str, process: Process = AMI_1500_IDEAL) -> Record:
    """Return the record of a block in a process that is in force: that of `recorded`, else the kept one."""
    found = (_IN_FORCE.get() or {}).get(record_name(block, process))
    return found or kept_record(block, process)


def matching_record(block: str, key: Callable[[Record], str], process: Process = AMI_1500_IDEAL) -> Record:
    """Return the record of the block that is called `block`, as it is in force for a process.

    Raises `DataError` unless its key is `key` of the record.
    """
    record = current_record(block, process)
    if record.key != key(record):
        raise stale(block, process=process)
    return record
