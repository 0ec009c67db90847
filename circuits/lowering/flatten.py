"""A circuit with all its instances laid out as arrays: numbered nodes, and devices in groups.

A device of a circuit that stands in arrays of instances of shapes S1, S2, ... becomes one group, with an
integer array of node numbers. No object is made for each instance, so that a chip of many thousand cells is
flattened as quickly as a cell.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.circuit import GROUND, Circuit, Instance, InstanceArray, Shape, references, split_reference
from circuits.devices.device import Device
from circuits.errors import ParameterError, TopologyError, unknown_name

Path = tuple[tuple[str, Shape], ...]
Overrides = Mapping[str, F64]


class DeviceGroup(NamedTuple):
    """One device of one circuit, at all the places where it stands."""

    device: Device
    path: Path  # ((instance name, shape), ...) from the top
    nodes: I64  # [terminals, count] node numbers
    parameters: dict[str, F64]  # [count] each

    def label(self, k: int) -> str:
        """Instance path of copy `k`, such as `neuron[2].mi5`."""
        return ".".join((*_path_text(self.path, k), self.device.name))


@dataclass(frozen=True, slots=True)
class _Block:
    start: int
    path: Path
    name: str
    shape: Shape


@dataclass(slots=True)
class FlatCircuit:
    """All groups of devices of a circuit, and the numbers of its nodes; ground has the number 0."""

    circuit: Circuit
    groups: list[DeviceGroup] = field(default_factory=list)
    ports: dict[str, I64] = field(default_factory=dict)
    blocks: list[_Block] = field(default_factory=list)
    block_of: dict[tuple[str, ...], _Block] = field(default_factory=dict)  # by the names in a node's path
    count: int = 1

    def labels(self, kind: type[Device]) -> list[str]:
        """Instance paths of all devices of a type, in the order in which the solver's kernel has them."""
        groups = (g for g in self.groups if isinstance(g.device, kind))
        return [g.label(k) for g in groups for k in range(g.nodes.shape[1])]

    def node_name(self, number: int) -> str:
        """Path of the node with a number, such as `neuron[2].vmem` or `spike[3]`."""
        if number == 0:
            return GROUND
        block = self.blocks[bisect_right(self.blocks, number, key=lambda b: b.start) - 1]
        return ".".join(_path_text((*block.path, (block.name, block.shape)), number - block.start))

    def node_names(self) -> list[str]:
        """Paths of all nodes in the order of their numbers."""
        names = [GROUND]
        for block in self.blocks:
            parts = [_element_names(*part) for part in (*block.path, (block.name, block.shape))]
            names += map(".".join, itertools.product(*parts))
        return names

    def node(self, path: str) -> int:
        """Number of the node at `path`; raises `UnknownNameError` where there is none."""
        if path == GROUND:
            return 0
        parts = [split_reference(part) for part in path.split(".")]
        block = self.block_of.get(tuple(name for name, _ in parts))
        if block is None:
            known = (".".join(names) for names in self.block_of)
            raise unknown_name(f"{self.circuit.name} node", path, known)
        number = block.start
        shapes = [shape for _, shape in (*block.path, (block.name, block.shape))]
        for (_, index), shape in zip(parts, shapes, strict=True):
            if len(index) != len(shape) or any(i >= n for i, n in zip(index, shape, strict=True)):
                raise unknown_name(f"{self.circuit.name} node", path, [f"indices within {shape}"])
        sizes = [n for shape in shapes for n in shape]
        offset = 0
        for i, n in zip((i for _, index in parts for i in index), sizes, strict=True):
            offset = offset * n + i
        return number + offset

    def port_nodes(self, reference: str) -> I64:
        """Numbers of the nodes of a port, or of one element of it such as `spike[3]`."""
        name, index = split_reference(reference)
        if name not in self.ports:
            raise unknown_name(f"{self.circuit.name} port", name, self.ports)
        try:
            return np.atleast_1d(self.ports[name][index] if index else self.ports[name]).ravel()
        except IndexError:
            raise TopologyError(f"{self.circuit.name}.{reference}: index outside the port's shape") from None

    def watched_nodes(self, reference: str) -> I64:
        """Numbers of the nodes of a port, as `port_nodes`, or of the one inner node at a path."""
        if reference.partition("[")[0] in self.ports:
            return self.port_nodes(reference)
        return np.array([self.node(reference)], dtype=np.int64)


def flatten(circuit: Circuit) -> FlatCircuit:
    """Number the nodes of a circuit and lay out its devices as arrays."""
    flat = FlatCircuit(circuit)
    ports = {p.name: _allocate(flat, (), p.name, p.shape) for p in circuit.ports}
    flat.ports = ports
    _walk(flat, circuit, (), ports, {})
    return flat


def _walk(
    flat: FlatCircuit, circuit: Circuit, path: Path, ports: Mapping[str, I64], overrides: Overrides
) -> None:
    outer = _joined(path)
    size = math.prod(outer)
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
            if key in overrides:
                parameters[attribute] = np.broadcast_to(overrides[key], outer).astype(np.float64).ravel()
            else:
                parameters[attribute] = np.full(size, value, dtype=np.float64)
        group = DeviceGroup(device, path, np.array(rows, dtype=np.int64), parameters)
        _check_overrides(group, [a for a in parameters if f"{device.name}.{a}" in overrides])
        flat.groups.append(group)
    for instance in circuit.instances:
        inner = _inner_overrides(instance, overrides, len(outer))
        used |= {f"{instance.name}.{key}" for key in inner}
        places = (*path, (instance.name, instance.shape))
        connected = {
            p.name: _connect(instance, nodes, p.name, p.shape, outer) for p in instance.circuit.ports
        }
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


def _connect(
    instance: Instance | InstanceArray, nodes: Mapping[str, I64], port: str, shape: Shape, outer: Shape
) -> I64:
    reference = instance.connections[port]
    numbers = _select(nodes, reference, len(outer))
    own = numbers.shape[len(outer) :]
    target = instance.shape + shape
    if target == own:
        return numbers
    try:
        wide = numbers.reshape(outer + (1,) * (len(target) - len(own)) + own)
        return np.broadcast_to(wide, outer + target)
    except ValueError:
        raise TopologyError(
            f"{instance.name}.{port}: {reference} of shape {own} does not broadcast to {target};"
            " declare the node with that shape"
        ) from None


def _inner_overrides(instance: Instance | InstanceArray, overrides: Overrides, outer: int) -> dict[str, F64]:
    shape = instance.shape
    inner: dict[str, F64] = {}
    for key, given in instance.parameters.items():
        numbers = np.asarray(given, dtype=np.float64)
        try:
            inner[key] = np.broadcast_to(numbers, shape)
        except ValueError:
            raise ParameterError(
                f"{instance.name}.{key}: values of shape {numbers.shape}, must broadcast to {shape};"
                " give one number, or one an instance"
            ) from None
    prefix = f"{instance.name}."
    for key, value in overrides.items():
        if key.startswith(prefix):
            inner[key[len(prefix) :]] = value.reshape(value.shape + (1,) * len(shape))
    return inner


def _allocate(flat: FlatCircuit, path: Path, name: str, shape: Shape) -> I64:
    outer = _joined(path)
    size = math.prod(outer + shape)
    block = _Block(flat.count, path, name, shape)
    flat.blocks.append(block)
    flat.block_of[(*(part for part, _ in path), name)] = block
    numbers = np.arange(flat.count, flat.count + size, dtype=np.int64).reshape(outer + shape)
    flat.count += size
    return numbers


def _check_overrides(group: DeviceGroup, attributes: list[str]) -> None:
    """Apply the device's own rules to the extreme values that instances gave it."""
    for attribute in attributes:
        values = group.parameters[attribute]
        finite = np.where(np.isfinite(values), values, -np.inf)
        for k in (int(np.argmin(finite)), int(np.argmax(values))):
            changed: Any = {attribute: float(values[k])}
            try:
                replace(group.device, **changed).check()
            except ParameterError as error:
                raise ParameterError(".".join((*_path_text(group.path, k), str(error)))) from None


def _joined(path: Path) -> Shape:
    """Shapes of a path one after the other."""
    return tuple(n for _, shape in path for n in shape)


def _element_names(name: str, shape: Shape) -> list[str]:
    """Names of an array's elements in row-major order; a scalar has its own."""
    if not shape:
        return [name]
    return [f"{name}[{','.join(i)}]" for i in itertools.product(*(map(str, range(n)) for n in shape))]


def _path_text(path: Path, k: int) -> list[str]:
    """Names with indices of place `k` in the row-major product of the path's shapes."""
    parts = []
    for name, shape in reversed(path):
        index = []
        for n in reversed(shape):
            k, i = divmod(k, n)
            index.append(str(i))
        parts.append(f"{name}[{','.join(reversed(index))}]" if shape else name)
    return parts[::-1]
