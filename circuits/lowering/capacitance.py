"""Capacitances between the nodes of a circuit, of its capacitors, its transistors, and its diodes at 0 V."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.devices import Capacitor, Diode, Transistor
from circuits.devices.transistor import capacitances
from circuits.lowering.flatten import DeviceGroup, flatten
from circuits.silicon.process import Process


def capacitance_matrix(circuit: Circuit, process: Process, nodes: Sequence[str]) -> F64:
    """Capacitance matrix of `nodes` with all other nodes held, float64[nodes, nodes], F."""
    flat = flatten(circuit)
    number = np.full(flat.count, -1)
    number[[flat.node(n) for n in nodes]] = np.arange(len(nodes))
    matrix = np.zeros((len(nodes), len(nodes)))
    for group in flat.groups:
        for (a, b), values in _pairs(group, process).items():
            ends = number[group.nodes[[a, b]]]
            for row, other in (ends, ends[::-1]):
                own, both = row >= 0, (row >= 0) & (other >= 0)
                np.add.at(matrix, (row[own], row[own]), values[own])
                np.add.at(matrix, (row[both], other[both]), -values[both])
    return matrix


def added_capacitances(circuit: Circuit, changes: Mapping[str, F64], nodes: Sequence[str]) -> F64:
    """What changes of capacitors add to the capacitance matrix of `nodes`, float64[copies, nodes, nodes], F.

    changes: relative, by the capacitor's name, float64[copies] of as many copies of the circuit.
    """
    flat = flatten(circuit)
    number = {flat.node(n): k for k, n in enumerate(nodes)}
    copies = max((x.size for x in changes.values()), default=0)
    added = np.zeros((copies, len(nodes), len(nodes)))
    for group in flat.groups:
        name = ".".join((*(n for n, _ in group.path), group.device.name))
        if name in changes:
            value = changes[name] * float(group.parameters["capacitance"][0])
            a, b = (number.get(int(node)) for node in group.nodes[:2, 0])
            for row, other in ((a, b), (b, a)):
                if row is not None:
                    added[:, row, row] += value
                    if other is not None:
                        added[:, row, other] -= value
    return added


def node_capacitances(circuit: Circuit, process: Process) -> dict[str, float]:
    """Capacitance (F) between each node and all others together, by node path; 0 where there is none."""
    flat = flatten(circuit)
    total = np.zeros(flat.count)
    for group in flat.groups:
        for pair, value in _pairs(group, process).items():
            ends = group.nodes[list(pair)]
            apart = ends[0] != ends[1]
            for end in ends:
                np.add.at(total, end[apart], value[apart])
    return dict(zip(flat.node_names()[1:], (float(c) for c in total[1:]), strict=True))


def _pairs(group: DeviceGroup, process: Process) -> dict[tuple[int, int], F64]:
    """Capacitances (F, float64[count]) of a group's devices, by pair of terminals."""
    if isinstance(group.device, Capacitor):
        return {(0, 1): group.parameters["capacitance"]}
    if isinstance(group.device, Diode):
        return {(0, 1): group.parameters["area"] * group.parameters["junction_capacitance"]}
    if not isinstance(group.device, Transistor):
        return {}
    size = (group.parameters[k] for k in ("width", "length", "multiplicity"))
    return capacitances(process.model(group.device.polarity), *size)
