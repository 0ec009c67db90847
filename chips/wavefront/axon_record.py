"""The record of the axonal delay element: the charge behind its delays, with gradients over its devices.

The delay at a code is a charge over the current of the sink on this die, `D = Q / I`. The current is the
law's own, so that its spread and drift, over decades, are exact; what is recorded is smooth and small:

    log_charge     ln Q(code; T, I, I_cmp)             codes 1 to 31: unit, offset and non-linearity
    gain, offset   dQ/dx = Q_u (offset + gain code)    of each device's x: V_T0 (V) or ln beta; 1/V or 1

Q_u is the charge a unit, (Q(31) - Q(1)) / 30; I_cmp the comparator's current. Between grid points: a
polynomial through all temperatures, cubic splines over the logarithms of the currents.

The record's key is of the circuit (biases aside), of the process (matching and spread of dies aside, which
only scale what is drawn), of the version and of the grid.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from chips.record import Record, current_record, record_key
from circuits.circuit import Circuit
from circuits.silicon.process import AMI_1500_IDEAL, Process, Variation

NAME = "axon_delay"
VERSION = 1  # of the measurement: what it measures and how
SHARED = ("n", "p")  # what all devices of a polarity share, but those whose current is a coordinate
TEMPERATURE, CURRENT, COMPARATOR_CURRENT = "temperature", "current", "comparator_current"  # axes
PARAMETER = "parameter"  # axis of the deviations, by names as in `mc1.v_t0`
LOCAL_SHIFT, SHARED_SHIFT = "local_threshold_V", "shared_threshold_V"  # sides of the box
BOX = {
    LOCAL_SHIFT: (-0.04, 0.04),  # ours: six sigma of the comparator's devices
    SHARED_SHIFT: (-0.12, 0.12),  # ours: 3.6 sigma
}


@dataclass(frozen=True, slots=True)
class AxonGrid:
    """Where a record is measured: temperatures, degC, and currents of sink and comparator's tail, A."""

    temperature: tuple[float, ...] = (-10.0, 8.0, 27.0, 46.0, 65.0)
    current: tuple[float, ...] = tuple(float(i) for i in np.geomspace(30e-12, 300e-9, 15))
    comparator_current: tuple[float, ...] = tuple(float(i) for i in np.geomspace(3e-9, 3e-6, 12))


GRID = AxonGrid()


def axon_key(circuit: Circuit, process: Process, grid: AxonGrid = GRID) -> str:
    """Return the key of the record of `circuit` in `process`."""
    plain = replace(process, pair_a_vt=0.0, pair_a_beta=0.0, variation=Variation())
    return record_key(circuit.name, circuit.ports, circuit.devices, plain, VERSION, grid)


def grid_of(record: Record) -> AxonGrid:
    """Return where a record was measured; raises `DataError` where it is not of an axonal delay element."""
    return AxonGrid(*(record.numbers(axis) for axis in (TEMPERATURE, CURRENT, COMPARATOR_CURRENT)))


def axon_record(process: Process = AMI_1500_IDEAL) -> Record:
    """Return the record in force for a process; raises `DataError` where there is none."""
    return current_record(NAME, process)
