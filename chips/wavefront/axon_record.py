"""Record of the axonal delay element: the charge behind its delays, with gradients over its devices.

The delay at a code is a charge over the current of the sink on this die, `D = Q / I`. The current is the
law's own, so that its spread and drift, over decades, are exact; what is recorded is smooth and small:

    ln Q(code; T, I, I_cmp)                      codes 1 to 31: unit, offset and non-linearity
    dQ/dx = Q_u (offset + gain code)             of each device's x: V_T0 (V) or ln beta; 1/V or 1

Q_u is the charge a unit, (Q(31) - Q(1)) / 30; I_cmp the comparator's current. Between grid points: a
polynomial through all temperatures, cubic splines over the logarithms of the currents.

The record is `axon_delay.nc` (`chips.record_file`). Its key is a hash of the circuit (biases aside), of the
process (matching and spread of dies aside, which only scale what is drawn), of the version and of the grid.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from pathlib import Path

import numpy as np
import xarray as xr

from chips.record_file import load_record, record_file, save_record
from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.errors import DataError
from circuits.silicon.process import Process, Variation

VERSION = 1  # of the measurement: what it measures and how
SHARED = ("n", "p")  # what all devices of a polarity share, but those whose current is a coordinate


@dataclass(frozen=True, slots=True)
class AxonGrid:
    """Temperatures in degC; currents of the sink and of the comparator's tail in A at the temperature."""

    temperature: tuple[float, ...] = (-10.0, 8.0, 27.0, 46.0, 65.0)
    current: tuple[float, ...] = tuple(float(i) for i in np.geomspace(30e-12, 300e-9, 15))
    comparator_current: tuple[float, ...] = tuple(float(i) for i in np.geomspace(3e-9, 3e-6, 12))


GRID = AxonGrid()


@dataclass(frozen=True, slots=True)
class AxonBox:
    """Where the model is valid beside the grid: largest |local| and |shared| shift of a threshold, V."""

    local: float = 0.04  # ours: six sigma of the comparator's devices
    shared: float = 0.12  # ours: 3.6 sigma


BOX = AxonBox()


@dataclass(frozen=True, slots=True)
class AxonRecord:
    """What was measured.

    log_charge: float64[temperatures, currents, comparator currents, 31], ln C; parameters: names as in
    `mc1.v_t0`; gain, offset: float64[temperatures, currents, parameters]; errors: on dies that were not used,
    by name with the unit at its end.
    """

    key: str
    grid: AxonGrid
    log_charge: F64
    parameters: tuple[str, ...]
    gain: F64
    offset: F64
    errors: Mapping[str, float]


def axon_key(circuit: Circuit, process: Process, grid: AxonGrid = GRID) -> str:
    """Key of the record of `circuit` in `process`."""
    plain = replace(process, pair_a_vt=0.0, pair_a_beta=0.0, variation=Variation())
    text = repr((circuit.name, circuit.ports, circuit.devices, plain, VERSION, grid))
    return sha256(text.encode()).hexdigest()[:32]


def write_axon_record(record: AxonRecord, path: Path) -> None:
    """Write a record as netCDF."""
    grid = record.grid
    plane = ("temperature", "current")
    data = xr.Dataset(
        {
            "log_charge": ((*plane, "comparator_current", "code"), record.log_charge),
            "gain": ((*plane, "parameter"), record.gain),
            "offset": ((*plane, "parameter"), record.offset),
        },
        {
            "temperature": ("temperature", np.array(grid.temperature), {"unit": "degC"}),
            "current": ("current", np.array(grid.current), {"unit": "A"}),
            "comparator_current": ("comparator_current", np.array(grid.comparator_current), {"unit": "A"}),
            "code": np.arange(1, record.log_charge.shape[-1] + 1),
            "parameter": list(record.parameters),
        },
        {"key": record.key, "version": VERSION} | {f"error_{n}": v for n, v in record.errors.items()},
    )
    save_record(data, path)


def read_axon_record(path: Path) -> AxonRecord:
    """Read a record; raises `DataError` for a file that is none."""
    data = load_record(path)
    a = data.attrs
    if "key" not in a or int(a.get("version", 0)) != VERSION or "log_charge" not in data:
        raise DataError(
            f"{path.name}: no axon record of version {VERSION}; write it with noctule characterise"
        )
    axes = (tuple(map(float, data[n].values)) for n in ("temperature", "current", "comparator_current"))
    return AxonRecord(
        str(a["key"]),
        AxonGrid(*axes),
        np.asarray(data["log_charge"].values, dtype=np.float64),
        tuple(str(p) for p in data["parameter"].values),
        np.asarray(data["gain"].values, dtype=np.float64),
        np.asarray(data["offset"].values, dtype=np.float64),
        {str(k).removeprefix("error_"): float(v) for k, v in a.items() if str(k).startswith("error_")},
    )


def lagrange_weights(nodes: Sequence[float], x: float) -> F64:
    """Weights at x of the polynomial through all nodes, float64[nodes]."""
    a = np.array(nodes)
    return np.array([np.prod((x - np.delete(a, i)) / (a[i] - np.delete(a, i))) for i in range(a.size)])


@cache
def axon_record() -> AxonRecord:
    """The record, the user's own or the package's; raises `DataError` where there is none."""
    return read_axon_record(record_file("axon_delay"))
