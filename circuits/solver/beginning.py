"""Where a run begins: at rest, a little beside a rest state that is not stable, or with stated voltages.

From an operating point that is not stable the smallest disturbance leads away. A solver without noise makes
none, so that an oscillator would stay silent for ever. So one is made: `NUDGE` at one node of each part of
the circuit that is not stable, namely at the node whose displacement has the largest growing part.

Stated voltages (`Testbench.initial`, and `Capacitor.ic` where one end of the capacitor is held or driven) act
as sources that go away at time 0; the other nodes are at rest with them. With `uic` there is no rest state:
every capacitance has the charge of its own initial voltage, and the nodes begin where these charges put them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.devices import Capacitor
from circuits.devices.source import polyline
from circuits.errors import ParameterError, SolverError
from circuits.lowering.flatten import FlatCircuit
from circuits.lowering.kernel import Machine, complete_sources, to_kernel
from circuits.lowering.made import made
from circuits.silicon.silicon import Silicon
from circuits.solver.integrate import source_values
from circuits.solver.modes import parts_without_charge, unstable_part, without_charges
from circuits.solver.newton import allocate, evaluate, newton, store_charges
from circuits.solver.operating_point import NUDGE, OperatingPoint, operating_point
from circuits.solver.outcome import Outcome
from circuits.solver.small_signal import linearise
from circuits.testbench import Testbench

csgraph = later("scipy.sparse.csgraph")

_TOGETHER = 1e-3  # ours: share of a displacement that another node grows by, from which both are one part
_EQUAL = 0.99  # ours: nodes within this of the largest growth count as equal, so that rounding chooses none
_INSTANT = 1e-18  # s, in which charges move to where the initial voltages put them
_TRIES = 50
_SETTLED = 1e-12  # V
_SAME = 1e-9  # V, within which two statements about one node are the same


class Disturbed(UserWarning):
    """Warning that a run was taken away from a rest state that is not stable."""


@dataclass(frozen=True, slots=True)
class Disturbance:
    """What took a run away from a rest state that is not stable: `voltage` (V) added at each of `nodes`.

    Without nodes it was the noise of the run itself.
    """

    nodes: tuple[str, ...]
    voltage: float

    @property
    def what(self) -> str:
        """The disturbance in words."""
        if not self.nodes:
            return "the noise of the first step"
        more = f" and {len(self.nodes) - 1} more" if self.nodes[1:] else ""
        return f"{self.voltage * 1e3:g} mV added at {self.nodes[0]}{more}"

    def __str__(self) -> str:
        """What happened, in one line."""
        return f"the operating point is not stable: the run begins with {self.what}"


NOISE = Disturbance((), 0.0)


@dataclass(frozen=True, slots=True)
class Beginning:
    """How a run begins: `voltage`, float64[columns], V, and `point`, the rest state behind it."""

    point: OperatingPoint
    voltage: F64
    disturbance: Disturbance | None = None


def beginning(
    machine: Machine,
    *,
    start: Mapping[str, float] | None = None,
    point: OperatingPoint | None = None,
    time: float = 0.0,
) -> Beginning:
    """Where a run of the machine's testbench begins at `time` (s).

    start: a guess at the rest state (V by node path), the testbench's own unless given. point: the rest
    state, solved for unless given; where voltages are held it is the guess. Where they are, or with `uic`,
    the `point` returned holds the first voltages and is called not stable.

    Raises
    ------
    ParameterError
        A held voltage contradicts another or a source, or no end of a capacitor with an `ic` is fixed.
    SolverError
        There is no such state.
    UnknownNameError
        No such node.
    """
    bench = machine.testbench
    if bench.begin == "uic":
        voltage = _from_charges(machine, time)
        return Beginning(OperatingPoint(machine, voltage, stable=False), voltage)
    held = held_voltages(bench, machine.flat, machine.silicon, time)
    if held:
        guess = dict(start or bench.start) if point is None else point.voltages()
        voltage = _held(machine, held, guess, time)
        return Beginning(OperatingPoint(machine, voltage, stable=False), voltage)
    point = operating_point(machine, start=start, time=time) if point is None else point
    if point.stable or bench.begin == "at_rest":
        return Beginning(point, point.voltage)
    found, voltage = disturbance(point), point.voltage.copy()
    voltage[[machine.column_of(node) for node in found.nodes]] += found.voltage
    store_charges(machine.kernel, voltage, allocate(machine.kernel))
    return Beginning(point, voltage, found)


def disturbance(point: OperatingPoint) -> Disturbance:
    """What takes a run away from a rest state that is not stable."""
    machine, linear = point.machine, linearise(point)
    n = machine.kernel.unknowns
    free = np.flatnonzero(machine.column < n)  # numbers of the unknown nodes, in the circuit's order
    columns = machine.column[free]
    hidden = machine.kernel.charges
    matrices = (m[:, :n].toarray() for m in (linear.conductance, linear.charge))
    growing = unstable_part(*without_charges(hidden, *matrices))
    columns = columns - hidden
    size = np.linalg.norm(growing, axis=0)[columns]
    together = np.abs(growing[np.ix_(columns, columns)]) > _TOGETHER
    count, part = csgraph.connected_components(together, directed=False)
    nodes = []
    for k in range(count):
        own = np.flatnonzero(part == k)
        if size[own].max() > _TOGETHER:
            nodes.append(machine.names[free[own[np.argmax(size[own] >= _EQUAL * size[own].max())]]])
    return Disturbance(tuple(nodes), NUDGE)


def held_voltages(
    testbench: Testbench, flat: FlatCircuit, silicon: Silicon, time: float = 0.0
) -> dict[str, float]:
    """Voltages (V) by node path that hold at `time` (s): the testbench's and those of capacitors.

    flat: its circuit. What a source holds there anyway is left out. Raises `ParameterError` for a
    contradiction.
    """
    charged = [(g, d.ic) for g in flat.groups if isinstance(d := g.device, Capacitor) and d.ic is not None]
    if not (testbench.initial or charged):
        return {}
    driven = _driven(testbench, flat, silicon, time)
    held: dict[int, float] = {}
    for node, voltage in testbench.initial.items():
        number = flat.node(node)
        if abs(driven.get(number, voltage) - voltage) > _SAME:
            found = f"{node}: initial {voltage:g} V, but a source holds it at {driven[number]:g} V"
            raise ParameterError(f"{found}; leave one of them out")
        if number not in driven:
            held[number] = voltage
    for group, voltage in charged:
        for k, (a, b) in enumerate(group.nodes.T.tolist()):
            _hold_across(held, driven | held, f"{group.label(k)}.ic", a, b, voltage)
    return {flat.node_name(number): voltage for number, voltage in held.items()}


def _hold_across(
    held: dict[int, float], fixed: Mapping[int, float], label: str, a: int, b: int, difference: float
) -> None:
    """Hold the free end of a capacitor whose other end is fixed, `difference` (V) apart."""
    if a in fixed and b in fixed:
        apart = fixed[a] - fixed[b]
        if abs(apart - difference) > _SAME:
            found = f"{label}: {difference:g} V, but its ends are held {apart:g} V apart"
            raise ParameterError(f"{found}; correct one of them")
    elif a in fixed:
        held[b] = fixed[a] - difference
    elif b in fixed:
        held[a] = fixed[b] + difference
    else:
        found = f"{label}: {difference:g} V between two nodes that nothing holds"
        raise ParameterError(f"{found}; hold one, or begin with uic")


def _driven(testbench: Testbench, flat: FlatCircuit, silicon: Silicon, time: float) -> dict[int, float]:
    """Voltages (V) of ground and of the nodes that sources hold, by number."""
    found = {0: 0.0}
    for source in complete_sources(testbench, flat, silicon):
        if source.quantity == "voltage":
            voltage = float(np.interp(time, *polyline(source.name, source.waveform)))
            found |= dict.fromkeys(flat.port_nodes(source.node).tolist(), voltage)
    return found


def _held(machine: Machine, held: Mapping[str, float], guess: Mapping[str, float], time: float) -> F64:
    """Rest state with voltages held, as a voltage vector of the machine."""
    clamped = to_kernel(machine.testbench, machine.silicon, held)
    known = {node: v for node, v in guess.items() if node in set(clamped.names) - set(held)}
    found = operating_point(clamped, start=known or None, time=time)
    vector = np.zeros(machine.kernel.columns)
    sources = machine.sources()
    source_values(sources, sources.start[:-1].copy(), time, vector, machine.kernel.unknowns)
    vector[machine.column] = found.voltage[clamped.column]
    store_charges(machine.kernel, vector, allocate(machine.kernel))
    return vector


def _from_charges(machine: Machine, time: float) -> F64:
    """Voltage vector in which every capacitance has the charge of its initial voltage.

    The nodes move there in one implicit step of an instant, so that those without charge follow. Those with
    a charge between them follow to its rounding only: they are then set to where their currents add up.
    """
    k, before = machine.kernel, np.zeros(machine.kernel.columns)
    for node, voltage in machine.testbench.initial.items():
        before[machine.column_of(node)] = voltage
    before[: k.unknowns] += _offset(machine, before)
    work = allocate(k)
    store_charges(k, before, work)
    v, sources = before.copy(), machine.sources()
    source_values(sources, sources.start[:-1].copy(), time, v, k.unknowns)
    v[k.columns - 1] = before[k.columns - 1] = 0.0
    for _ in range(_TRIES):
        if newton(k, 1.0 / _INSTANT, -before / _INSTANT, v, 1e-6, work) > 0:
            return _settled(machine, v)
    raise SolverError(f"{machine.testbench.title}: no start with uic; {Outcome.NO_OPERATING_POINT.value}")


def _settled(machine: Machine, begun: F64) -> F64:
    """The voltage vector next to `begun` with its charges, in which no current is left that no charge takes.

    `begun` is returned where none is found, and where diodes have charges of their own.
    """
    k, v, work = machine.kernel, begun.copy(), allocate(machine.kernel)
    n, linear = k.unknowns, linearise(OperatingPoint(machine, v, stable=False))
    parts = np.zeros((n, 0)) if k.charges else parts_without_charge(linear.charge[:, :n])
    if not (parts.sum(axis=0) > 1.0).any():  # a node by itself follows to its last digit
        return begun
    for _ in range(_TRIES):
        evaluate(k, v, work)
        inner = parts.T @ (linear.conductance[:, :n] @ parts)
        moved = parts @ np.linalg.lstsq(inner, parts.T @ work.residual[:n])[0]
        v[:n] -= moved
        if np.abs(moved).max() < _SETTLED:
            return v
        linear = linearise(OperatingPoint(machine, v, stable=False))
    return begun


def _offset(machine: Machine, before: F64) -> F64:
    """What the unknown nodes' voltages `before` lack for the charges of capacitors with an `ic`, V."""
    n = machine.kernel.unknowns
    missing = np.zeros(n)
    for group in machine.flat.groups:
        device = group.device
        if isinstance(device, Capacitor) and device.ic is not None:
            a, b = machine.column[group.nodes]
            values = made(group, machine.flat.circuit.name, machine.silicon)
            charge = values * (device.ic - (before[a] - before[b]))
            for end, sign in ((a, 1.0), (b, -1.0)):
                np.add.at(missing, end[end < n], sign * charge[end < n])
    if not missing.any():
        return missing
    rows = machine.kernel.charge
    matrix = np.zeros((n, machine.kernel.columns))
    matrix[np.repeat(np.arange(n), np.diff(rows.start)), rows.column] = rows.value
    loaded = matrix.diagonal() > 0.0
    scale = 1.0 / np.sqrt(np.where(loaded, matrix.diagonal(), 1.0))
    found: F64 = scale * np.linalg.lstsq(scale[:, None] * matrix[:, :n] * scale, scale * missing)[0]
    return found
