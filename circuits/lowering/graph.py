"""A circuit as a networkx graph: devices on one side, nodes on the other, and an edge for each terminal.

`to_graph` goes down to the devices. `to_instance_graph` stays on the top level, where an instance or an array
of instances is one vertex and its edges are labelled by port. A vertex is a pair `(kind, path)` with the kind
`device`, `instance` or `node`, because a device and a node may have the same path. Both are multigraphs: a
transistor whose gate is tied to its drain has two edges to that node.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import singledispatch
from typing import TYPE_CHECKING, Any

from circuits.catalogue import later
from circuits.circuit import GROUND, Circuit, Instance, InstanceArray, split_reference
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode
from circuits.lowering.flatten import flatten

if TYPE_CHECKING:
    import networkx as nx
else:
    nx = later("networkx")

Vertex = tuple[str, str]


@dataclass(frozen=True, slots=True)
class Description:
    """What a reader knows a device type by: its word, its terminals' names in order, and other attributes."""

    type: str
    terminals: tuple[str, ...]
    attributes: Mapping[str, str] = field(default_factory=dict)


@singledispatch
def describe_device(device: Device) -> Description:
    """Describe a device's type."""
    raise TypeError(f"{type(device).__name__}: no lowering to the graph")


@describe_device.register
def _(device: Transistor) -> Description:
    return Description("transistor", ("drain", "gate", "source", "bulk"), {"polarity": device.polarity})


@describe_device.register
def _(device: Capacitor) -> Description:
    return Description("capacitor", ("a", "b"))


@describe_device.register
def _(device: Resistor) -> Description:
    return Description("resistor", ("a", "b"))


@describe_device.register
def _(device: Diode) -> Description:
    return Description("diode", ("anode", "cathode"))


@describe_device.register
def _(device: ControlledSource) -> Description:
    return Description("controlled source", ("positive", "negative", "control_positive", "control_negative"))


@describe_device.register
def _(device: OperationalAmplifier) -> Description:
    return Description("operational amplifier", ("positive", "negative", "output", "vdd", "vss"))


@describe_device.register
def _(device: Source) -> Description:
    return Description("source", ("node",), {"quantity": device.quantity})


def to_graph(circuit: Circuit) -> nx.MultiGraph:
    """Graph of every device of a circuit and of every node that a device is connected to.

    Returns
    -------
    A multigraph. Every vertex has `bipartite` (0 for a device, 1 for a node), `kind`, `path` and `label` (the
    last name of the path). A device also has `type`, `instance` (path of the instance that it stands in,
    empty at the top), its parameters in SI units and, if it is a transistor, `polarity`. A node also has
    `port` (the port's kind, `ground`, or empty). An edge has `terminal`.
    """
    flat = flatten(circuit)
    names, kinds = flat.node_names(), _port_kinds(circuit)
    graph = nx.MultiGraph(name=circuit.name)
    for group in flat.groups:
        description = describe_device(group.device)
        for k in range(group.nodes.shape[1]):
            path = group.label(k)
            values = {name: float(value[k]) for name, value in group.parameters.items()}
            vertex = _add(graph, "device", path, type=description.type, instance=path.rpartition(".")[0])
            graph.nodes[vertex].update(description.attributes, **values)
            for terminal, node in zip(description.terminals, group.nodes[:, k], strict=True):
                name = names[int(node)]
                port = "" if "." in name else kinds.get(name.partition("[")[0], "")
                graph.add_edge(vertex, _add(graph, "node", name, port=port), terminal=terminal)
    return graph


def to_instance_graph(circuit: Circuit) -> nx.MultiGraph:
    """Graph of a circuit's own devices, instances and nodes, where an array of nodes is one vertex.

    Devices that are alike, and connect elements of the same arrays, are one vertex too, named for the first.

    Returns
    -------
    A multigraph as of `to_graph`. An instance has `type` (the name of its circuit) and `shape`, a node has
    `shape`, and an edge has `terminal`: the terminal of a device or the port of an instance. A device that
    stands for several has `shape`, how many they are.
    """
    kinds, shapes = _port_kinds(circuit), circuit.shapes()
    graph = nx.MultiGraph(name=circuit.name)

    def connect(vertex: Vertex, terminal: str, reference: str) -> None:
        name = reference if reference == GROUND else split_reference(reference)[0]
        node = _add(graph, "node", name, port=kinds.get(name, ""), shape=shapes.get(name, ()))
        graph.add_edge(vertex, node, terminal=terminal)

    for device, count in _alike(circuit):
        description = describe_device(device)
        several = {"shape": (count,)} if count > 1 else {}
        vertex = _add(graph, "device", device.name, type=description.type, instance="", **several)
        graph.nodes[vertex].update(description.attributes, **device.parameters())
        for terminal, reference in zip(description.terminals, device.terminals(), strict=True):
            connect(vertex, terminal, reference)
    for instance in circuit.instances:
        vertex = _add_instance(graph, instance)
        for port, reference in instance.connections.items():
            connect(vertex, port, reference)
    return graph


def _alike(circuit: Circuit) -> list[tuple[Device, int]]:
    """The first of the devices that are alike between the same nodes, arrays among them, and their number."""
    groups: dict[object, list[Device]] = {}
    for device in circuit.devices:
        nodes = [split_reference(node) if node != GROUND else (GROUND, ()) for node in device.terminals()]
        between: object = (
            tuple(name for name, _ in nodes) if any(index for _, index in nodes) else device.name
        )
        kind = describe_device(device)
        sizes = tuple(device.parameters().items())
        alike = (kind.type, tuple(kind.attributes.items()), sizes, between)
        groups.setdefault(alike, []).append(device)
    return [(found[0], len(found)) for found in groups.values()]


def _add_instance(graph: nx.MultiGraph, instance: Instance | InstanceArray) -> Vertex:
    return _add(graph, "instance", instance.name, type=instance.circuit.name, shape=instance.shape)


def _add(graph: nx.MultiGraph, kind: str, path: str, **attributes: Any) -> Vertex:
    vertex = (kind, path)
    side = 1 if kind == "node" else 0
    graph.add_node(vertex, bipartite=side, kind=kind, path=path, label=path.rpartition(".")[2], **attributes)
    return vertex


def _port_kinds(circuit: Circuit) -> dict[str, str]:
    return {GROUND: "ground", **{p.name: p.kind for p in circuit.ports}}
