"""A testbench as the definitions, calls and sources of a netlist, in the order in which it lists them.

No dialect's text is in it. Every circuit becomes one definition for each distinct content: an instance whose
parameters or transistors differ gets its own definition, and two circuits of equal content share one. So the
nominal die has one definition for each circuit, and every other die one for each instance. Arrays become one
call for each element. Values are literal, because a definition has no parameters. Names are ours
(`v_mem[3]`); a dialect turns them into its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from circuits.arrays import F64, I64
from circuits.circuit import GROUND, Circuit, Instance, InstanceArray, Shape, references, split_reference
from circuits.devices import Capacitor, Transistor
from circuits.devices.device import Device
from circuits.devices.source import Source
from circuits.errors import TopologyError
from circuits.lowering.flatten import FlatCircuit, flatten
from circuits.lowering.kernel import complete_sources
from circuits.lowering.made import change_of, kind_of
from circuits.silicon.passive import QUANTITY
from circuits.silicon.silicon import NO_DEVIATION, Change, Deviation, Silicon
from circuits.testbench import Testbench
from netlists.naming import element
from netlists.write.annotation import circuit_notes, format_annotation, instance_notes

Overrides = Mapping[str, F64]
Names = tuple[str, ...]
References = NDArray[np.object_]


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a definition.

    Attributes
    ----------
    name, index
        Name of the instance, and its index in an array; () for a lone one.
    definition
        Name of the definition that is called.
    nodes
        Nodes of the calling circuit, in the order of the definition's ports.
    """

    name: str
    index: Shape
    definition: str
    nodes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Definition:
    """A circuit with literal values.

    Attributes
    ----------
    name
        Its name, which no other definition has.
    circuit
        What it was made of, before parameters of instances above replaced values.
    ports
        Scalar ports: a port that is an array is listed element by element.
    devices
        Devices as they are drawn, each with what the die changes of it; `as_made` has it as it is made.
    calls
        Calls of other definitions, grouped by instance in the circuit's order.
    parasitics
        Capacitances to ground from a layout, which are no part of the circuit.
    """

    name: str
    circuit: Circuit
    ports: tuple[str, ...]
    devices: tuple[tuple[Device, Deviation | Change], ...]
    calls: tuple[tuple[Call, ...], ...]
    parasitics: tuple[Capacitor, ...] = ()


@dataclass(frozen=True, slots=True)
class Drive:
    """A source of a testbench.

    Attributes
    ----------
    source
        The source, which may drive a port that is an array.
    elements
        What it comes to, one source a node.
    biased
        Whether one of the circuit's biases made it.
    """

    source: Source
    elements: tuple[Source, ...]
    biased: bool


@dataclass(frozen=True, slots=True)
class Design:
    """What a netlist of a testbench contains.

    definitions: each before its first use; the last is the testbench's circuit. drives: the
    testbench's sources and, after them, those of its circuit's biases. nodes: paths of all nodes but ground,
    in the solver's order.
    """

    definitions: tuple[Definition, ...]
    drives: tuple[Drive, ...]
    nodes: tuple[str, ...]

    @property
    def top(self) -> Definition:
        """The testbench's circuit."""
        return self.definitions[-1]

    @property
    def sources(self) -> tuple[Source, ...]:
        """All sources, each of one node."""
        return tuple(element for drive in self.drives for element in drive.elements)


def to_design(
    testbench: Testbench, silicon: Silicon, parasitics: Mapping[str, float] = MappingProxyType({})
) -> Design:
    """Resolve `testbench` on `silicon` into definitions and sources.

    `parasitics`: capacitances to ground (F) by node path.

    Raises
    ------
    TopologyError
        Two nodes of a circuit, or two sources, whose names differ in case only.
    ParameterError
        An array's parameter that breaks its device's rule.
    UnknownNameError
        An array's parameter that no device has, or a parasitic capacitance at no node.
    """
    flat = flatten(testbench.circuit)
    walk = _Walk(_deviations(flat, silicon), _parasitics(flat, parasitics))
    walk.visit(testbench.circuit, (), {}, 1)
    given = len(testbench.sources)
    drives = tuple(
        Drive(source, tuple(_elements(source, testbench.circuit)), k >= given)
        for k, source in enumerate(complete_sources(testbench, flat, silicon))
    )
    design = Design(tuple(walk.definitions), drives, tuple(flat.node_names()[1:]))
    _require_distinct(testbench.title, "source", [s.name for s in design.sources])
    return design


def split_path(path: str) -> tuple[tuple[str, Shape], ...]:
    """Split `neuron[2].spike[3]` into `(("neuron", (2,)), ("spike", (3,)))`."""
    return tuple(split_reference(part) for part in path.split("."))


class Load(NamedTuple):
    """A capacitance to ground (F) at a node of a circuit."""

    node: str
    capacitance: float


class _Part(NamedTuple):
    """An instance of a circuit: nodes of each of its elements, and the definitions of all its copies."""

    instance: Instance | InstanceArray
    nodes: list[Names]
    definition: I64  # [places, elements]


@dataclass(slots=True)
class _Walk:
    """Definitions met so far, and the way to them from a content.

    A circuit lives as long as the testbench that is walked, so that its id stands for it.
    """

    deviations: Mapping[Names, Deviation | Change]  # of all copies of a device; empty for the nominal die
    parasitics: Mapping[Names, Mapping[int, tuple[Load, ...]]]  # by path, then place
    definitions: list[Definition] = field(default_factory=list)
    plain: dict[int, int] = field(default_factory=dict)  # by circuit, without overrides and deviations
    contents: dict[tuple[Any, ...], int] = field(default_factory=dict)
    outsides: dict[int, tuple[str, ...]] = field(default_factory=dict)
    nodes: dict[tuple[int, str], list[Names]] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)
    numbers: dict[str, int] = field(default_factory=dict)  # last number given to a name

    def visit(self, circuit: Circuit, path: Names, overrides: Overrides, places: int) -> I64:
        """Number of the definition of `circuit` at each of the places of `path`; children come first.

        `overrides` have a value a place, float64[places]. Places are counted as the devices' arrays are.
        """
        if not overrides and not self.deviations and not self.parasitics:
            if id(circuit) not in self.plain:
                self.plain[id(circuit)] = int(self._visit(circuit, path, overrides, 1)[0])
            return np.full(places, self.plain[id(circuit)])
        return self._visit(circuit, path, overrides, places)

    def _visit(self, circuit: Circuit, path: Names, overrides: Overrides, places: int) -> I64:
        parts = [self._part(circuit, i, path, overrides, places) for i in circuit.instances]
        changes = [_changes(d, overrides) for d in circuit.devices]
        shifts = [self.deviations.get((*path, d.name), NO_DEVIATION) for d in circuit.devices]
        loads = self.parasitics.get(path, {})
        columns = [
            _numbered(loads, places),
            *(v for change in changes for v in change.values()),
            *(np.broadcast_to(x, places) for shift in shifts for x in shift if np.ndim(x)),
            *(column for part in parts for column in part.definition.T),
        ]
        first, inverse = _distinct_rows(columns, places)
        found = np.empty(first.size, dtype=np.int64)
        for k, place in enumerate(first.tolist()):
            devices = tuple(
                (_changed(device, change, place), _at(shift, place))
                for device, change, shift in zip(circuit.devices, changes, shifts, strict=True)
            )
            calls = tuple(self._calls(part, place) for part in parts)
            found[k] = self._define(circuit, devices, calls, _capacitors(circuit, loads.get(place, ())))
        return found[inverse]

    def _part(
        self,
        circuit: Circuit,
        instance: Instance | InstanceArray,
        path: Names,
        overrides: Overrides,
        places: int,
    ) -> _Part:
        shape, count = instance.shape, math.prod(instance.shape)
        inner = {
            k: np.tile(np.broadcast_to(np.asarray(v, np.float64), shape).ravel(), places)
            for k, v in instance.parameters.items()
        }
        prefix = f"{instance.name}."
        for key, value in overrides.items():
            if key.startswith(prefix):
                inner[key.removeprefix(prefix)] = np.repeat(value, count)
        below = self.visit(instance.circuit, (*path, instance.name), inner, places * count)
        return _Part(instance, self._nodes(circuit, instance), below.reshape(places, count))

    def _nodes(self, circuit: Circuit, instance: Instance | InstanceArray) -> list[Names]:
        key = (id(circuit), instance.name)
        if key not in self.nodes:
            self.nodes[key] = _connected(circuit, instance)
        return self.nodes[key]

    def _calls(self, part: _Part, place: int) -> tuple[Call, ...]:
        name = part.instance.name
        rows = zip(np.ndindex(part.instance.shape), part.definition[place].tolist(), part.nodes, strict=True)
        return tuple(Call(name, index, self.definitions[k].name, nodes) for index, k, nodes in rows)

    def _define(
        self,
        circuit: Circuit,
        devices: tuple[tuple[Device, Deviation | Change], ...],
        calls: tuple[tuple[Call, ...], ...],
        parasitics: tuple[Capacitor, ...],
    ) -> int:
        content = (self._outside(circuit), devices, calls, parasitics)
        if content not in self.contents:
            self.contents[content] = len(self.definitions)
            ports = tuple(element(p.name, index) for p in circuit.ports for index in np.ndindex(p.shape))
            name = self._free_name(circuit.name)
            self.definitions.append(Definition(name, circuit, ports, devices, calls, parasitics))
        return self.contents[content]

    def _outside(self, circuit: Circuit) -> tuple[str, ...]:
        """What tells circuits apart beside devices and calls, as text."""
        if id(circuit) not in self.outsides:
            used = [split_reference(r)[0] for _, r in references(circuit) if r != GROUND]
            _require_distinct(circuit.name, "node", list(dict.fromkeys([*circuit.shapes(), *used])))
            notes = [*circuit_notes(circuit), *(n for i in circuit.instances for n in instance_notes(i))]
            self.outsides[id(circuit)] = tuple(line for note in notes for line in format_annotation(note))
        return self.outsides[id(circuit)]

    def _free_name(self, wanted: str) -> str:
        """`wanted`, or `wanted_2`, `wanted_3`, ... where it is taken; case does not count."""
        name, number = wanted, self.numbers.get(wanted.lower(), 1)
        while name.lower() in self.names:
            number += 1
            name = f"{wanted}_{number}"
        self.names.add(name.lower())
        self.numbers[wanted.lower()] = number
        return name


def _distinct_rows(columns: list[NDArray[Any]], places: int) -> tuple[I64, I64]:
    """First place of each distinct row, in the order of places, and the number of each place's row."""
    if places == 1 or all((c == c[0]).all() for c in columns):
        return np.zeros(1, np.int64), np.zeros(places, np.int64)
    # numbers of definitions are exact as float64
    rows = np.stack([np.asarray(c, np.float64) for c in columns], axis=1)
    _, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(order.size)
    return first[order], rank[inverse.ravel()]


def _changes(device: Device, overrides: Overrides) -> dict[str, F64]:
    """Values of a device's parameters that its place sets, float64[places]."""
    names = ((attribute, f"{device.name}.{attribute}") for attribute in device.parameters())
    return {attribute: overrides[key] for attribute, key in names if key in overrides}


def _changed(device: Device, change: Mapping[str, F64], place: int) -> Device:
    """`device` with the parameters of its place; numbering the nodes has checked names and values."""
    if not change:
        return device
    frozen: Any = device
    changed: Device = replace(frozen, **{attribute: float(v[place]) for attribute, v in change.items()})
    return changed


def _at(shift: Deviation | Change, place: int) -> Deviation | Change:
    if shift is NO_DEVIATION:
        return shift
    return type(shift)(*(float(x[place]) if isinstance(x, np.ndarray) else x for x in shift))


def _connected(circuit: Circuit, instance: Instance | InstanceArray) -> list[Names]:
    """Nodes of the circuit at the ports of each element of an instance, row-major."""
    shapes, shape, ports = circuit.shapes(), instance.shape, instance.circuit.ports
    nodes = [_broadcast(instance.connections[p.name], shapes, shape, p.shape) for p in ports]
    count = math.prod(shape)
    columns = [n.reshape(count, -1) for n in nodes]
    rows = np.concatenate(columns, axis=1).tolist() if columns else [[] for _ in range(count)]
    return [tuple(row) for row in rows]


def _parasitics(
    flat: FlatCircuit, parasitics: Mapping[str, float]
) -> dict[Names, dict[int, tuple[Load, ...]]]:
    """Capacitances by the names on the path of their circuit, then by the number of its place."""
    found: dict[Names, dict[int, tuple[Load, ...]]] = {}
    for path, capacitance in parasitics.items():
        flat.node(path)
        *instances, (node, index) = split_path(path)
        names = tuple(name for name, _ in instances)
        place, circuit = 0, flat.circuit
        for name, at in instances:
            instance = next(i for i in circuit.instances if i.name == name)
            own = int(np.ravel_multi_index(at, instance.shape)) if at else 0
            place, circuit = place * math.prod(instance.shape) + own, instance.circuit
        places = found.setdefault(names, {})
        places[place] = (*places.get(place, ()), Load(element(node, index), capacitance))
    return found


def _numbered(loads: Mapping[int, tuple[Load, ...]], places: int) -> F64:
    """A number a place, the same where the loads are the same."""
    numbers: dict[tuple[Load, ...], int] = {(): 0}
    column = np.zeros(places)
    for place, own in loads.items():
        column[place] = numbers.setdefault(own, len(numbers))
    return column


def _capacitors(circuit: Circuit, loads: tuple[Load, ...]) -> tuple[Capacitor, ...]:
    prefix = "parasitic"
    while any(d.name.lower().startswith(prefix) for d in circuit.devices):
        prefix += "_"
    # a layout has wires of less than an attofarad
    return tuple(
        Capacitor(f"{prefix}{k}", n, GROUND, c, allow_implausible=True) for k, (n, c) in enumerate(loads)
    )


def _deviations(flat: FlatCircuit, silicon: Silicon) -> dict[Names, Deviation | Change]:
    """Deviations of all copies of each device, by the names on its path; empty for the nominal die."""
    found: dict[Names, Deviation | Change] = {}
    circuit = flat.circuit.name
    for group in flat.groups if silicon.die.deviates else ():
        device, kind = group.device, kind_of(group.device)
        path = (*group.path, (device.name, ()))
        names = tuple(name for name, _ in path)
        if isinstance(device, Transistor):
            size = group.parameters
            area = size["width"] * size["length"] * size["multiplicity"]
            found[names] = silicon.deviation(circuit, path, area, device.polarity)
        elif kind is not None:
            change = change_of(group, kind, circuit, silicon)
            found |= {names: change} if np.ndim(change.value) else {}
    return found


def as_made(device: Device, deviation: Deviation | Change) -> tuple[Device, Deviation]:
    """A device as it is made on a die, and what its line has to say of it beside that.

    A capacitor, resistor or diode has the value that the die gives it, a transistor its deviation.
    """
    if isinstance(deviation, Deviation):
        return device, deviation
    quantity = QUANTITY[kind_of(device) or "capacitor"]
    value = device.parameters()[quantity] * (1.0 + float(deviation.value))
    frozen: Any = device
    made: Device = replace(frozen, **{quantity: value})
    return made, NO_DEVIATION


def _broadcast(reference: str, shapes: Mapping[str, Shape], outer: Shape, port: Shape) -> References:
    """References of a connection at every element: object[*outer, *port]."""
    name, index = (reference, ()) if reference == GROUND else split_reference(reference)
    own = () if index else shapes.get(name, ())
    names = np.empty(own, dtype=object)
    for k in np.ndindex(own):
        names[k] = element(name, k or index)
    target = outer + port
    return np.broadcast_to(names.reshape((1,) * (len(target) - len(own)) + own), target)


def _elements(source: Source, circuit: Circuit) -> Iterator[Source]:
    """One source a node: a source of an array port drives each of its elements."""
    name, index = split_reference(source.node)
    shape = () if index else circuit.port(name).shape
    for k in np.ndindex(shape):
        yield replace(source, name=element(source.name, k), node=element(name, k or index))


def _require_distinct(owner: str, kind: str, names: list[str]) -> None:
    seen: dict[str, str] = {}
    for name in names:
        if name.lower() in seen:
            other = seen[name.lower()]
            raise TopologyError(
                f"{owner}.{name}: {kind} {other} has that name too (case does not count); rename one"
            )
        seen[name.lower()] = name
