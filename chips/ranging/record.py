"""The record of the rebound neuron as its model uses it: smooth quantities with gradients, and the box.

A quantity NAME has the tables `NAME`, `NAME_gradient` and `NAME_curvature` over I_inh_tau, where it depends
on it, and temperature, and the axis `NAME_parameter` of the deviations that move it. The record's key is of
the circuit (bias values aside, over which it is measured), the process, the version of the measurement and
the grid.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from chips.record import WITHOUT_BIASES, Record, Table, content, current_record, record_key
from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.lowering.capacitance import node_capacitances
from circuits.lowering.capacitors_on_die import capacitor_of
from circuits.silicon.process import AMI_1500_IDEAL, Process

NAME = "rebound_neuron"
VERSION = 1  # of the characteriser: what it measures and how
CURRENT, TEMPERATURE = "i_inh_tau", "temperature"  # axes
_ANY_CURRENT = "any_i_inh_tau"  # in the place of the current's axis: one value for all
_GRADIENT, _CURVATURE, _PARAMETER = "_gradient", "_curvature", "_parameter"
_MARGIN = "margin_rms_V"  # the error that the margin follows from
CAPACITORS = {
    "membrane.c_m": "", "membrane.c_r": "", "excitation.c_ex": "excitation.v_ex",
    "inhibition.c_inh": "inhibition.v_inh", "axon.c_ax": "v_ax", "axon.c_fb": "v_ax",
}  # fmt: skip
"""Capacitors of a neuron, and the nodes of those by which quantities of the record go."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Where a record is measured: currents I_inh_tau, A at the temperature, and temperatures, degC."""

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
    """A smooth quantity `q0 + sum_d (g_d x_d + h_d x_d^2 / 2)` over the deviations x_d of devices.

    parameters: names of the deviations; value: float64[currents or 1, temperatures]; gradient, curvature:
    with the deviations as the last dimension.
    """

    parameters: tuple[str, ...]
    value: F64
    gradient: F64
    curvature: F64


@dataclass(frozen=True, slots=True)
class ReboundRecord:
    """A record as the model uses it.

    errors: on dies that were not used to build it, by name with the unit at its end.
    """

    key: str
    grid: Grid
    box: Box
    quantities: Mapping[str, Quantity]
    errors: Mapping[str, float]

    @property
    def margin(self) -> float:
        """Voltage about the threshold within which the model does not decide, V: twice the rms error."""
        return 2.0 * self.errors.get(_MARGIN, 0.0)


def rebound_key(circuit: Circuit, process: Process, grid: Grid) -> str:
    """Return the key of the record of `circuit` in `process`."""
    return record_key(content(circuit, WITHOUT_BIASES), process, VERSION, grid)


def to_record(rebound: ReboundRecord) -> Record:
    """Return the record that `rebound_record` reads."""
    tables: dict[str, Table] = {}
    axes: dict[str, tuple[float, ...] | tuple[str, ...]] = {
        CURRENT: rebound.grid.current,
        TEMPERATURE: rebound.grid.temperature,
    }
    for name, q in rebound.quantities.items():
        plane = (CURRENT if q.value.shape[0] > 1 else _ANY_CURRENT, TEMPERATURE)
        tables[name] = Table(plane, q.value)
        tables[name + _GRADIENT] = Table((*plane, name + _PARAMETER), q.gradient)
        tables[name + _CURVATURE] = Table((*plane, name + _PARAMETER), q.curvature)
        axes[name + _PARAMETER] = q.parameters
    b = rebound.box
    box = {
        "threshold_V": (-b.threshold, b.threshold),
        "log_beta": (-b.log_beta, b.log_beta),
        "v_th_V": (-b.v_th, b.v_th),
        "below_supply_V": (0.0, b.v_ex_max),
    }
    return Record(rebound.key, VERSION, axes, tables, rebound.errors, box)


def rebound_record(record: Record) -> ReboundRecord:
    """Return a record as the model uses it; raises `DataError` where it is not of a rebound neuron."""
    sides = ("threshold_V", "log_beta", "v_th_V", "below_supply_V")
    names = [n for n in record.tables if not n.endswith((_GRADIENT, _CURVATURE))]
    return ReboundRecord(
        record.key,
        Grid(record.numbers(CURRENT), record.numbers(TEMPERATURE)),
        Box(*(record.limits(side)[1] for side in sides)),
        {n: _quantity(record, n) for n in names},
        record.errors,
    )


def _quantity(record: Record, name: str) -> Quantity:
    tables = (record[name + suffix] for suffix in ("", _GRADIENT, _CURVATURE))
    return Quantity(record.names(name + _PARAMETER), *tables)


def record_of(process: Process = AMI_1500_IDEAL) -> ReboundRecord:
    """Return the record in force for a process as the model uses it; raises `DataError` without one."""
    return rebound_record(current_record(NAME, process))


def capacitor_shares(neuron: Circuit, process: Process) -> dict[str, float]:
    """Return the share of each of `CAPACITORS` in the capacitance of its node, where it has one there."""
    total = node_capacitances(neuron, process)
    return {
        name: capacitor_of(neuron, name).capacitance / total[node]
        for name, node in CAPACITORS.items()
        if node
    }


def with_capacitors(
    shares: Mapping[str, float], changes: Mapping[str, F64], smooth: Mapping[str, F64]
) -> Mapping[str, F64]:
    """Return the smooth quantities of n neurons, float64[n], on a die whose capacitors deviate.

    A charge goes as the capacitance of its node, of which a capacitor has its share, and a step by coupling
    as its inverse. A spike lasts while I_pw takes away C_fb V_dd, by which v_ax has risen as it began.
    shares: of capacitors in their nodes; changes: of capacitors, relative, float64[n], none where they do not
    deviate; smooth: with capacitors as drawn.
    """
    if not changes:
        return smooth
    moved = {name: changes[name] * share for name, share in shares.items()}
    axon = np.log1p(moved["axon.c_ax"] + moved["axon.c_fb"])
    return dict(smooth) | {
        "log_charge": smooth["log_charge"] + np.log1p(moved["inhibition.c_inh"]),
        "log_axon_charge": smooth["log_axon_charge"] + axon,
        "log_pulse_width": smooth["log_pulse_width"] + np.log1p(changes["axon.c_fb"]),
        "echo_step": smooth["echo_step"] / (1.0 + moved["excitation.c_ex"]),
    }
