"""Two circuits flattened side by side, the form in which `netlists.compare.refinement` takes them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from circuits.arrays import U64, Bools
from circuits.circuit import Circuit, split_reference
from circuits.errors import ParameterError
from circuits.lowering.flatten import FlatCircuit, flatten
from circuits.lowering.graph import describe_device
from circuits.lowering.made import kind_of
from circuits.silicon.passive import QUANTITY
from circuits.silicon.silicon import Change, Deviation
from netlists.compare.refinement import Colours, Sides, Structure, label, labels, sides
from netlists.read.text.name import original_name

_MOST_DEVICES = 2_000_000
_BIT = re.compile(r"[\[<]([0-9]+)[\]>]")  # of a bus, as other tools write it

Deviations = Mapping[str, Deviation | Change]


@dataclass(frozen=True, slots=True)
class FlatDevice:
    """A device of a flat circuit.

    Attributes
    ----------
    path, kind
        Its instance path, and its type with what tells it from others of that type, as the polarity.
    sides
        Its sides with their terminals; sides of one name may be swapped.
    terminals, nodes
        Names of its terminals and the nodes at them, numbered over both circuits.
    sizes
        Its parameters and deviations by name, SI units.
    """

    path: str
    kind: str
    sides: Sides
    terminals: tuple[str, ...]
    nodes: tuple[int, ...]
    sizes: tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True)
class Pair:
    """Both circuits: devices and nodes of the first, then those of the second from `devices_a`, `nodes_a`."""

    devices: list[FlatDevice]
    node_names: list[str]
    ports: tuple[dict[str, int], dict[str, int]]
    devices_a: int
    nodes_a: int
    structure: Structure
    used: Bools  # nodes that have a terminal or are ports

    def parted(self, values: U64, owner: Literal["device", "node"]) -> tuple[U64, U64]:
        """Values of devices or nodes parted by circuit, unused nodes left out."""
        if owner == "device":
            return values[: self.devices_a], values[self.devices_a :]
        used, n = self.used, self.nodes_a
        return values[:n][used[:n]], values[n:][used[n:]]

    def agree(self, colours: Colours) -> bool:
        """Whether both circuits have every colour equally often."""
        pairs = self.parted(colours.device, "device"), self.parted(colours.node, "node")
        return all(a.size == b.size and bool((np.sort(a) == np.sort(b)).all()) for a, b in pairs)


def count_devices(circuit: Circuit) -> int:
    """Devices of a circuit, those of its instances counted, without listing them."""
    return _count(circuit, {})


def _count(circuit: Circuit, known: dict[int, int]) -> int:
    if id(circuit) not in known:
        inside = sum(math.prod(i.shape) * _count(i.circuit, known) for i in circuit.instances)
        known[id(circuit)] = len(circuit.devices) + inside
    return known[id(circuit)]


def pair_of(a: Circuit, b: Circuit, deviations: tuple[Deviations, Deviations]) -> Pair:
    """Flatten two circuits; raises `ParameterError` for one of more than `_MOST_DEVICES` devices."""
    devices: list[FlatDevice] = []
    names: list[str] = []
    ports: list[dict[str, int]] = []
    starts = [(0, 0)]
    for circuit, own in zip((a, b), deviations, strict=True):
        count = count_devices(circuit)
        if count > _MOST_DEVICES:
            raise ParameterError(f"{circuit.name}: {count} devices, at most {_MOST_DEVICES} can be compared")
        flat, first = flatten(circuit), len(names)
        devices += _devices(flat, own, first)
        references = [r for p in circuit.ports for r in p.elements()]
        ports.append({_port_key(r): first + int(flat.port_nodes(r)[0]) for r in references})
        names += flat.node_names()
        starts.append((len(devices), len(names)))
    (_, _), (devices_a, nodes_a), _ = starts
    structure = _structure(devices, len(names), ports, nodes_a)
    used = np.zeros(len(names), dtype=np.bool_)
    used[structure.terminal_node] = True
    used[[0, nodes_a, *(n for side in ports for n in side.values())]] = True
    return Pair(devices, names, (ports[0], ports[1]), devices_a, nodes_a, structure, used)


def _devices(flat: FlatCircuit, deviations: Deviations, first: int) -> Iterator[FlatDevice]:
    for group in flat.groups:
        description = describe_device(group.device)
        kind = " ".join((*description.attributes.values(), description.type))
        own, passive = sides(group.device), kind_of(group.device)
        changed = "" if passive is None else QUANTITY[passive]
        columns = [[(name, float(v)) for v in values] for name, values in group.parameters.items()]
        rows = list(zip(*columns, strict=True)) if columns else [()] * group.nodes.shape[1]
        for k, nodes in enumerate((group.nodes + first).T.tolist()):
            path, sizes = group.label(k), rows[k]
            found = deviations.get(path)
            if isinstance(found, Change):
                # as it is made, which a netlist without notes has alone
                made = 1.0 + float(found.value)
                sizes = tuple((name, v * made if name == changed else v) for name, v in sizes)
            elif found is not None:
                sizes = (
                    *sizes,
                    ("deviation of V_T0", float(found.v_t0)),
                    ("deviation of beta", float(found.beta)),
                )
            yield FlatDevice(path, kind, own, description.terminals, tuple(nodes), sizes)


def _port_key(reference: str) -> str:
    """`spike[3]`, `spike#3` and what a reader made of the latter are one port."""
    name, index = split_reference(reference)
    own = _BIT.sub(r"#\1", original_name(name.lower()))
    return "#".join((own.rstrip("#"), *map(str, index)))


def _structure(
    devices: Sequence[FlatDevice], nodes: int, ports: Sequence[Mapping[str, int]], ground: int
) -> Structure:
    side_device: list[int] = []
    side_label: list[int] = []
    terminal_side: list[int] = []
    terminal_node: list[int] = []
    terminal_role: list[int] = []
    for k, device in enumerate(devices):
        for side, terminals in device.sides:
            for role, position in terminals:
                terminal_side.append(len(side_device))
                terminal_node.append(device.nodes[position])
                terminal_role.append(label(role))
            side_device.append(k)
            side_label.append(label(side))
    node_label = np.full(nodes, label("node"), dtype=np.uint64)
    for side_ports in ports:
        for key, node in side_ports.items():
            node_label[node] = label(f"port {key}")
    node_label[[0, ground]] = label("ground")
    return Structure(
        np.array(terminal_side, dtype=np.int64),
        np.array(terminal_node, dtype=np.int64),
        np.array(terminal_role, dtype=np.uint64),
        np.array(side_device, dtype=np.int64),
        np.array(side_label, dtype=np.uint64),
        labels(device.kind for device in devices),
        node_label,
    )
