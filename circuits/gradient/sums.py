"""Sums over the steps of what devices do to measures: one a device, and one a pair of columns.

They are gathered in lanes (`circuits.solver.lanes.sheet`) on a heap, which is added up once all rows are in.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled
from circuits.devices import Capacitor, Resistor, Transistor
from circuits.gradient.way import Way
from circuits.lowering.flatten import DeviceGroup
from circuits.lowering.kernel import Kernel, Machine
from circuits.solver.lanes.sheet import Sheet
from circuits.solver.newton import Work
from circuits.vectors import vector
from circuits.vectors.vector import WIDTH, Lanes, rows

every, load, store = vector.every, vector.load, vector.store

Ends = tuple[I64, I64]
"""Columns of the ends of resistors, and of what has a capacitance, int64[2, pairs] each."""
OVERLAPS = ((1, 0), (1, 2), (0, 3), (2, 3))  # of a transistor's terminals, as `capacitances` has them


def ends_of(machine: Machine) -> Ends:
    """Return the ends of resistors, and of pairs of transistors and of capacitors, in that order."""
    fets, capacitors = groups_of(machine, Transistor), groups_of(machine, Capacitor)
    pairs = [_ends(machine, fets, (1, 3)), *(_ends(machine, fets, p) for p in OVERLAPS)]
    charged = np.concatenate([*pairs, _ends(machine, capacitors, (0, 1))], axis=1)
    return _ends(machine, groups_of(machine, Resistor), (0, 1)), charged


def groups_of(machine: Machine, kind: type) -> list[DeviceGroup]:
    """Return the groups of devices of a kind."""
    return [g for g in machine.flat.groups if isinstance(g.device, kind)]


def _ends(machine: Machine, groups: Sequence[DeviceGroup], pair: tuple[int, int]) -> I64:
    """Columns of two terminals of all devices of some groups, int64[2, devices]."""
    found = [machine.column[group.nodes[list(pair)]] for group in groups]
    return np.concatenate([np.zeros((2, 0), np.int64), *found], axis=1)


class Sums(NamedTuple):
    """Sums over the steps of a measure, each `- sum m dR`, by device.

    by_drain, by_gate, by_source : float64[measures, transistors], by the voltages at the channel, unit/V.
    current : float64[measures, transistors], by ln of the channel's current, unit.
    early : float64[measures, transistors], by ln of what the Early effect divides by the length, unit.
    junction : float64[measures, transistors], by ln of the junctions' leakage, unit.
    junction_own : float64[measures, 2, transistors], by drain and source at their junctions, unit/V.
    junction_gate : float64[measures, 2, transistors], by the gate at those junctions, unit/V.
    charge : float64[measures, pairs], by a capacitance between two columns, unit/F.
    conductance : float64[measures, pairs], by a conductance between two columns, unit/S.
    direct : float64[measures], `- sum m (G v + i)`, in the measure's unit.
    """

    by_drain: F64
    by_gate: F64
    by_source: F64
    current: F64
    early: F64
    junction: F64
    junction_own: F64
    junction_gate: F64
    charge: F64
    conductance: F64
    direct: F64


class Heap(NamedTuple):
    """Sums of measures before they are added up.

    own : float64[columns, WIDTH], m of a measure at the rows of a sheet, 0 where sources fix the voltage.
    rate : float64[columns, WIDTH], V/s, of the voltages at those rows.
    parts : float64[measures PARTS transistors, WIDTH].
    charge, conductance : float64[measures pairs, WIDTH].
    direct : float64[measures], as of `Sums`, of all but transistors.
    """

    own: F64
    rate: F64
    parts: F64
    charge: F64
    conductance: F64
    direct: F64


PARTS = 10  # of the sums by transistor, in their order, the first of drain and of source as two


def no_sums(k: Kernel, measures: int, ends: Ends) -> Sums:
    """Return the sums of some measures over no step; ends: of resistors, and of what has a capacitance."""
    m, t = measures, k.transistors.sign.size
    a, b, c, d, e, f = (np.zeros((m, t)) for _ in range(6))
    own, gate = np.zeros((m, 2, t)), np.zeros((m, 2, t))
    conductance, charge = (np.zeros((m, pairs.shape[1])) for pairs in ends)
    return Sums(a, b, c, d, e, f, own, gate, charge, conductance, np.zeros(m))


def new_heap(k: Kernel, measures: int, pairs: tuple[int, int] = (0, 0)) -> Heap:
    """An empty heap; pairs: how many, of resistors and of what has a capacitance."""
    parts, conductance, charge = (measures * n for n in (PARTS * k.transistors.sign.size, *pairs))
    own, rate = rows(k.columns), rows(k.columns)
    return Heap(own, rate, rows(parts), rows(charge), rows(conductance), np.zeros(measures))


def add_heap(heap: Heap, s: Sums) -> None:
    """Add up what is on a heap."""
    measures, n = s.by_drain.shape
    parts = heap.parts.sum(axis=1).reshape(measures, PARTS, n)
    for part, each in enumerate((s.by_drain, s.by_gate, s.by_source, s.current, s.early, s.junction)):
        each[:] += parts[:, part]
    s.junction_own[:] += parts[:, 6:8]
    s.junction_gate[:] += parts[:, 8:10]
    s.direct[:] += heap.direct + parts[:, 3].sum(axis=1) + parts[:, 5].sum(axis=1)
    for each, own in ((s.charge, heap.charge), (s.conductance, heap.conductance)):
        if own.size:
            each[:] += own.sum(axis=1).reshape(each.shape)


@compiled()
def lay_rates(way: Way, first: int, heap: Heap) -> None:
    """Fill in the rates of the voltages at the rows from `first` on, and none behind the last."""
    voltage, share = way.voltage, way.share
    for lane in range(WIDTH):
        row = first + lane
        for c in range(voltage.shape[1]):
            rate = share[row, 0] * voltage[row, c] if row < voltage.shape[0] else 0.0
            for j in range(1, min(row + 1, 3) if row < voltage.shape[0] else 1):
                rate += share[row, j] * voltage[row - j, c]
            heap.rate[c, lane] = rate


@compiled()
def heap_up_pairs(ends: Ends, x: Sheet, m: int, heap: Heap) -> None:
    """Put what resistors and capacitances do at the rows of a sheet to measure m on the heap.

    `heap_up` has laid m there, and `lay_rates` the rates.
    """
    across, charged = ends
    for q in range(across.shape[1]):
        a, b = across[0, q], across[1, q]
        drop = load(x.v, a) - load(x.v, b)
        _put(heap.conductance, m * across.shape[1] + q, (load(heap.own, a) - load(heap.own, b)) * drop)
    for q in range(charged.shape[1]):
        a, b = charged[0, q], charged[1, q]
        rate = load(heap.rate, a) - load(heap.rate, b)
        _put(heap.charge, m * charged.shape[1] + q, (load(heap.own, a) - load(heap.own, b)) * rate)


@compiled()
def lay_moved(moved: F64, first: int, heap: Heap) -> None:
    """Lay m of a measure at the rows from `first` on, and none behind the last; moved: as of `heap_up`."""
    for lane in range(WIDTH):
        for i in range(moved.shape[1]):
            heap.own[i, lane] = moved[first + lane, i] if first + lane < moved.shape[0] else 0.0


@compiled(forceinline=True)
def through(k: Kernel, x: Sheet, heap: Heap) -> Lanes:
    """Return the sum of what all transistors take, A, times m across them, at the rows of a sheet."""
    t, n, total = k.transistors, k.transistors.sign.size, every(0.0)
    for i in range(n):
        at_bulk, ends = load(heap.own, t.terminal[3, i]), (t.terminal[0, i], t.terminal[2, i])
        total = total + (load(heap.own, ends[0]) - load(heap.own, ends[1])) * load(x.current, i)
        for side in range(2 if t.leaks else 0):
            across = load(heap.own, ends[side]) - at_bulk
            total = total + across * load(x.current, (1 + side) * n + i)
    return total


@compiled()
def heap_up(k: Kernel, moved: F64, first: int, x: Sheet, m: int, heap: Heap) -> None:
    """Put what the transistors do at the rows of a sheet from `first` on to measure m on the heap.

    moved: float64[rows, unknowns], m of the measure.
    """
    t = k.transistors
    lay_moved(moved, first, heap)
    for i in range(t.sign.size):
        at_bulk, ends = load(heap.own, t.terminal[3, i]), (t.terminal[0, i], t.terminal[2, i])
        add_channel(x, i, load(heap.own, ends[0]) - load(heap.own, ends[1]), m, heap)
        for side in range(2 if t.leaks else 0):
            if ends[side] != t.terminal[3, i]:
                add_junction(x, i, side, load(heap.own, ends[side]) - at_bulk, m, heap)


@compiled(forceinline=True)
def add_channel(x: Sheet, i: int, channel: Lanes, m: int, heap: Heap) -> None:
    """Put what the channel of transistor i does to measure m on the heap; channel: m across it."""
    n = x.early.shape[0]
    at, through = m * PARTS * n + i, channel * load(x.current, i)
    for end in range(3):
        _put(heap.parts, at + end * n, channel * load(x.slope, end * n + i))
    _put(heap.parts, at + 3 * n, through)
    _put(heap.parts, at + 4 * n, through * load(x.early, i))


@compiled(forceinline=True)
def add_junction(x: Sheet, i: int, side: int, across: Lanes, m: int, heap: Heap) -> None:
    """Put what the junction at drain, 0, or source, 1, of transistor i does there; across: m across it."""
    n = x.early.shape[0]
    at = m * PARTS * n + i
    _put(heap.parts, at + 5 * n, across * load(x.current, (1 + side) * n + i))
    _put(heap.parts, at + (6 + side) * n, across * load(x.slope, (3 + side) * n + i))
    _put(heap.parts, at + (8 + side) * n, across * load(x.slope, (5 + side) * n + i))


@compiled(forceinline=True)
def _put(parts: F64, row: int, value: Lanes) -> None:
    store(parts, row, load(parts, row) - value)


@compiled(forceinline=True)
def add_direct(k: Kernel, own: F64, w: Work, m: int, direct: F64) -> None:
    """Add what the direct currents of a row's residual do to measure m; own: its m, float64[unknowns]."""
    total = 0.0
    for i in range(k.unknowns):
        total += own[i] * w.residual[i]
    direct[m] -= total
