"""What the figures of diodes move measures by, from the adjoint run (`circuits.gradient.backwards`).

A diode's current i and charge q follow its own figures and voltages alone. So one central difference of a
figure of all diodes at once gives, for each of them,

    dM/d ln p = - sum over the steps of (m_a - m_c) di/d ln p + sum of m_q dq/d ln p

with m the adjoint run at anode, cathode and the unknown that is the charge.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.diode import DiodeArrays, diode_arrays, diode_currents
from circuits.gradient.backwards import Adjoint, apart
from circuits.gradient.flow import flow_of
from circuits.gradient.sums import ends_of
from circuits.lowering.kernel import Machine

FIGURES = {
    "saturation_current": "A", "emission": "", "area": "", "junction_capacitance": "F",
    "junction_potential": "V", "grading": "", "transit_time": "s", "breakdown_voltage": "V",
}  # fmt: skip
"""Figures of a diode that have a gradient, with their SI units."""
_STEP = 1e-5  # relative, of a figure; ours


def by_figures(machine: Machine, found: Adjoint, figures: Mapping[str, F64]) -> dict[str, F64]:
    """Return what ln of each figure moves measures by, float64[measures, diodes], by the figure's name.

    Parameters
    ----------
    machine
        The machine.
    found
        The adjoint run.
    figures
        All figures of its diodes on their die, float64[diodes] each.
    """
    k, temperature = machine.kernel.diodes, machine.silicon.temperature_c
    moved, by, read = found.moved, {}, _read(machine, found)
    for name in FIGURES:
        more, less = (
            diode_arrays(k.terminal, k.charge, {**figures, name: figures[name] * share}, temperature)
            for share in (1.0 + _STEP, 1.0 - _STEP)
        )
        sums = np.zeros((moved.shape[0], k.saturation.size))
        _differ(more, less, found.voltage, (moved, read), np.empty((3, 2, k.saturation.size)), sums)
        by[name] = sums / (2.0 * _STEP)
    return by


def _read(machine: Machine, found: Adjoint) -> F64:
    """Slopes of the measures by what diodes conduct, float64[measures, rows, diodes]."""
    ends = ends_of(machine)
    read = np.zeros((*found.moved.shape[:2], machine.kernel.diodes.saturation.size))
    for m, tap in found.taps:
        read[m] += tap.conducted[:, None] * flow_of(machine, tap.name, ends).diode
    return read


@compiled()
def _differ(
    more: DiodeArrays, less: DiodeArrays, voltage: F64, across: tuple[F64, F64], x: F64, out: F64
) -> None:
    """Sum over the rows what `more` has beyond `less`.

    across: m, and slopes by what diodes conduct. x: float64[3, 2, diodes], scratch.
    """
    moved, read = across
    for row in range(voltage.shape[0]):
        diode_currents(more, voltage[row], x[0], x[2])
        diode_currents(less, voltage[row], x[1], x[2])
        for m in range(moved.shape[0]):
            own = moved[m, row]
            for k in range(out.shape[1]):
                through = apart(own, more.terminal[0, k], more.terminal[1, k]) - read[m, row, k]
                out[m, k] -= through * (x[0, 0, k] - x[1, 0, k])
                if more.charge[k] >= 0:
                    out[m, k] += own[more.charge[k]] * (x[0, 1, k] - x[1, 1, k])
