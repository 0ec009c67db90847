"""Currents of a circuit's transistors at many vectors of voltages, those of one machine, side by side.

A run's points are known once it is over. What its transistors do there needs no order, so that as many rows
of voltages as there are lanes are gone through at once. Equations are those of `circuits.solver.lanes.law`,
where runs stand side by side; here one machine has one set of coefficients.
"""

from __future__ import annotations

from typing import NamedTuple

from circuits.arrays import F64, I64
from circuits.compiled import compiled
from circuits.devices.channel_lanes import Effects, bent, channel_affected, channel_plain
from circuits.devices.softplus import power_of_lanes, softplus_of_two
from circuits.devices.transistor import INDUCED_LIMIT, TransistorArrays
from circuits.lowering.kernel import Kernel
from circuits.solver.lanes.law import flow
from circuits.solver.newton import Work, add_others
from circuits.vectors import vector
from circuits.vectors.vector import WIDTH, rows

every, load, magnitude = vector.every, vector.load, vector.magnitude
select, smaller, store = vector.select, vector.smaller, vector.store


class Sheet(NamedTuple):
    """WIDTH rows of voltages, and what transistors do there; each array has a number a lane.

    v : float64[columns, WIDTH], V.
    current : float64[3 transistors, WIDTH], A, channels, then junctions of drains and of sources.
    slope : float64[7 transistors, WIDTH], S, as of `circuits.solver.newton`.
    early : float64[transistors, WIDTH], what a current moves by, relative, as ln of the Early field falls.
    """

    v: F64
    current: F64
    slope: F64
    early: F64


def new_sheet(k: Kernel) -> Sheet:
    """Room for rows of a kernel's voltages."""
    n = k.transistors.sign.size
    return Sheet(rows(k.columns), rows(3 * n), rows(7 * n), rows(n))


@compiled()
def fill(k: Kernel, which: I64, voltage: F64, first: int, x: Sheet) -> None:
    """Fill in what some transistors do at the rows from `first` on.

    which: int64, numbers of the transistors. voltage: float64[rows, columns], V; lanes behind its end have
    its last row.
    """
    t, last = k.transistors, voltage.shape[0] - 1
    for lane in range(WIDTH):
        row = min(first + lane, last)
        for c in range(k.columns):
            x.v[c, lane] = voltage[row, c]
    for p in range(which.size):
        _channel(t, which[p], x)
    if t.leaks:
        for side in range(2):
            for p in range(which.size):
                i = which[p]
                if t.terminal[2 * side, i] != t.terminal[3, i]:  # else there is no voltage across it
                    _junction(t, i, side, x)


@compiled()
def take(k: Kernel, x: Sheet, lane: int, v: F64, w: Work) -> None:
    """Do what `circuits.solver.newton.evaluate` does, but leave the currents of transistors out.

    lane: where the slopes of all transistors at voltages v are.
    """
    for p in range(x.slope.shape[0]):
        w.slope[p] = x.slope[p, lane]
    if has_others(k):
        add_others(k, v, w)


@compiled(forceinline=True)
def has_others(k: Kernel) -> bool:
    """Whether direct current flows through anything but transistors."""
    others = k.amplifier_terminal.shape[1] + k.diodes.saturation.size + k.conductance.column.size
    return bool(others > 0)


@compiled(forceinline=True)
def _channel(t: TransistorArrays, i: int, x: Sheet) -> None:
    n, s = t.sign.size, t.sign[i]
    v_b = load(x.v, t.terminal[3, i])
    v_d, v_s = s * (load(x.v, t.terminal[0, i]) - v_b), s * (load(x.v, t.terminal[2, i]) - v_b)
    above, gamma, phi = s * (load(x.v, t.terminal[1, i]) - v_b), t.gamma[i], t.surface_potential[i]
    kappa = every(t.kappa[i])
    v_p = kappa * (above - t.v_t0[i])
    if t.body_effect:
        v_x = above + (phi + gamma * phi**0.5 - t.v_t0[i])
        v_p, kappa = bent(v_p, kappa, v_x, every(gamma), every(phi))
    half, specific = every(t.inverse_2ut[i]), every(t.specific_current[i])
    spread = 0.5 / (t.inverse_2ut[i] * t.inverse_2ut[i])
    if t.reduces or t.early[i] != 0.0:
        effects = Effects(every(t.early[i]), every(t.early_rise[i]), every(t.reduction[i]), every(spread))
        found = channel_affected(specific, half, effects, v_d, v_p, v_s)
        forward, reverse, _, _ = softplus_of_two((v_p - v_s) * half, (v_p - v_d) * half)
        rest = t.early[i] * magnitude(v_d - v_s) / (1.0 + t.early_rise[i] * (forward + reverse))
        store(x.early, i, rest / (1.0 + rest))
    else:
        found = channel_plain(specific, half, v_d, v_p, v_s)
        store(x.early, i, every(0.0))
    current, by_drain, by_pinch, by_source = found
    store(x.current, i, s * current)
    store(x.slope, i, by_drain)
    store(x.slope, n + i, kappa * by_pinch)
    store(x.slope, 2 * n + i, by_source)


@compiled(forceinline=True)
def _junction(t: TransistorArrays, i: int, side: int, x: Sheet) -> None:
    """Current of the junction at drain, 0, or source, 1, of transistor i, and its slopes."""
    n, s, per_volt = t.sign.size, t.sign[i], 2.0 * t.inverse_2ut[i]
    v_j, v_b = load(x.v, t.terminal[2 * side, i]), load(x.v, t.terminal[3, i])
    taken, e = flow(per_volt * (s * (v_j - v_b)))
    total, by_gate = every(t.leakage[i]), every(0.0)
    if t.induces:
        slope = t.induced_per_volt[i]
        y = slope * (s * (v_j - load(x.v, t.terminal[1, i])) - t.induced_from[i])
        induced = t.induced[i] * power_of_lanes(smaller(y, every(INDUCED_LIMIT)))
        total = total + induced
        by_gate = select(y < INDUCED_LIMIT, induced * slope * taken, every(0.0))
    store(x.current, (1 + side) * n + i, s * total * taken)
    store(x.slope, (3 + side) * n + i, total * per_volt * e + by_gate)
    store(x.slope, (5 + side) * n + i, 0.0 - by_gate)
