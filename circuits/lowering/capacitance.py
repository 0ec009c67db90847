"""Capacitances between the nodes of a circuit, of its capacitors and of its transistors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.devices import Capacitor, Transistor
from circuits.devices.transistor import capacitances
from circuits.lowering.flatten import DeviceGroup, flatten
from circuits.silicon.process import Process


def capacitance_matrix(circuit: Circuit, process: Process, nodes: Sequence[str]) -> F64:
    """Capacitance matrix of `nodes` with all other nodes held, float64[nodes, nodes], F."""
    flat = flatten(circuit)
    number = {flat.node(n): k for k, n in enumerate(nodes)}
    matrix = np.zeros((len(nodes), len(nodes)))
    for group in flat.groups:
        for (a, b), value in _pairs(group, process):
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
