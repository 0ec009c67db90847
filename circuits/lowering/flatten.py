"""Circuit -> arrays: nodes are numbered, device arrays stay arrays.

A device of a circuit that stands in instance arrays of shapes S1, S2, ... becomes one group with an
integer array of node numbers; no object is made per instance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from circuits.circuit import GROUND, Circuit, Instance, InstanceArray, Shape, references, split_reference
from circuits.devices.device import Device
from circuits.errors import TopologyError, unknown_name

I64 = NDArray[np.int64]
F64 = NDArray[np.float64]
Path = tuple[tuple[str, Shape], ...]
Overrides = Mapping[str, F64]


class DeviceGroup(NamedTuple):
    """One device of one circuit definition at all places where it stands."""

    device: Device
    path: Path  # ((instance name, shape), ...) from the top
    nodes: I64  # [terminals, count] node numbers
    parameters: dict[str, F64]  # [count] each

    def label(self, k: int) -> str:
        """Instance path of copy `k`, as in `neuron[2].mi5`."""
        return ".".join((*_path_text(self.path, k), self.device.name))


@dataclass(frozen=True, slots=True)
class _Block:
    start: int
    path: Path
    name: str
    shape: Shape


@dataclass(slots=True)
class FlatCircuit:
    """All device groups of a circuit and its node numbering; number 0 is ground."""

    circuit: Circuit
    groups: list[DeviceGroup] = field(default_factory=list)
    ports: dict[str, I64] = field(default_factory=dict)
    blocks: list[_Block] = field(default_factory=list)
    count: int = 1

    def node_name(self, number: int) -> str:
        """Path of a node, as in `neuron[2].vmem` or `spike[3]`."""
        if number == 0:
            return GROUND
        starts = [b.start for b in self.blocks]
        block = self.blocks[int(np.searchsorted(starts, number, side="right")) - 1]
        outer = _size(block.path)
        place, element = divmod(number - block.start, _product(block.shape))
        name = block.name + _index_text(block.shape, element)
        return ".".join((*_path_text(block.path, place), name)) if outer else name

    def node_names(self) -> list[str]:
        """Paths of all nodes by number."""
        return [self.node_name(k) for k in range(self.count)]

    def node(self, path: str) -> int:
        """Number of the node at `path`."""
        names = self.node_names()
        try:
            return names.index(path)
        except ValueError:
            raise unknown_name(f"{self.circuit.name} node", path, names[1:]) from None

    def port_nodes(self, reference: str) -> I64:
        """Numbers of the nodes that a port or an element of it (`spike[3]`) stands for."""
        name, index = split_reference(reference)
        if name not in self.ports:
            raise unknown_name(f"{self.circuit.name} port", name, self.ports)
        try:
            return np.atleast_1d(self.ports[name][index] if index else self.ports[name]).ravel()
        except IndexError:
            raise TopologyError(f"{self.circuit.name}.{reference}: index outside the port's shape") from None


def flatten(circuit: Circuit) -> FlatCircuit:
    """Number the nodes of `circuit` and lay out its devices as arrays."""
    flat = FlatCircuit(circuit)
    ports = {p.name: _allocate(flat, (), p.name, p.shape) for p in circuit.ports}
    flat.ports = ports
    _walk(flat, circuit, (), ports, {})
    return flat


def _walk(flat: FlatCircuit, circuit: Circuit, path: Path, ports: Mapping[str, I64], overrides: Overrides) -> None:
    outer = reduce(lambda s, p: s + p[1], path, ())
    nodes = dict(ports)
    shapes = circuit.shapes()
    for _, reference in references(circuit):
        if reference != GROUND:
            name = split_reference(reference)[0]
            if name not in nodes:
                nodes[name] = _allocate(flat, path, name, shapes.get(name, ()))
    nodes[GROUND] = np.zeros(outer, dtype=np.int64)
    used: set[str] = set()
    for device in circuit.devices:
        rows = [_select(nodes, r, len(outer)).ravel() for r in device.terminals()]
        parameters = {}
        for attribute, value in device.parameters().items():
            key = f"{device.name}.{attribute}"
            used.add(key)
            parameters[attribute] = np.broadcast_to(overrides.get(key, np.float64(value)), outer).ravel().copy()
        flat.groups.append(DeviceGroup(device, path, np.array(rows, dtype=np.int64), parameters))
    for instance in circuit.instances:
        inner = _inner_overrides(instance, overrides, len(outer))
        used |= {f"{instance.name}.{key}" for key in inner}
        places = (*path, (instance.name, instance.shape))
        connected = {p.name: _connect(instance, nodes, p.name, p.shape, outer) for p in instance.circuit.ports}
        _walk(flat, instance.circuit, places, connected, inner)
    unknown = sorted(set(overrides) - used)
    if unknown:
        raise unknown_name(f"{circuit.name} parameter", unknown[0], used)


def _select(nodes: Mapping[str, I64], reference: str, outer: int) -> I64:
    """Node numbers of a reference at every place: [*outer, *shape of the reference]."""
    if reference == GROUND:
        return nodes[GROUND]
    name, index = split_reference(reference)
    return nodes[name][(slice(None),) * outer + index] if index else nodes[name]


def _connect(instance: Instance | InstanceArray, nodes: Mapping[str, I64], port: str, shape: Shape, outer: Shape) -> I64:
    reference = instance.connections[port]
    numbers = _select(nodes, reference, len(outer))
    own = numbers.shape[len(outer) :]
    target = instance.shape + shape
    try:
        wide = numbers.reshape(outer + (1,) * (len(target) - len(own)) + own)
        return np.broadcast_to(wide, outer + target)
    except ValueError:
        raise TopologyError(
            f"{instance.name}.{port}: {reference} of shape {own} does not broadcast to {target}; declare the node with that shape"
        ) from None


def _inner_overrides(instance: Instance | InstanceArray, overrides: Overrides, outer: int) -> dict[str, F64]:
    shape = instance.shape
    inner = {k: np.broadcast_to(np.asarray(v, dtype=np.float64), shape) for k, v in instance.parameters.items()}
    prefix = f"{instance.name}."
    for key, value in overrides.items():
        if key.startswith(prefix):
            inner[key[len(prefix) :]] = value.reshape(value.shape + (1,) * len(shape))
    return inner


def _allocate(flat: FlatCircuit, path: Path, name: str, shape: Shape) -> I64:
    outer = reduce(lambda s, p: s + p[1], path, ())
    size = _product(outer) * _product(shape)
    flat.blocks.append(_Block(flat.count, path, name, shape))
    numbers = np.arange(flat.count, flat.count + size, dtype=np.int64).reshape(outer + shape)
    flat.count += size
    return numbers


def _product(shape: Shape) -> int:
    return int(np.prod(shape, dtype=np.int64)) if shape else 1


def _size(path: Path) -> int:
    return len(path)


def _index_text(shape: Shape, k: int) -> str:
    return "[" + ",".join(str(int(i)) for i in np.unravel_index(k, shape)) + "]" if shape else ""


def _path_text(path: Path, k: int) -> list[str]:
    """Names with indices of place `k` in the row-major product of the path's shapes."""
    shapes = [s for _, s in path]
    outer = reduce(lambda a, b: a + b, shapes, ())
    index = tuple(int(i) for i in np.unravel_index(k, outer)) if outer else ()
    parts, at = [], 0
    for name, shape in path:
        own = index[at : at + len(shape)]
        parts.append(name + ("[" + ",".join(map(str, own)) + "]" if shape else ""))
        at += len(shape)
    return parts
