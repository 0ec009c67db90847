"""Records of the boards' and the hearing's behavioural models: numbers over temperature and process.

A quantity q is measured over temperature and over the threshold shift that all transistors of a polarity
share on a die, and put together as `q(T, s_n, s_p) = q_n(T, s_n) + q_p(T, s_p) - q_n(T, 0)`: a polynomial
through all temperatures, monotone cubics through the shifts. Mismatch inside a board is left to the errors,
but where a block's own measurement says otherwise.

A record is a netCDF file `<block>.nc` (`chips.record_file`). Its key is a hash of the circuits with their
biases, the process, the version of the measurement and its grid: when one of them changes the record is
stale, and `noctule characterise` measures it again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from hashlib import sha256
from pathlib import Path

import numpy as np
import xarray as xr

from chips.interpolation import monotone_cubic
from chips.record_file import load_record, record_file, save_record, stale
from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.silicon.die import shared
from circuits.silicon.process import AMI_1500, Polarity, Process
from circuits.silicon.silicon import Silicon

VERSION = 2  # of the measurements: what they measure and how
TEMPERATURES = (-10.0, 8.0, 27.0, 46.0, 65.0)  # degC
WIDEST = 0.12  # V, largest shared threshold shift that is measured: 3.6 sigma
POLARITIES: tuple[Polarity, ...] = ("n", "p")
HELD_OUT = tuple(range(500, 508))  # dies on which a model is judged; none is used to build it
HELD_OUT_TEMPERATURES = 0.0, 27.0, 60.0

Quantities = Mapping[str, F64 | float]


@dataclass(frozen=True, slots=True)
class Tables:
    """A record's numbers by name, axes among them, and its held-out errors."""

    values: Mapping[str, F64]
    errors: Mapping[str, float]


_IN_FORCE: ContextVar[Mapping[str, xr.Dataset] | None] = ContextVar("records", default=None)


@contextmanager
def recorded(block: str, data: xr.Dataset) -> Iterator[None]:
    """Inside, the record of `block` is `data`, whatever is kept of it."""
    token = _IN_FORCE.set({**(_IN_FORCE.get() or {}), block: data})
    try:
        yield
    finally:
        _IN_FORCE.reset(token)


def board_key(circuits: Sequence[Circuit], process: Process, shifts: Sequence[float]) -> str:
    """Key of the record of `circuits` in `process`, measured at the threshold `shifts` (V)."""
    text = repr(([_content(c) for c in circuits], process, VERSION, TEMPERATURES, tuple(shifts)))
    return sha256(text.encode()).hexdigest()[:32]


def measure_over(
    measure: Callable[[Silicon], Quantities],
    circuits: Sequence[Circuit],
    shifts: Sequence[float],
    axes: Mapping[str, tuple[str, ...]],
) -> xr.Dataset:
    """Measure at every temperature and shared shift (V, 0 among them, rising).

    axes: names of a quantity's own axes, for those that have any.
    """
    rows = [
        [[measure(_shifted(t, polarity, s)) for s in shifts] for polarity in POLARITIES] for t in TEMPERATURES
    ]
    data = xr.Dataset(coords={"temperature": list(TEMPERATURES), "shift": list(shifts)})
    for name in rows[0][0][0]:
        values = np.array([[[q[name] for q in line] for line in plane] for plane in rows])
        data[name] = (("temperature", "polarity", "shift", *axes.get(name, ())), values)
    return data.assign_attrs(key=board_key(circuits, AMI_1500, shifts), version=VERSION)


def write_board_record(data: xr.Dataset, errors: Mapping[str, float], path: Path) -> None:
    """Write a record with its errors on dies that were not used to build it."""
    whole = data.assign_attrs({f"error_{n}": v for n, v in errors.items()})
    save_record(whole, path)


@cache
def board_record(block: str) -> xr.Dataset:
    """The record of a block, the user's own or the package's; raises `DataError` where there is none."""
    return load_record(record_file(block))


def matching_record(block: str, circuits: Sequence[Circuit], process: Process) -> xr.Dataset:
    """The record of a block, which must be of these circuits and this process; else `DataError`."""
    data = (_IN_FORCE.get() or {}).get(block)
    data = board_record(block) if data is None else data
    if data.attrs.get("key") != board_key(circuits, process, [float(s) for s in data["shift"].values]):
        raise stale(block)
    return data


def matching_tables(block: str, circuits: Callable[[], Sequence[Circuit]], process: Process) -> Tables:
    """Tables of the record of a block, as `matching_record`; those of the record that is kept are made once.

    circuits: a function of a module that builds what the model stands for, the same at every call.
    """
    if block in (_IN_FORCE.get() or {}):
        return _tables(matching_record(block, circuits(), process))
    return _shipped_tables(block, circuits, process)


@lru_cache(maxsize=32)
def _shipped_tables(block: str, circuits: Callable[[], Sequence[Circuit]], process: Process) -> Tables:
    return _tables(matching_record(block, circuits(), process))


def _tables(data: xr.Dataset) -> Tables:
    return Tables({str(n): np.asarray(v.values) for n, v in data.variables.items()}, record_errors(data))


def record_errors(data: xr.Dataset) -> dict[str, float]:
    """Held-out errors by name, with the unit at its end."""
    return {str(n).removeprefix("error_"): float(v) for n, v in data.attrs.items() if "error_" in str(n)}


def on_silicon(data: xr.Dataset | Mapping[str, F64], name: str, silicon: Silicon, axis: str = "shift") -> F64:
    """A quantity at the silicon's temperature, on its die; `axis`: that of its shared threshold shift."""
    return all_on_silicon(data, (name,), silicon, axis)[0]


def all_on_silicon(
    data: xr.Dataset | Mapping[str, F64], names: Sequence[str], silicon: Silicon, axis: str = "shift"
) -> list[F64]:
    """Several quantities, as `on_silicon`."""
    weights = temperature_weights(silicon.temperature_c)
    shift = np.asarray(data[axis], dtype=np.float64)
    moved = [float(shared(silicon.die, silicon.process, polarity).v_t0) for polarity in POLARITIES]
    unmoved = int(np.argmin(np.abs(shift)))
    found = []
    for name in names:
        table = np.asarray(data[name])
        columns = (weights @ table.reshape(weights.size, -1)).reshape(len(moved), shift.size, -1)
        parts = np.empty((len(moved), columns.shape[-1]))
        for k, x in enumerate(moved):
            monotone_cubic(shift, columns[k], x, parts[k])
        found.append((parts[0] + parts[1] - columns[0, unmoved]).reshape(table.shape[3:]))
    return found


def check_box(path: str, silicon: Silicon) -> None:
    """Refuse (`ParameterError`, with the instance path) what lies outside the records."""
    remedy = "where the behavioural model was measured; use the transistor level"
    low, high = TEMPERATURES[0], TEMPERATURES[-1]
    if not low <= silicon.temperature_c <= high:
        raise ParameterError(
            f"{path}.temperature: {silicon.temperature_c:g} degC, must be {low:g} to {high:g} degC, {remedy}"
        )
    for polarity in POLARITIES:
        shift = shared(silicon.die, silicon.process, polarity).v_t0
        if not abs(shift) <= WIDEST:
            raise ParameterError(
                f"{path}.{polarity}: shared v_t0 shift {shift:.3g} V, must be within {WIDEST:g} V, {remedy}"
            )


@lru_cache(maxsize=256)
def temperature_weights(temperature_c: float) -> F64:
    """Weights of the polynomial through all temperatures; not to be written to."""
    nodes = np.array(TEMPERATURES)
    others = [np.delete(nodes, i) for i in range(nodes.size)]
    weights = np.array([np.prod((temperature_c - o) / (a - o)) for a, o in zip(nodes, others, strict=True)])
    weights.setflags(write=False)
    return weights


def _shifted(temperature_c: float, polarity: Polarity, shift: float) -> Silicon:
    model = AMI_1500.model(polarity)
    moved = replace(model, v_t0=model.v_t0 + shift)
    process = replace(AMI_1500, n=moved) if polarity == "n" else replace(AMI_1500, p=moved)
    return Silicon(process, temperature_c)


def _content(circuit: Circuit) -> tuple[object, ...]:
    inner = tuple((i.name, _content(i.circuit), dict(i.connections)) for i in circuit.instances)
    return circuit.name, circuit.ports, circuit.devices, circuit.biases, inner
