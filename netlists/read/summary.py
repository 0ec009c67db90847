"""What a circuit consists of, counted without listing it."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

from circuits.circuit import GROUND, Circuit, references, split_reference
from circuits.lowering.graph import describe_device


@dataclass(frozen=True, slots=True)
class Summary:
    """What a circuit consists of.

    Attributes
    ----------
    circuits : tuple of str
        Names of the circuits inside it, each once.
    devices : dict of str to int
        Number of its devices by type, such as `n transistor`.
    nodes : int
        Number of its nodes, ground left out.
    """

    circuits: tuple[str, ...]
    devices: dict[str, int]
    nodes: int


def summarise(circuit: Circuit) -> Summary:
    """Count devices and nodes of a circuit, those of each instance as often as it stands there."""
    known: dict[int, tuple[Counter[str], int]] = {}
    names: dict[str, None] = {}
    devices, inner = _count(circuit, known, names)
    ports = sum(math.prod(port.shape) for port in circuit.ports)
    return Summary(tuple(names), dict(sorted(devices.items())), inner + ports)


def _count(
    circuit: Circuit, known: dict[int, tuple[Counter[str], int]], names: dict[str, None]
) -> tuple[Counter[str], int]:
    """Devices by type, and nodes that are no ports."""
    if id(circuit) not in known:
        names[circuit.name] = None
        devices: Counter[str] = Counter()
        for device in circuit.devices:
            description = describe_device(device)
            devices[" ".join((*description.attributes.values(), description.type))] += 1
        shapes, ports = circuit.shapes(), {p.name for p in circuit.ports}
        used = {split_reference(r)[0] for _, r in references(circuit) if r != GROUND} - ports
        nodes = sum(math.prod(shapes.get(name, ())) for name in used)
        for instance in circuit.instances:
            times = math.prod(instance.shape)
            inner, inner_nodes = _count(instance.circuit, known, names)
            nodes += times * inner_nodes
            devices.update({kind: times * n for kind, n in inner.items()})
        known[id(circuit)] = devices, nodes
    return known[id(circuit)]
