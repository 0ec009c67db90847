"""Currents and power of sources and transistors, after a run that recorded every node; currents of a sweep.

The current of a source of voltage is the conduction current of the devices at its node, less what sources of
current give into it, and the rate of the charge on its side of every capacitance. Conduction is integrated
over the points of the run by the trapezoidal rule, and charge exactly.
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices import Transistor
from circuits.errors import ParameterError, unknown_name
from circuits.lowering.kernel import Kernel, Machine, Triplets
from circuits.solver.newton import Work, allocate, evaluate, with_charges
from circuits.solver.sweep import Sweep
from circuits.solver.transient import Result


def delivered_energy(result: Result) -> dict[str, float]:
    """Energy that each voltage source delivered over a run, J, by the source's name.

    Raises `ParameterError` for a run that did not record every node.
    """
    return {name: float(course[-1]) + 0.0 for name, course in energy_courses(result).items()}


def energy_courses(result: Result, currents: F64 | None = None) -> dict[str, F64]:
    """Energy that each voltage source has delivered until each point of a run, J, float64[T], by its name.

    currents: what devices take from every column's node, where that is known (`conduction_and_channels`).

    Raises `ParameterError` for a run that did not record every node.
    """
    machine = result.machine
    require_every_node(result, "energy")
    v = node_voltages(result)
    if currents is None:
        currents = conduction_and_channels(machine, v)[1]
    step, courses = np.diff(result.time), {}
    for s, name in enumerate(machine.source_names):
        if machine.source_quantities[s] == "voltage":
            own = machine.kernel.unknowns + s
            current = currents[:, own]
            charge = linear(machine.source_charge, own, v, np.zeros(step.size + 1))
            middle = 0.5 * (v[1:, own] + v[:-1, own])
            energies = middle * (0.5 * (current[1:] + current[:-1]) * step + np.diff(charge))
            courses[name] = np.concatenate([[0.0], energies.cumsum()])  # in the order of time
    return courses


def node_voltages(result: Result | Sweep) -> F64:
    """The solver's vector of voltages at each point, float64[T, columns], V.

    At sources of current it has what they give over a run, A, and over a sweep 0.
    """
    machine = result.machine
    v = np.zeros((len(result.voltage), machine.kernel.columns))
    v[:, machine.column] = result.voltage
    if isinstance(result, Result):
        for s, quantity in enumerate(machine.source_quantities):
            if quantity == "current":
                v[:, machine.kernel.unknowns + s] = np.interp(result.time, *machine.polylines[s])
    return with_charges(machine.kernel, v)


def conduction_and_channels(machine: Machine, v: F64) -> tuple[F64, F64]:
    """Channel current of every transistor, and what devices without charge take from every column's node.

    v: the vector of voltages at each point, float64[T, columns], V. Returns float64[T, transistors] and
    float64[T, columns], A. The columns of the sources have all of it, the others that of transistors, diodes
    and amplifiers.
    """
    k = machine.kernel
    channels, out = np.empty((len(v), k.transistors.sign.size)), np.zeros_like(v)
    _conduction(k, v, allocate(k), channels, out)
    for s in range(len(machine.source_names)):
        own = k.unknowns + s
        out[:, own] = linear(machine.source_conductance, own, v, out[:, own])
    return channels, out


def linear(entries: Triplets, row: int, v: F64, base: F64) -> F64:
    """`base`, float64[T], and the product of a row of a sparse matrix with the voltages v."""
    found = base.copy()
    for column, value in zip(*(each[entries[0] == row] for each in entries[1:]), strict=True):
        found += value * v[:, column]
    return found


def supply_power(result: Result) -> float:
    """Mean power that all voltage sources together deliver over the run of `result`, W."""
    return sum(delivered_energy(result).values()) / float(result.time[-1] - result.time[0])


def drain_current(result: Result | Sweep, path: str) -> F64:
    """Current from drain to source of a transistor over a run or a direct-current sweep, A, float64[T].

    Parameters
    ----------
    result
        The run, or the sweep: a current for each point in time, or for each value.
    path
        Path of the transistor, such as `excitatory.md5`.

    Raises
    ------
    UnknownNameError
        There is no transistor at the path.
    ParameterError
        The run did not record every node.
    """
    machine = result.machine
    require_every_node(result, "drain current")
    labels = machine.flat.labels(Transistor)
    if path not in labels:
        raise unknown_name(f"{machine.flat.circuit.name} transistor", path, labels)
    return conduction_and_channels(machine, node_voltages(result))[0][:, labels.index(path)]


def require_every_node(result: Result | Sweep, wanted: str) -> None:
    """Raise `ParameterError`, which says what is wanted, for a run that did not record every node."""
    if len(result.nodes) != len(result.machine.names):
        raise ParameterError(f"{wanted}: the run must record every node; leave record out")


@compiled()
def _conduction(k: Kernel, v: F64, w: Work, channels: F64, out: F64) -> None:
    """Currents of the channels, A, [T, transistors], and of nonlinear devices leaving nodes, [T, columns]."""
    t = k.transistors.terminal
    for p in range(v.shape[0]):
        evaluate(k, v[p], w)
        for i in range(t.shape[1]):
            channels[p, i] = w.transistor.current[i]
            out[p, t[0, i]] += w.transistor.current[i]
            out[p, t[2, i]] -= w.transistor.current[i]
            for side in range(2):
                out[p, t[2 * side, i]] += w.transistor.junction[side, i]
                out[p, t[3, i]] -= w.transistor.junction[side, i]
        for j in range(k.amplifier_terminal.shape[1]):
            for i in range(5):
                out[p, k.amplifier_terminal[i, j]] += w.amplifier_current[i, j]
        for j in range(k.diodes.saturation.size):
            out[p, k.diodes.terminal[0, j]] += w.diode_current[0, j]
            out[p, k.diodes.terminal[1, j]] -= w.diode_current[0, j]
