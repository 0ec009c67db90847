"""Records of characterised blocks: smooth quantities over bias and temperature, with gradients and errors.

A record is a netCDF file (`chips.record_file`). Its key is a hash of the circuit (bias values aside, over
which it is measured), the process, the characteriser's version and the grid: when one of them changes, the
record is stale and must be measured again, by `noctule characterise`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path

import numpy as np
import xarray as xr

from chips.record_file import load_record, record_file, save_record
from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.errors import DataError
from circuits.silicon.process import Process

VERSION = 1  # of the characteriser: what it measures and how


@dataclass(frozen=True, slots=True)
class Grid:
    """Where a record is measured: I_inh_tau in A at the temperature, temperatures in degC."""

    current: tuple[float, ...] = tuple(float(i) for i in np.geomspace(1e-12, 30e-9, 10))
    temperature: tuple[float, ...] = (-10.0, 8.0, 27.0, 46.0, 65.0)


GRID = Grid()


@dataclass(frozen=True, slots=True)
class Box:
    """Where the model is valid, beside the grid: largest |shift| of a device's threshold and of v_th (V), and
    of a ln beta; lowest v_ex_max below the supply (V).
    """  # noqa: D205 - a list of limits

    threshold: float
    log_beta: float
    v_th: float
    v_ex_max: float


@dataclass(frozen=True, slots=True)
class Quantity:
    """A smooth quantity `q0 + sum_d (g_d x_d + h_d x_d^2 / 2)`.

    value: float64[currents or 1, temperatures]; gradient, curvature: float64[..., parameters].
    """

    parameters: tuple[str, ...]
    value: F64
    gradient: F64
    curvature: F64


@dataclass(frozen=True, slots=True)
class Record:
    """What was measured. margin: V about the threshold within which the model does not decide.

    errors: on dies that were not used to build it, by name with the unit at its end.
    """

    key: str
    grid: Grid
    box: Box
    quantities: Mapping[str, Quantity]
    margin: float
    errors: Mapping[str, float]


def record_key(circuit: Circuit, process: Process, grid: Grid) -> str:
    """Key of the record of `circuit` in `process`."""
    text = repr((_without_biases(circuit), process, VERSION, grid))
    return sha256(text.encode()).hexdigest()[:32]


def _without_biases(circuit: Circuit) -> tuple[object, ...]:
    inner = tuple((i.name, _without_biases(i.circuit), dict(i.connections)) for i in circuit.instances)
    return circuit.name, circuit.ports, circuit.devices, inner


def write_record(record: Record, path: Path) -> None:
    """Write a record as netCDF."""
    data = xr.Dataset(
        coords={
            "i_inh_tau": ("i_inh_tau", np.array(record.grid.current), {"unit": "A"}),
            "temperature": ("temperature", np.array(record.grid.temperature), {"unit": "degC"}),
        },
        attrs={
            "key": record.key,
            "version": VERSION,
            "margin_V": record.margin,
            "box_threshold_V": record.box.threshold,
            "box_log_beta": record.box.log_beta,
            "box_v_th_V": record.box.v_th,
            "box_v_ex_max_V": record.box.v_ex_max,
            **{f"error_{name}": value for name, value in record.errors.items()},
        },
    )
    for name, q in record.quantities.items():
        plane = ("i_inh_tau" if q.value.shape[0] > 1 else "any_i_inh_tau", "temperature")
        data[name] = (plane, q.value)
        data[f"{name}_gradient"] = ((*plane, f"{name}_parameter"), q.gradient.astype(np.float32))
        data[f"{name}_curvature"] = ((*plane, f"{name}_parameter"), q.curvature.astype(np.float32))
        data = data.assign_coords({f"{name}_parameter": list(q.parameters)})
    save_record(data, path)


def read_record(path: Path) -> Record:
    """Read a record; raises `DataError` for a file that is none."""
    data = load_record(path)
    a = data.attrs
    if "key" not in a or int(a.get("version", 0)) != VERSION:
        raise DataError(f"{path.name}: no record of version {VERSION}; write it with noctule characterise")
    names = [str(n) for n in data.data_vars if not str(n).endswith(("_gradient", "_curvature"))]
    return Record(
        key=str(a["key"]),
        grid=Grid(_floats(data["i_inh_tau"]), _floats(data["temperature"])),
        box=Box(*(float(a[f"box_{n}"]) for n in ("threshold_V", "log_beta", "v_th_V", "v_ex_max_V"))),
        quantities={n: _quantity(data, n, path) for n in names},
        margin=float(a["margin_V"]),
        errors={str(k).removeprefix("error_"): float(v) for k, v in a.items() if str(k).startswith("error_")},
    )


def _floats(values: xr.DataArray) -> tuple[float, ...]:
    return tuple(float(v) for v in values.values)


def _quantity(data: xr.Dataset, name: str, path: Path) -> Quantity:
    try:
        with np.errstate(invalid="raise"):
            tables = [np.asarray(data[name + s].values, np.float64) for s in ("", "_gradient", "_curvature")]
    except FloatingPointError:
        raise DataError(f"{path.name}: {name} is broken; write it with noctule characterise") from None
    return Quantity(tuple(str(p) for p in data[f"{name}_parameter"].values), *tables)


@cache
def record_of(block: str = "rebound_neuron") -> Record:
    """The record of a block, the user's own or the package's; raises `DataError` where there is none."""
    return read_record(record_file(block))
