"""A testbench whose transistors are modules of Verilog-A, as equations: `i(x, t) + d q(x) / dt = 0`.

The unknowns x are the nodes that no source fixes and the internal nodes of every instance. Capacitors,
resistors, linear controlled sources and the sources are those of the native solver (`circuits.lowering`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, I64
from circuits.devices import Capacitor, Diode, OperationalAmplifier, Transistor
from circuits.errors import ParameterError
from circuits.lowering.kernel import Machine, Rows
from circuits.lowering.made import made
from circuits.silicon.process import Polarity
from circuits.solver.integrate import source_values
from netlists.verilog_a.host.models import Model
from netlists.verilog_a.host.module import Module, Residuals


@dataclass(frozen=True, slots=True)
class Instance:
    """A transistor: its module, what it is given, copies in parallel, and the columns of its nodes."""

    module: Module
    given: Mapping[str, float]
    parallel: float
    columns: I64


@dataclass(slots=True)
class Equations:
    """The equations; a vector of voltages is [unknown nodes | sources | ground | internal nodes]."""

    machine: Machine
    instances: list[Instance]
    conductance: F64  # [unknowns, columns] of linear devices
    capacitance: F64
    free: I64  # columns of the unknowns
    columns: int
    evaluations: int = 0

    def place(self, x: F64, time: float) -> F64:
        """The vector of voltages of unknowns `x` with the sources at a time (s)."""
        kernel, sources = self.machine.kernel, self.machine.sources()
        v = np.zeros(self.columns)
        source_values(sources, sources.start[:-1].copy(), time, v[: kernel.columns], kernel.unknowns)
        v[self.free] = x
        return v

    def evaluate(self, x: F64, time: float) -> Residuals:
        """Currents (A) that leave the unknown nodes, charges (C), and their derivatives by the unknowns."""
        v = self.place(x, time)
        known = self.conductance.shape[0]
        current, charge = np.zeros(self.columns), np.zeros(self.columns)
        g, c = np.zeros((self.columns, self.columns)), np.zeros((self.columns, self.columns))
        width = self.conductance.shape[1]
        current[:known], charge[:known] = self.conductance @ v[:width], self.capacitance @ v[:width]
        g[:known, :width], c[:known, :width] = self.conductance, self.capacitance
        for each in self.instances:
            found = each.module.evaluate(each.given, v[each.columns])
            at = np.ix_(each.columns, each.columns)
            np.add.at(current, each.columns, each.parallel * found.current)
            np.add.at(charge, each.columns, each.parallel * found.charge)
            np.add.at(g, at, each.parallel * found.conductance)
            np.add.at(c, at, each.parallel * found.capacitance)
        self.evaluations += 1
        own = np.ix_(self.free, self.free)
        return Residuals(current[self.free], charge[self.free], g[own], c[own])


def equations_of(machine: Machine, models: Mapping[Polarity, Model]) -> Equations:
    """Put the models in the place of the transistors of a machine, which deviate by nothing.

    Raises `ParameterError` for an operational amplifier, a diode and for a die whose transistors deviate.
    """
    die, kernel = machine.silicon.die, machine.kernel
    if die.deviates:
        raise ParameterError(f"die: {die}, models in Verilog-A have no dies here; leave it out")
    instances: list[Instance] = []
    inner = kernel.columns
    capacitance = np.zeros((kernel.unknowns, kernel.columns))
    for group in machine.flat.groups:
        if isinstance(group.device, OperationalAmplifier | Diode):
            what = "a diode" if isinstance(group.device, Diode) else "an amplifier"
            raise ParameterError(f"{group.label(0)}: {what}, not beside models in Verilog-A; leave it out")
        nodes = machine.column[group.nodes]
        if isinstance(group.device, Capacitor):
            value = np.broadcast_to(made(group, machine.flat.circuit.name, machine.silicon), nodes.shape[1:])
            _add_capacitors(capacitance, nodes, value)
        if not isinstance(group.device, Transistor):
            continue
        model = models[group.device.polarity]
        for k in range(nodes.shape[1]):
            sizes = [float(group.parameters[name][k]) for name in ("width", "length", "multiplicity")]
            own = np.arange(inner, inner + len(model.module.nodes) - 4)
            inner += own.size
            given = model.module.given(model.sized(*sizes), machine.silicon.temperature_c)
            parallel = 1.0 if model.multiplicity else sizes[2]
            instances.append(Instance(model.module, given, parallel, np.concatenate([nodes[:, k], own])))
    free = np.concatenate([np.arange(kernel.unknowns), np.arange(kernel.columns, inner)])
    linear = _dense(kernel.conductance, kernel.unknowns, kernel.columns)
    return Equations(machine, instances, linear, capacitance, free, inner)


def _dense(rows: Rows, unknowns: int, columns: int) -> F64:
    found = np.zeros((unknowns, columns))
    at = np.repeat(np.arange(unknowns), np.diff(rows.start))
    np.add.at(found, (at, rows.column), rows.value)
    return found


def _add_capacitors(into: F64, nodes: I64, value: F64) -> None:
    for (a, b), farad in zip(nodes.T, value, strict=True):
        for row, other in ((a, b), (b, a)):
            if row < len(into):
                into[row, row] += farad
                into[row, other] -= farad
