"""Currents as sums over the devices that carry them.

A current of a name (`circuits.measure.current`) is

    i = sum of e_d i_d(v) + g . v + d(c . v)/dt

with weights e of channels, junctions, amplifiers and diodes, g (S) of the linear devices and c (F) of what
stores charge: one device for its own current, all that end at its node for a source's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices import Capacitor, ControlledSource, Diode, Resistor, Transistor
from circuits.devices.device import Device
from circuits.errors import unknown_name
from circuits.gradient.backwards import Sums, add_channel, add_junction
from circuits.gradient.ends import Ends
from circuits.lowering.kernel import Kernel, Machine
from circuits.lowering.made import made
from circuits.measure.current import current_names
from circuits.solver.newton import Work, evaluate


class Flow(NamedTuple):
    """A current as weights of what carries it.

    channel : float64[transistors]. junction : float64[2, transistors], at drain and source.
    amplifier : float64[5, amplifiers]. diode : float64[diodes].
    linear : float64[columns], S. charge : float64[columns], F.
    resistors, pairs : float64 of each pair of `circuits.gradient.ends`.
    """

    channel: F64
    junction: F64
    amplifier: F64
    diode: F64
    linear: F64
    charge: F64
    resistors: F64
    pairs: F64


def flow_of(machine: Machine, name: str, ends: Ends) -> Flow:
    """Return the weights of a current.

    Parameters
    ----------
    machine
        The machine.
    name
        Path of a device, or name of a source.
    ends
        Columns of pairs (`circuits.gradient.ends`).

    Raises
    ------
    UnknownNameError
        Nothing of that name has a current.
    """
    k = machine.kernel
    fets, amplifiers = k.transistors.sign.size, k.amplifier_terminal.shape[1]
    found = Flow(
        np.zeros(fets), np.zeros((2, fets)), np.zeros((5, amplifiers)), np.zeros(k.diodes.saturation.size),
        np.zeros(k.columns), np.zeros(k.columns), *(np.zeros(pair.shape[1]) for pair in ends),
    )  # fmt: skip
    if name not in current_names(machine):
        raise unknown_name(f"{machine.flat.circuit.name} current", name, current_names(machine))
    labels = {kind: machine.flat.labels(kind) for kind in _KINDS}
    if name in labels[Transistor]:
        found.channel[labels[Transistor].index(name)] = 1.0
    elif name in labels[Diode]:
        own = labels[Diode].index(name)
        found.diode[own] = 1.0
        if k.diodes.charge[own] >= 0:
            found.charge[k.diodes.charge[own]] = 1.0
    elif any(name in own for own in labels.values()):
        _fill_linear(machine, name, labels, found)
    else:
        _fill_source(machine, name, ends, found)
    return found


_KINDS: tuple[type[Device], ...] = (Transistor, Diode, Resistor, Capacitor, ControlledSource)


def _fill_linear(machine: Machine, name: str, labels: Mapping[type[Device], Sequence[str]], f: Flow) -> None:
    """A resistor, a capacitor or a controlled source."""
    kind = next(kind for kind in (Resistor, Capacitor, ControlledSource) if name in labels[kind])
    own = labels[kind].index(name)
    groups = [group for group in machine.flat.groups if isinstance(group.device, kind)]
    nodes = machine.column[np.concatenate([group.nodes for group in groups], axis=1)[:, own]]
    if kind is ControlledSource:
        nodes, parameter = nodes[2:], [group.parameters["transconductance"] for group in groups]
    else:
        circuit = machine.flat.circuit.name
        parameter = [
            np.broadcast_to(made(group, circuit, machine.silicon), group.nodes.shape[1:]) for group in groups
        ]
    value, into = float(np.concatenate(parameter)[own]), f.linear
    if kind is Resistor:
        value = 1.0 / value
        f.resistors[own] = 1.0
    elif kind is Capacitor:
        into = f.charge
        f.pairs[f.pairs.size - len(labels[Capacitor]) + own] = 1.0
    into[nodes[0]] += value
    into[nodes[1]] -= value


def _fill_source(machine: Machine, name: str, ends: Ends, f: Flow) -> None:
    """A source: of current what it gives, of voltage what all that ends at its node takes, with a minus."""
    k, own = machine.kernel, machine.source_names.index(name)
    column = k.unknowns + own
    if machine.source_quantities[own] == "current":
        f.linear[column] = 1.0
        return
    terminal = k.transistors.terminal
    f.channel[:] = (terminal[2] == column).astype(float) - (terminal[0] == column)
    for side in range(2):
        f.junction[side] = (terminal[3] == column).astype(float) - (terminal[2 * side] == column)
    f.amplifier[:] = -(k.amplifier_terminal == column).astype(float)
    f.diode[:] = (k.diodes.terminal[1] == column).astype(float) - (k.diodes.terminal[0] == column)
    for into, entries in ((f.linear, machine.source_conductance), (f.charge, machine.source_charge)):
        row, at, value = entries
        np.subtract.at(into, at[row == column], value[row == column])
    for into, (a, b) in zip((f.resistors, f.pairs), ends, strict=True):
        into[:] = (b == column).astype(float) - (a == column)


@compiled()
def conducted(k: Kernel, voltage: F64, f: Flow, w: Work, out: F64) -> None:
    """Fill in what flows without charge at each row, A, float64[rows]; voltage: float64[rows, columns], V."""
    for row in range(voltage.shape[0]):
        evaluate(k, voltage[row], w)
        out[row] = _here(voltage[row], f, w)


@compiled()
def carried(k: Kernel, voltage: F64, weight: F64, f: Flow, w: Work) -> float:
    """Return the weighted sum over the rows of what flows without charge."""
    total = 0.0
    for row in range(voltage.shape[0]):
        if weight[row] != 0.0:
            evaluate(k, voltage[row], w)
            total += weight[row] * _here(voltage[row], f, w)
    return total


@compiled()
def gather(k: Kernel, voltage: F64, weight: F64, f: Flow, w: Work, m: int, slopes: F64, s: Sums) -> None:
    """Add what a current without charge does to measure m; slopes: of it by voltages, float64[rows, columns].

    weight: slope of the measure by the current at each row, float64[rows].
    """
    for row in range(voltage.shape[0]):
        if weight[row] != 0.0:
            evaluate(k, voltage[row], w)
            s.direct[m] += weight[row] * _here(voltage[row], f, w)
            _gather_transistors(k, voltage[row], weight[row], f, w, m, slopes[row], s)
            _gather_others(k, weight[row], f, w, slopes[row])


@compiled()
def _here(v: F64, f: Flow, w: Work) -> float:
    """What flows without charge where w is evaluated, A."""
    total, x = 0.0, w.transistor
    for i in range(f.channel.size):
        total += f.channel[i] * x.current[i]
        for side in range(2):
            total += f.junction[side, i] * x.junction[side, i]
    for j in range(f.amplifier.shape[1]):
        for i in range(5):
            total += f.amplifier[i, j] * w.amplifier_current[i, j]
    for d in range(f.diode.size):
        total += f.diode[d] * w.diode_current[0, d]
    for c in range(f.linear.size):
        total += f.linear[c] * v[c]
    return total


@compiled()
def _gather_transistors(k: Kernel, v: F64, z: float, f: Flow, w: Work, m: int, slopes: F64, s: Sums) -> None:
    for i in range(f.channel.size):
        by = z * f.channel[i]
        if by != 0.0:
            add_channel(k, v, w, i, -by, m, s)
            slope_channel(k, w, i, by, slopes)
        if k.transistors.leaks:
            for side in range(2):
                by = z * f.junction[side, i]
                add_junction(w, i, side, -by, m, s)
                slope_junction(k, w, i, side, by, slopes)


@compiled()
def _gather_others(k: Kernel, z: float, f: Flow, w: Work, slopes: F64) -> None:
    for j in range(f.amplifier.shape[1]):
        for i in range(5):
            slope_amplifier(k, w, j, i, z * f.amplifier[i, j], slopes)
    for d in range(f.diode.size):
        slope_diode(k, w, d, z * f.diode[d] * w.diode_slope[0, d], slopes)
    for c in range(f.linear.size):
        slopes[c] += z * f.linear[c]


@compiled(forceinline=True)
def slope_channel(k: Kernel, w: Work, i: int, by: float, slopes: F64) -> None:
    """Add what voltages do to the current of channel i, times `by`; slopes: float64[columns], as below."""
    t, g = k.transistors.terminal, w.transistor.conductance
    for end in range(3):
        slopes[t[end, i]] += by * g[end, i]
        slopes[t[3, i]] -= by * g[end, i]


@compiled(forceinline=True)
def slope_junction(k: Kernel, w: Work, i: int, side: int, by: float, slopes: F64) -> None:
    """Add what voltages do to the current of the junction at drain, 0, or source, 1, of transistor i."""
    t, g = k.transistors.terminal, w.transistor.junction_conductance
    own, gate = by * g[side, i], by * g[2 + side, i]
    slopes[t[2 * side, i]] += own
    slopes[t[1, i]] += gate
    slopes[t[3, i]] -= own + gate


@compiled(forceinline=True)
def slope_amplifier(k: Kernel, w: Work, j: int, i: int, by: float, slopes: F64) -> None:
    """Add what voltages do to the current into terminal i of amplifier j."""
    for c in range(5):
        slopes[k.amplifier_terminal[c, j]] += by * w.amplifier_slope[i, c, j]


@compiled(forceinline=True)
def slope_diode(k: Kernel, w: Work, d: int, by: float, slopes: F64) -> None:
    """Add what the voltage across diode d does; by: its slope included."""
    slopes[k.diodes.terminal[0, d]] += by
    slopes[k.diodes.terminal[1, d]] -= by
