"""Newton's method for one implicit step, `C (a v + h) + G v + i(v) = 0`, with exact derivatives.

`a v + h` is the discretised time derivative of the vector of voltages. Without it (a = 0 and h = 0) the same
is a solve for direct current.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.diode import diode_currents
from circuits.devices.operational_amplifier import amplifier_currents
from circuits.devices.transistor import TransistorWork, drain_currents
from circuits.lowering.factor import factor_and_solve
from circuits.lowering.kernel import Kernel

MAX_ITERATIONS = 12
MAX_UPDATE = 1.0  # V, largest change of a node in one iteration
SLACK = 0.05  # share of the step's tolerance that the iteration may leave


class Work(NamedTuple):
    """Working memory of one thread; nothing in it outlives a call."""

    current: F64  # all nonlinear currents, the arrays of transistors, amplifiers and diodes are views of it
    slope: F64
    transistor: TransistorWork
    amplifier_current: F64
    amplifier_slope: F64
    diode_current: F64
    diode_slope: F64
    base: F64  # Jacobian of the linear part
    jacobian: F64
    residual: F64
    rate: F64
    rest: F64  # what the search for a rest state remembers, float64[4, columns]


def allocate(kernel: Kernel) -> Work:
    """Working memory for a kernel."""
    n, m = kernel.transistors.sign.size, kernel.amplifier_terminal.shape[1]
    d = kernel.diodes.saturation.size
    current, slope = np.zeros(3 * n + 5 * m + 2 * d), np.zeros(7 * n + 25 * m + 2 * d)
    after, behind = 3 * n + 5 * m, 7 * n + 25 * m
    transistor = TransistorWork(
        argument=np.zeros(2 * n),
        value=np.zeros(2 * n),
        slope=np.zeros(2 * n),
        above=np.zeros((3, n)),
        pinch=np.zeros(n),
        kappa=np.zeros(n),
        factor=np.zeros(n),
        current=current[:n],
        conductance=slope[: 3 * n].reshape(3, n),
        leakage=np.zeros((2, n)),
        junction=current[n : 3 * n].reshape(2, n),
        junction_conductance=slope[3 * n : 7 * n].reshape(4, n),
    )
    return Work(
        current, slope, transistor, current[3 * n : after].reshape(5, m),
        slope[7 * n : behind].reshape(5, 5, m), current[after:].reshape(2, d), slope[behind:].reshape(2, d),
        np.zeros(kernel.factor.entries), np.zeros(kernel.factor.entries), np.zeros(kernel.unknowns),
        np.zeros(kernel.columns), np.zeros((4, kernel.columns)),
    )  # fmt: skip


@compiled()
def evaluate(k: Kernel, v: F64, w: Work) -> None:
    """Fill in the residual `G v + i(v)` (A, leaving each node) and the slopes of the devices."""
    drain_currents(k.transistors, v, w.transistor)
    add_others(k, v, w)


@compiled(forceinline=True)
def add_others(k: Kernel, v: F64, w: Work) -> None:
    """Do the same where currents and slopes of the transistors are there already."""
    if k.amplifier_terminal.shape[1] > 0:
        amplifier_currents(k.amplifier_terminal, k.amplifier_value, v, w.amplifier_current, w.amplifier_slope)
    if k.diodes.saturation.size > 0:
        diode_currents(k.diodes, v, w.diode_current, w.diode_slope)
    for i in range(k.unknowns):
        total = 0.0
        for p in range(k.conductance.start[i], k.conductance.start[i + 1]):
            total += k.conductance.value[p] * v[k.conductance.column[p]]
        w.residual[i] = total
    for p in range(k.stamps.row.size):
        w.residual[k.stamps.row[p]] += k.stamps.current_sign[p] * w.current[k.stamps.current[p]]


@compiled()
def store_charges(k: Kernel, v: F64, w: Work) -> None:
    """Write the charges of diodes at the voltages of their ends into v, where they are unknowns."""
    if k.charges > 0:
        diode_currents(k.diodes, v, w.diode_current, w.diode_slope)
        for i in range(k.diodes.charge.size):
            if k.diodes.charge[i] >= 0:
                v[k.diodes.charge[i]] = w.diode_current[1, i]


def with_charges(k: Kernel, voltage: F64) -> F64:
    """Vectors of voltages, float64[N, columns], V, with the charges of diodes at them; itself without any."""
    if k.charges == 0:
        return voltage
    found, work = voltage.copy(), allocate(k)
    for row in found:
        store_charges(k, row, work)
    return found


@compiled()
def set_base(k: Kernel, a: float, w: Work) -> None:
    """Fill in the part of the Jacobian that is constant within a step, `a C + G`; a: 1/s."""
    for p in range(w.base.size):
        w.base[p] = 0.0
    for p in range(k.charge.entry.size):
        if k.charge.entry[p] >= 0:
            w.base[k.charge.entry[p]] += a * k.charge.value[p]
    for p in range(k.conductance.entry.size):
        if k.conductance.entry[p] >= 0:
            w.base[k.conductance.entry[p]] += k.conductance.value[p]


@compiled()
def fill_jacobian(k: Kernel, w: Work) -> None:
    """Fill in the Jacobian: its constant part and the slopes of the devices."""
    for p in range(w.base.size):
        w.jacobian[p] = w.base[p]
    for p in range(k.stamps.entry.size):
        w.jacobian[k.stamps.entry[p]] += k.stamps.slope_sign[p] * w.slope[k.stamps.slope[p]]


@compiled()
def newton(k: Kernel, a: float, history: F64, v: F64, rtol: float, w: Work) -> int:
    """Solve one step in place; `v` holds the guess and the source values.

    history: float64[columns], V/s. Returns the number of iterations, or -1 where it does not converge.
    Converged: the estimated remaining error of every node is below 0.05 rtol max(|v|, 1 V). The estimate is
    the last update, or its square over the law's curvature (quadratic convergence).
    """
    n = k.unknowns
    set_base(k, a, w)
    for iteration in range(1, MAX_ITERATIONS + 1):
        for i in range(k.columns):
            w.rate[i] = a * v[i] + history[i]
        evaluate(k, v, w)
        for i in range(n):
            total = 0.0
            for p in range(k.charge.start[i], k.charge.start[i + 1]):
                total += k.charge.value[p] * w.rate[k.charge.column[p]]
            w.residual[i] += total
        fill_jacobian(k, w)
        factor_and_solve(k.factor, w.jacobian, w.residual)
        largest, clamped = 0.0, False
        for i in range(n):
            update = w.residual[i]
            if not abs(update) < MAX_UPDATE:
                if not np.isfinite(update):
                    return -1
                update = MAX_UPDATE if update > 0.0 else -MAX_UPDATE
                clamped = True
            v[i] -= update
            scaled = abs(update) / max(abs(v[i]), 1.0)
            largest = max(largest, scaled)
        target = SLACK * rtol
        if not clamped and (largest < target or largest * largest < target * k.curvature):
            return iteration
    return -1
