"""Transistors of a ROLLS circuit as they are on a die, and the capacitances of its nodes.

The devices are those of the transistor level: deviations come from the same paths of the same circuit, so
that one die is one silicon at both levels. n: copies of the circuit, 1 where it stands alone. Voltages of a
pFET count from the supply down.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from chips.model_law import check_law
from chips.static import inverter_threshold
from circuits.arrays import F64
from circuits.bias import bias_voltages
from circuits.circuit import Circuit, InstanceArray
from circuits.devices import Capacitor, Transistor
from circuits.devices.transistor import capacitances
from circuits.errors import unknown_name
from circuits.lowering.flatten import DeviceGroup, flatten
from circuits.silicon.process import POLARITIES, Process
from circuits.silicon.silicon import Silicon


class Fet(NamedTuple):
    """A transistor of each copy: specific current (A) and threshold (V), float64[n], and kappa."""

    current: F64
    threshold: F64
    kappa: float


class DieDevices(NamedTuple):
    """Transistors by path inside the circuit; gate: voltages (V) of bias ports, one or one a copy."""

    u_t: float
    v_dd: float
    copies: int
    fet: Mapping[str, Fet]
    gate: Mapping[str, F64]

    def pinch(self, device: str, gate: F64 | float) -> F64:
        """`kappa (v_g - V_T0) / U_T`, gate: V above the bulk (below it for a pFET)."""
        fet = self.fet[device]
        return np.asarray(fet.kappa * (gate - fet.threshold) / self.u_t)

    def below(self, port: str) -> F64:
        """Bias voltage of a pFET's gate, counted from the supply down, V."""
        return self.v_dd - self.gate[port]

    def saturated(self, device: str, gate: F64 | float) -> F64:
        """Current with the source at the bulk and the drain far, A: `I_S F(v_p / U_T)`."""
        return np.asarray(self.fet[device].current * interpolation(self.pinch(device, gate)))


@dataclass(frozen=True, slots=True)
class Part:
    """A circuit, or an instance array of it, prepared for the draws of its devices.

    lone: the circuit that stands at every place of the array, or `circuit` itself.
    """

    circuit: Circuit
    lone: Circuit
    process: Process
    ports: Mapping[str, str]  # bias port of the part: bias port of the circuit
    transistors: Mapping[str, DeviceGroup]

    @property
    def count(self) -> int:
        """Copies of the part."""
        return int(next(iter(self.transistors.values())).nodes.shape[1])


def interpolation(u: F64) -> F64:
    """`F(u) = ln^2(1 + e^(u/2))`."""
    return np.asarray(np.logaddexp(0.0, 0.5 * u) ** 2)


def inverter_threshold_of(d: DieDevices, inverter: str) -> F64:
    """Input at which both transistors of an inverter, saturated, carry the same current, V."""
    p, m = d.fet[f"{inverter}p"], d.fet[f"{inverter}n"]
    found = np.empty(d.copies)
    inverter_threshold(
        m.current,
        m.threshold / d.u_t,
        m.kappa,
        p.current,
        p.threshold / d.u_t,
        p.kappa,
        d.v_dd / d.u_t,
        found,
    )
    return found * d.u_t


def inverter_lag(d: DieDevices, inverter: str, swing: F64, capacitance: float, speed: F64) -> F64:
    """Time in which an inverter beyond its threshold moves its output by `swing` (V), s.

    `speed` (V/s) of the input makes its current grow from nothing: `C swing = g speed t^2 / 2`.
    """
    threshold = inverter_threshold_of(d, inverter)
    step = 1e-3
    slope = np.zeros(d.copies)
    for device, gate in ((f"{inverter}p", d.v_dd - threshold), (f"{inverter}n", threshold)):
        slope += (d.saturated(device, gate + step) - d.saturated(device, gate - step)) / (2.0 * step)
    return np.asarray(np.sqrt(2.0 * capacitance * np.maximum(swing, 0.0) / (slope * speed)))


def part_of(circuit: Circuit, process: Process, array: str = "") -> Part:
    """Prepare `circuit`, or its instance array called `array`.

    Raises `UnknownNameError` where there is no such array, `ParameterError` for a law other than ekv.
    """
    check_law(process)
    ports = {b.port: b.port for b in circuit.biases}
    lone = circuit
    if array:
        found = [i for i in circuit.instances if i.name == array and isinstance(i, InstanceArray)]
        if not found:
            raise unknown_name(f"{circuit.name} array", array, [i.name for i in circuit.instances])
        ports = {port: node for port, node in found[0].connections.items() if node in ports}
        lone = found[0].circuit
    groups = [g for g in flatten(circuit).groups if not array or (g.path and g.path[0][0] == array)]
    depth = 1 if array else 0
    return Part(
        circuit,
        lone,
        process,
        ports,
        {
            ".".join([*(n for n, _ in g.path[depth:]), g.device.name]): g
            for g in groups
            if isinstance(g.device, Transistor)
        },
    )


def devices_on(part: Part, silicon: Silicon) -> DieDevices:
    """Transistors of all copies of the part on `silicon`, and the voltages of its bias ports there."""
    laws = {polarity: silicon.law(polarity) for polarity in POLARITIES}
    groups = [(name, g, g.device) for name, g in part.transistors.items() if isinstance(g.device, Transistor)]
    width = np.array([g.parameters["multiplicity"] * g.parameters["width"] for _, g, _ in groups])
    length = np.array([g.parameters["length"] for _, g, _ in groups])
    paths = [(*g.path, (device.name, ())) for _, g, device in groups]
    local = silicon.deviations(part.circuit.name, paths, (width * length).ravel())
    v_t0, beta = (np.broadcast_to(x, width.size).reshape(width.shape) for x in local)
    fets = {}
    for k, (name, _, device) in enumerate(groups):
        law = laws[device.polarity]
        current = law.square_current * width[k] / length[k] * (1.0 + beta[k])
        fets[name] = Fet(current, law.v_t0 + v_t0[k], law.kappa)
    biases = {b.port: bias_voltages(part.circuit, b, silicon) for b in part.circuit.biases}
    gates = {port: biases[outer] for port, outer in part.ports.items() if outer in biases}
    return DieDevices(silicon.thermal_voltage, silicon.process.v_dd, part.count, fets, gates)


def capacitance_matrix(part: Part, nodes: Sequence[str]) -> F64:
    """Capacitance matrix of `nodes` of one copy, all other nodes held, float64[nodes, nodes], F."""
    flat = flatten(part.lone)
    number = {flat.node(n): k for k, n in enumerate(nodes)}
    matrix = np.zeros((len(nodes), len(nodes)))
    for group in flat.groups:
        for (a, b), value in _pairs(group, part.process):
            rows = [number.get(int(group.nodes[t, 0])) for t in (a, b)]
            for row, other in (rows, rows[::-1]):
                if row is not None:
                    matrix[row, row] += value
                    if other is not None:
                        matrix[row, other] -= value
    return matrix


def _pairs(group: DeviceGroup, process: Process) -> list[tuple[tuple[int, int], float]]:
    """Capacitances between terminals of a device, F."""
    if isinstance(group.device, Capacitor):
        return [((0, 1), float(group.parameters["capacitance"][0]))]
    if not isinstance(group.device, Transistor):
        return []
    size = (group.parameters[k] for k in ("width", "length", "multiplicity"))
    found = capacitances(process.model(group.device.polarity), *size)
    return [(pair, float(value[0])) for pair, value in found.items()]
