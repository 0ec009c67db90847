"""What a measure can name: the nodes, devices and sources of a machine, and what a run gives of them.

A `Scope` knows names and units before any run, so that a measure is refused early. A `Record` is a run:
waveforms of nodes and currents along its axis. A current flows into the first terminal of its device, as in
SPICE: into a drain, from `a` to `b` of a resistor or capacitor, and into a source out of the circuit, so that
a supply that gives has a negative one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from circuits.arrays import F64, Bools
from circuits.errors import unknown_name
from circuits.lowering.kernel import Machine
from circuits.measure.branch import branches
from circuits.measure.current import (
    course_currents,
    current_in,
    current_names,
    device_current,
    static_currents,
)
from circuits.measure.signal import Signal
from circuits.measure.unit import AMPERE, SECOND, VOLT, Unit
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.power import (
    conduction_and_channels,
    energy_courses,
    node_voltages,
    require_every_node,
)
from circuits.solver.sweep import Sweep
from circuits.solver.transient import Result

_SAME_TIME = 1e-13  # s, of a point and a vertex of a stimulus, as the solver has it


@dataclass(frozen=True, slots=True)
class Scope:
    """Names that measures can use.

    Attributes
    ----------
    nodes : paths of nodes.
    currents : names of devices and sources whose currents are known.
    sources : names of voltage sources, whose energy is known.
    watched : nodes at which the solver itself looks for spikes.
    axis : unit of the axis.
    voltage, current : units of what is told of a node, V, and of a current, A, or those of a transfer.
    transfer : whether voltages are transfers of small signals, with magnitude and phase.
    """

    nodes: frozenset[str]
    currents: frozenset[str]
    sources: frozenset[str] = frozenset()
    watched: frozenset[str] = frozenset()
    axis: Unit = SECOND
    voltage: Unit = VOLT
    current: Unit = AMPERE
    transfer: bool = False


class Record(ABC):
    """A run as measures see it."""

    @property
    @abstractmethod
    def axis(self) -> F64:
        """Points of the run, rising, float64[T]."""

    @property
    def sign(self) -> float:
        """-1 where the run goes down its own axis, as a sweep does; then `axis` has minus its values."""
        return 1.0

    @abstractmethod
    def voltage(self, node: str) -> Signal:
        """Waveform of a node, V."""

    @abstractmethod
    def current(self, device: str) -> Signal:
        """Current of a device or source, A."""

    @abstractmethod
    def energy(self, source: str) -> Signal:
        """Energy that a source has delivered until each point, J."""

    @abstractmethod
    def spikes(self, node: str) -> F64:
        """Times of the spikes at a watched node, float64[n], s."""

    def call(self, name: str, given: Any, found: Any) -> Any:
        """Return what a function is to give that was called with some `Arguments`: what it found."""
        return found


def scope_of(machine: Machine) -> Scope:
    """Names that measures of a transient of a machine can use."""
    watch = [machine.names[n] for w in machine.testbench.watch for n in machine.flat.port_nodes(w)]
    kinds = zip(machine.source_names, machine.source_quantities, strict=True)
    return Scope(
        frozenset(machine.names) - branches(machine).keys(),
        frozenset(current_names(machine)),
        frozenset(name for name, kind in kinds if kind == "voltage"),
        frozenset(watch),
    )


@final
@dataclass(frozen=True, eq=False)
class TransientRecord(Record):
    """A transient run that recorded every node; what its currents stand on is worked out once."""

    result: Result

    @property
    def axis(self) -> F64:
        """Points of the run, float64[T], s."""
        return self.result.time

    def voltage(self, node: str) -> Signal:
        """Waveform of a node, V."""
        require_every_node(self.result, "measure")
        return Signal(self.axis, self.result[node], self._kinks)

    def current(self, device: str) -> Signal:
        """Current of a device or source, A."""
        v, kinks = self._voltages, self._kinks
        found = device_current(self.result.machine, v, self.axis, kinks, device, lambda: self._conducted)
        return Signal(self.axis, found, kinks)

    def currents(self) -> dict[str, F64]:
        """Currents of all devices and sources by name, A, float64[T] each."""
        require_every_node(self.result, "measure")
        return course_currents(self.result.machine, node_voltages(self.result), self.axis, self._kinks)

    def energy(self, source: str) -> Signal:
        """Energy that a source has delivered until each point, J."""
        require_every_node(self.result, "energy")
        return Signal(self.axis, self._energies[source], self._kinks)

    def spikes(self, node: str) -> F64:
        """Times of the spikes at a watched node, float64[n], s."""
        return self.result.spikes[node]

    @cached_property
    def _voltages(self) -> F64:
        return node_voltages(self.result)

    @cached_property
    def _conducted(self) -> tuple[F64, F64]:
        return conduction_and_channels(self.result.machine, self._voltages)

    @cached_property
    def _energies(self) -> dict[str, F64]:
        return energy_courses(self.result, self._conducted[1])

    @cached_property
    def _kinks(self) -> Bools:
        """Points at which a stimulus bends, where the solver begins anew, bool[T]."""
        machine, time = self.result.machine, self.axis
        lines = zip(machine.polylines, machine.sampled, strict=True)
        bends = np.unique(np.concatenate([[0.0], *(t for (t, _), sampled in lines if not sampled)]))
        behind = bends[np.maximum(np.searchsorted(bends, time, side="right") - 1, 0)]
        before = bends[np.minimum(np.searchsorted(bends, time), bends.size - 1)]
        return np.asarray(np.minimum(np.abs(time - behind), np.abs(time - before)) <= _SAME_TIME)


@final
@dataclass(frozen=True, slots=True, eq=False)
class TableRecord(Record):
    """Curves over the values of a sweep, or over frequency; points that go down are turned around.

    Attributes
    ----------
    values : float64[N], in the order in which they were visited, which rises or falls.
    voltages, currents : curves by name, float64[N] (V, A), complex128[N] for transfers.
    """

    values: F64
    voltages: Mapping[str, F64]
    currents: Mapping[str, F64]

    @property
    def axis(self) -> F64:
        """Values of the sweep, rising, float64[N]."""
        return self.sign * self.values

    @property
    def sign(self) -> float:
        """-1 where the points fall."""
        return -1.0 if self.values.size > 1 and self.values[-1] < self.values[0] else 1.0

    def voltage(self, node: str) -> Signal:
        """Curve of a node, V."""
        return self._signal(self.voltages[node])

    def current(self, device: str) -> Signal:
        """Current of a device or source, A."""
        return self._signal(self.currents[device])

    def energy(self, source: str) -> Signal:
        """None: `Scope` has no sources for a table."""
        raise KeyError(source)

    def spikes(self, node: str) -> F64:
        """None: `Scope` has no watched nodes for a table."""
        raise KeyError(node)

    def _signal(self, value: F64) -> Signal:
        return Signal(self.axis, np.asarray(value), np.ones(self.values.size, np.bool_))


def device_currents(
    found: OperatingPoint | Sweep | Result, names: Iterable[str] | None = None
) -> dict[str, F64]:
    """Give the currents of devices and sources by their names, A.

    A current flows into the first terminal of its device, as in SPICE (`circuits.measure.current`): into a
    drain, so that a conducting pFET has a negative one; from `a` to `b`; out of the circuit into a source of
    voltage, so that a supply that gives has a negative one.

    Parameters
    ----------
    found
        An operating point, a sweep, or a run that recorded every node.
    names
        Paths of devices and names of sources, also as `i(NAME)`; all that have a current unless given.

    Returns
    -------
    Current of each, A, float64[T]: T the points of a run, or the values of a sweep; 1 at an operating point.

    Raises
    ------
    UnknownNameError
        Nothing of that name has a current.
    ParameterError
        The run did not record every node.
    """
    machine = found.machine
    known = current_names(machine)
    wanted = {name: current_in(name) or name for name in (known if names is None else names)}
    for name in wanted.values():
        if name not in known:
            raise unknown_name(f"{machine.flat.circuit.name} current", name, known)
    if isinstance(found, Result):
        record = TransientRecord(found)
        if names is None:
            return record.currents()
        return {name: record.current(bare).value for name, bare in wanted.items()}
    still = static_currents(machine, _at_rest(found))
    return {name: still[bare] for name, bare in wanted.items()}


def _at_rest(found: OperatingPoint | Sweep) -> F64:
    """The vector of voltages at each point, float64[N, columns], V; A at sources of current."""
    if isinstance(found, OperatingPoint):
        return found.voltage[np.newaxis, :]
    machine, v = found.machine, node_voltages(found)
    for s, name in enumerate(machine.source_names):
        v[:, machine.kernel.unknowns + s] = found.values if name == found.source else machine.given(s)
    return v
