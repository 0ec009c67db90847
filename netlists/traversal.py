"""Testbench -> definitions, calls and sources in the order in which a netlist lists them; no dialect's text.

Every circuit becomes one definition for each distinct content: an instance whose parameters or transistors
differ gets its own definition, and two circuits of equal content share one. So the nominal die has one
definition a circuit, and every other die one an instance. Arrays become one call an element. Values are
literal: a definition has no parameters. Names are ours (`v_mem[3]`); a dialect turns them into its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circuits.circuit import GROUND, Circuit, Instance, InstanceArray, Shape, references, split_reference
from circuits.devices import Transistor
from circuits.devices.device import Device
from circuits.devices.source import Source
from circuits.errors import TopologyError
from circuits.lowering.flatten import FlatCircuit, flatten
from circuits.lowering.kernel import complete_sources
from circuits.silicon import Deviation, Silicon
from circuits.testbench import Testbench

Overrides = Mapping[str, float]
Names = tuple[str, ...]
References = NDArray[np.object_]

_NONE = Deviation(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Call:
    """An instance of a definition: `nodes` of the caller in the order of the definition's ports."""

    name: str
    index: Shape
    definition: str
    nodes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Definition:
    """A circuit with literal values. `ports` are scalar: an array port is listed element by element.

    `devices` stand with what their place on the die adds to them: nothing but for transistors of a die.
    """

    name: str
    ports: tuple[str, ...]
    devices: tuple[tuple[Device, Deviation], ...]
    calls: tuple[Call, ...]


@dataclass(frozen=True, slots=True)
class Design:
    """What a netlist of a testbench contains.

    `definitions` stand before their first use; the last is the testbench's circuit. `sources` drive one node
    each, the circuit's biases included. `nodes`: paths of all nodes but ground, in the solver's order.
    """

    definitions: tuple[Definition, ...]
    sources: tuple[Source, ...]
    nodes: tuple[str, ...]

    @property
    def top(self) -> Definition:
        """The testbench's circuit."""
        return self.definitions[-1]


def to_design(testbench: Testbench, silicon: Silicon) -> Design:
    """Resolve `testbench` on `silicon` into definitions and sources.

    Raises
    ------
    TopologyError
        Two nodes of a circuit, or two sources, whose names differ in case only.
    ParameterError
        An array's parameter that breaks its device's rule.
    UnknownNameError
        An array's parameter that no device has.
    """
    flat = flatten(testbench.circuit)
    walk = _Walk(_deviations(flat, silicon))
    walk.visit(testbench.circuit, {}, (), 0)
    sources = tuple(
        element
        for source in complete_sources(testbench, flat, silicon)
        for element in _elements(source, testbench.circuit)
    )
    _require_distinct(testbench.title, "source", [s.name for s in sources])
    return Design(tuple(walk.definitions), sources, tuple(flat.node_names()[1:]))


def split_path(path: str) -> tuple[tuple[str, Shape], ...]:
    """Split `neuron[2].spike[3]` into `(("neuron", (2,)), ("spike", (3,)))`."""
    return tuple(split_reference(part) for part in path.split("."))


def element(name: str, index: Shape) -> str:
    """Reference to one element of an array, `spike[3]`; the name alone for an index ()."""
    return f"{name}[{','.join(map(str, index))}]" if index else name


@dataclass(slots=True)
class _Walk:
    """Definitions met so far, and the way to them from a circuit at its place and from a content."""

    deviations: Mapping[Names, Deviation]  # of all copies of a device; empty for the nominal die
    definitions: list[Definition] = field(default_factory=list)
    visited: dict[tuple[Any, ...], str] = field(default_factory=dict)
    contents: dict[tuple[Any, ...], str] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)

    def visit(self, circuit: Circuit, overrides: Overrides, path: Names, place: int) -> str:
        """Name of the definition of `circuit` with `overrides`; children come first.

        `place`: which copy it is of all that stand at `path`, as the devices' arrays count them.
        """
        # a circuit lives as long as the testbench that is walked, so that its id stands for it
        key = (id(circuit), tuple(sorted(overrides.items())), *((path, place) if self.deviations else ()))
        if key not in self.visited:
            self.visited[key] = self._define(circuit, overrides, path, place)
        return self.visited[key]

    def _define(self, circuit: Circuit, overrides: Overrides, path: Names, place: int) -> str:
        used = [split_reference(r)[0] for _, r in references(circuit) if r != GROUND]
        _require_distinct(circuit.name, "node", list(dict.fromkeys([*circuit.shapes(), *used])))
        devices = tuple(
            (_with_overrides(device, overrides), self._deviation((*path, device.name), place))
            for device in circuit.devices
        )
        calls = tuple(
            call for i in circuit.instances for call in self._calls(circuit, i, overrides, path, place)
        )
        ports = tuple(element(p.name, index) for p in circuit.ports for index in np.ndindex(p.shape))
        content = (circuit.name, ports, devices, calls)
        if content not in self.contents:
            self.contents[content] = name = self._free_name(circuit.name)
            self.definitions.append(Definition(name, ports, devices, calls))
        return self.contents[content]

    def _calls(
        self,
        circuit: Circuit,
        instance: Instance | InstanceArray,
        overrides: Overrides,
        path: Names,
        place: int,
    ) -> Iterator[Call]:
        shape, shapes, ports = instance.shape, circuit.shapes(), instance.circuit.ports
        nodes = [_broadcast(instance.connections[p.name], shapes, shape, p.shape) for p in ports]
        parameters = {
            k: np.broadcast_to(np.asarray(v, np.float64), shape) for k, v in instance.parameters.items()
        }
        prefix = f"{instance.name}."
        outer = {k.removeprefix(prefix): v for k, v in overrides.items() if k.startswith(prefix)}
        for k, index in enumerate(np.ndindex(shape)):
            inner = {name: float(v[index]) for name, v in parameters.items()} | outer
            connected = tuple(str(n) for port in nodes for n in port[(*index, ...)].ravel())
            there = place * math.prod(shape) + k
            definition = self.visit(instance.circuit, inner, (*path, instance.name), there)
            yield Call(instance.name, index, definition, connected)

    def _deviation(self, path: Names, place: int) -> Deviation:
        found = self.deviations.get(path, _NONE)
        return Deviation(*(float(np.ravel(x)[place] if np.ndim(x) else x) for x in found))

    def _free_name(self, wanted: str) -> str:
        """`wanted`, or `wanted_2`, `wanted_3`, ... where it is taken; case does not count."""
        name, number = wanted, 1
        while name.lower() in self.names:
            number += 1
            name = f"{wanted}_{number}"
        self.names.add(name.lower())
        return name


def _deviations(flat: FlatCircuit, silicon: Silicon) -> dict[Names, Deviation]:
    """Deviations of all copies of each transistor, by the names on its path; empty for the nominal die."""
    found = {}
    for group in flat.groups if silicon.die.number is not None else ():
        if isinstance(group.device, Transistor):
            size = group.parameters
            area = size["width"] * size["length"] * size["multiplicity"]
            path = (*group.path, (group.device.name, ()))
            found[tuple(name for name, _ in path)] = silicon.deviation(flat.circuit.name, path, area)
    return found


def _with_overrides(device: Device, overrides: Overrides) -> Device:
    """`device` with the parameters of its place; numbering the nodes has checked names and values."""
    own = {
        a: overrides[f"{device.name}.{a}"] for a in device.parameters() if f"{device.name}.{a}" in overrides
    }
    frozen: Any = device
    changed: Device = replace(frozen, **own) if own else device
    return changed


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
