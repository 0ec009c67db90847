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

from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled
from circuits.devices import Capacitor, ControlledSource, Diode, Resistor, Transistor
from circuits.devices.device import Device
from circuits.errors import unknown_name
from circuits.gradient.backwards import apart
from circuits.gradient.sums import Ends, Heap, Sums, add_channel, add_heap, add_junction, new_heap
from circuits.lowering.kernel import Kernel, Machine
from circuits.lowering.made import made
from circuits.measure.current import current_names
from circuits.solver.lanes.sheet import Sheet, fill, new_sheet
from circuits.solver.newton import Work, add_others, allocate, evaluate
from circuits.vectors import vector
from circuits.vectors.vector import WIDTH, Lanes, rows

every, load, store = vector.every, vector.load, vector.store


class Flow(NamedTuple):
    """A current as weights of what carries it.

    channel : float64[transistors]. junction : float64[2, transistors], at drain and source.
    amplifier : float64[5, amplifiers]. diode : float64[diodes].
    linear : float64[columns], S. charge : float64[columns], F.
    resistors, pairs : float64 of each pair of `circuits.gradient.sums`.
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
        Columns of pairs (`circuits.gradient.sums`).

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
    labels = {kind: machine.flat.labels(kind) for kind in _KINDS}
    if name not in machine.source_names and not any(name in own for own in labels.values()):
        raise unknown_name(f"{machine.flat.circuit.name} current", name, current_names(machine))
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


class _Room(NamedTuple):
    """Working memory: which transistors a current has a weight of, int64, and float64[columns, WIDTH]."""

    work: Work
    sheet: Sheet
    which: I64
    slopes: F64
    here: F64


def _room(k: Kernel, f: Flow) -> _Room:
    which = np.flatnonzero((f.channel != 0.0) | (f.junction != 0.0).any(axis=0))
    return _Room(allocate(k), new_sheet(k), which, rows(k.columns), rows(1))


def conducted(k: Kernel, voltage: F64, f: Flow, wanted: Bools) -> F64:
    """Return what flows without charge, A, float64[rows], at rows that are wanted, bool[rows].

    voltage: float64[rows, columns], V.
    """
    found = np.zeros(len(voltage))
    _conduct(k, voltage, f, wanted, _room(k, f), found)
    return found


def gather(k: Kernel, voltage: F64, weight: F64, f: Flow, m: int, slopes: F64, s: Sums) -> None:
    """Add what a current without charge does to measure m.

    Parameters
    ----------
    k
        The kernel.
    voltage
        float64[rows, columns], V.
    weight
        Slope of the measure by the current at each row, float64[rows].
    f
        The current.
    m
        Number of the measure.
    slopes
        Of it by voltages, float64[rows, columns], to which those of the current are added.
    s
        The sums of measures, to which the devices' are added.
    """
    heap = new_heap(k, len(s.direct))
    _gather(k, voltage, weight, f, _room(k, f), slopes, heap._replace(direct=heap.direct[m : m + 1]), m)
    add_heap(heap, s)


@compiled()
def _conduct(k: Kernel, voltage: F64, f: Flow, wanted: Bools, room: _Room, out: F64) -> None:
    for first in range(0, voltage.shape[0], WIDTH):
        end, some = min(first + WIDTH, voltage.shape[0]), False
        for row in range(first, end):
            some = some or wanted[row]
        if some:
            fill(k, room.which, voltage, first, room.sheet)
            _through_transistors(k, f, room)
            for row in range(first, end):
                out[row] = room.here[0, row - first] + _through_others(k, voltage[row], f, room.work)


@compiled()
def _through_transistors(k: Kernel, f: Flow, room: _Room) -> None:
    """Fill in what flows through transistors at the rows of the sheet, A."""
    total, n, x = every(0.0), f.channel.size, room.sheet
    for p in range(room.which.size):
        i = room.which[p]
        total = total + f.channel[i] * load(x.current, i)
        for side in range(2):
            total = total + f.junction[side, i] * load(x.current, (1 + side) * n + i)
    store(room.here, 0, total)


@compiled()
def _through_others(k: Kernel, v: F64, f: Flow, w: Work) -> float:
    """What flows without charge through other devices at voltages v, A; w becomes as evaluated there."""
    total = 0.0
    if f.amplifier.shape[1] + f.diode.size > 0:
        add_others(k, v, w)
    for j in range(f.amplifier.shape[1]):
        for i in range(5):
            total += f.amplifier[i, j] * w.amplifier_current[i, j]
    for d in range(f.diode.size):
        total += f.diode[d] * w.diode_current[0, d]
    for c in range(f.linear.size):
        total += f.linear[c] * v[c]
    return total


@compiled()
def _gather(
    k: Kernel, voltage: F64, weight: F64, f: Flow, room: _Room, slopes: F64, heap: Heap, m: int
) -> None:
    for first in range(0, voltage.shape[0], WIDTH):
        end, some = min(first + WIDTH, voltage.shape[0]), False
        for row in range(first, end):
            some = some or weight[row] != 0.0
        if some:
            fill(k, room.which, voltage, first, room.sheet)
            for lane in range(WIDTH):
                heap.own[0, lane] = weight[first + lane] if first + lane < end else 0.0
            _gather_transistors(k, f, room, load(heap.own, 0), m, heap)
            for row in range(first, end):
                lane, z = row - first, weight[row]
                heap.direct[0] += z * _through_others(k, voltage[row], f, room.work)
                _gather_others(k, z, f, room.work, slopes[row])
                for c in range(k.columns):
                    slopes[row, c] += room.slopes[c, lane]


@compiled()
def _gather_transistors(k: Kernel, f: Flow, room: _Room, z: Lanes, m: int, heap: Heap) -> None:
    """Put what transistors do on the heap, and fill in what the voltages do by them; z: weights of rows."""
    t, x, n = k.transistors.terminal, room.sheet, f.channel.size
    for c in range(k.columns):
        store(room.slopes, c, every(0.0))
    for p in range(room.which.size):
        i = room.which[p]
        drain, gate, source, bulk = t[0, i], t[1, i], t[2, i], t[3, i]
        if f.channel[i] != 0.0:
            by = z * f.channel[i]
            add_channel(x, i, 0.0 - by, m, heap)
            _slope(room.slopes, drain, bulk, by * load(x.slope, i))
            _slope(room.slopes, gate, bulk, by * load(x.slope, n + i))
            _slope(room.slopes, source, bulk, by * load(x.slope, 2 * n + i))
        for side in range(2 if k.transistors.leaks else 0):
            end = source if side else drain
            if f.junction[side, i] != 0.0 and end != bulk:
                by = z * f.junction[side, i]
                add_junction(x, i, side, 0.0 - by, m, heap)
                _slope(room.slopes, end, bulk, by * load(x.slope, (3 + side) * n + i))
                _slope(room.slopes, gate, bulk, by * load(x.slope, (5 + side) * n + i))


@compiled(forceinline=True)
def _slope(slopes: F64, at: int, bulk: int, by: Lanes) -> None:
    store(slopes, at, load(slopes, at) + by)
    store(slopes, bulk, load(slopes, bulk) - by)


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


@compiled()
def slope_residual(k: Kernel, own: F64, w: Work, slopes: F64) -> None:
    """Add `- m R` by all voltages; own: m, float64[unknowns]; slopes: float64[columns]."""
    t = k.transistors.terminal
    for i in range(k.transistors.sign.size):
        slope_channel(k, w, i, -apart(own, t[0, i], t[2, i]), slopes)
        if k.transistors.leaks:
            for side in range(2):
                slope_junction(k, w, i, side, -apart(own, t[2 * side, i], t[3, i]), slopes)
    for j in range(k.amplifier_terminal.shape[1]):
        for i in range(5):
            slope_amplifier(k, w, j, i, -apart(own, k.amplifier_terminal[i, j], k.columns), slopes)
    for d in range(k.diodes.saturation.size):
        by = -apart(own, k.diodes.terminal[0, d], k.diodes.terminal[1, d]) * w.diode_slope[0, d]
        if k.diodes.charge[d] >= 0:
            by += own[k.diodes.charge[d]] * w.diode_slope[1, d]
        slope_diode(k, w, d, by, slopes)
    for i in range(k.unknowns):
        for p in range(k.conductance.start[i], k.conductance.start[i + 1]):
            slopes[k.conductance.column[p]] -= own[i] * k.conductance.value[p]


def sloped(k: Kernel, voltage: F64, moved: F64) -> F64:
    """Return `- sum m dR/dv` over rows by the voltages of all columns, float64[measures, columns].

    R is without what stores charge. voltage: float64[rows, columns], V; moved: m, float64[measures, rows,
    unknowns].
    """
    found = np.zeros((len(moved), k.columns))
    _sloped(k, voltage, moved, allocate(k), found)
    return found


@compiled()
def _sloped(k: Kernel, voltage: F64, moved: F64, w: Work, out: F64) -> None:
    for row in range(voltage.shape[0]):
        evaluate(k, voltage[row], w)
        for m in range(moved.shape[0]):
            slope_residual(k, moved[m, row], w, out[m])
