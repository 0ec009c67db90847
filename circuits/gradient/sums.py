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
from circuits.lowering.flatten import DeviceGroup
from circuits.lowering.kernel import Kernel, Machine
from circuits.solver.lanes.sheet import Sheet
from circuits.solver.newton import Work
from circuits.vectors import vector
from circuits.vectors.vector import WIDTH, Lanes, rows

load, store = vector.load, vector.store

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
    parts : float64[measures PARTS transistors, WIDTH].
    direct : float64[measures], as of `Sums`.
    """

    own: F64
    parts: F64
    direct: F64


PARTS = 10  # of the sums by transistor, in their order, the first of drain and of source as two


def no_sums(k: Kernel, measures: int, ends: Ends) -> Sums:
    """Return the sums of some measures over no step; ends: of resistors, and of what has a capacitance."""
    m, t = measures, k.transistors.sign.size
    a, b, c, d, e, f = (np.zeros((m, t)) for _ in range(6))
    own, gate = np.zeros((m, 2, t)), np.zeros((m, 2, t))
    conductance, charge = (np.zeros((m, pairs.shape[1])) for pairs in ends)
    return Sums(a, b, c, d, e, f, own, gate, charge, conductance, np.zeros(m))


def new_heap(k: Kernel, measures: int) -> Heap:
    """An empty heap."""
    return Heap(rows(k.columns), rows(measures * PARTS * k.transistors.sign.size), np.zeros(measures))


def add_heap(heap: Heap, s: Sums) -> None:
    """Add up what is on a heap."""
    measures, n = s.by_drain.shape
    parts = heap.parts.sum(axis=1).reshape(measures, PARTS, n)
    for part, each in enumerate((s.by_drain, s.by_gate, s.by_source, s.current, s.early, s.junction)):
        each[:] += parts[:, part]
    s.junction_own[:] += parts[:, 6:8]
    s.junction_gate[:] += parts[:, 8:10]
    s.direct[:] += heap.direct


@compiled()
def heap_up(k: Kernel, moved: F64, first: int, x: Sheet, m: int, heap: Heap) -> None:
    """Put what the transistors do at the rows of a sheet from `first` on to measure m on the heap.

    moved: float64[rows, unknowns], m of the measure.
    """
    t = k.transistors
    for lane in range(WIDTH):
        for i in range(k.unknowns):
            heap.own[i, lane] = moved[first + lane, i] if first + lane < moved.shape[0] else 0.0
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
    """Add what the direct currents at a row do to measure m; w: as evaluated there; own: its m."""
    total = 0.0
    for i in range(k.unknowns):
        total += own[i] * w.residual[i]
    direct[m] -= total
