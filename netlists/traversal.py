"""Testbench -> definitions, calls and sources in the order in which a netlist lists them; no dialect's text.

Every circuit becomes one definition for each distinct content: an instance whose parameters differ gets its
own definition, and two circuits of equal content share one. Arrays become one call an element. Values are
literal: a definition has no parameters. Names are ours (`v_mem[3]`); a dialect turns them into its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circuits.circuit import GROUND, Circuit, Instance, InstanceArray, Shape, references, split_reference
from circuits.devices.device import Device
from circuits.devices.source import Source
from circuits.errors import ParameterError, TopologyError, unknown_name
from circuits.lowering.flatten import flatten
from circuits.lowering.kernel import complete_sources
from circuits.process import Silicon
from circuits.testbench import Testbench

Overrides = Mapping[str, float]
Names = NDArray[np.object_]


@dataclass(frozen=True, slots=True)
class Call:
    """An instance of a definition: `nodes` of the caller in the order of the definition's ports."""

    name: str
    index: Shape
    definition: str
    nodes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Definition:
    """A circuit with literal values. `ports` are scalar: an array port is listed element by element."""

    name: str
    ports: tuple[str, ...]
    devices: tuple[Device, ...]
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
    walk = _Walk()
    walk.visit(testbench.circuit, {})
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
    """Definitions met so far, and the way to them from a circuit with parameters and from a content."""

    definitions: list[Definition] = field(default_factory=list)
    visited: dict[tuple[int, tuple[tuple[str, float], ...]], str] = field(default_factory=dict)
    contents: dict[tuple[Any, ...], str] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)

    def visit(self, circuit: Circuit, overrides: Overrides) -> str:
        """Name of the definition of `circuit` with `overrides`; children come first."""
        # a circuit lives as long as the testbench that is walked, so that its id stands for it
        place = (id(circuit), tuple(sorted(overrides.items())))
        if place not in self.visited:
            self.visited[place] = self._define(circuit, overrides)
        return self.visited[place]

    def _define(self, circuit: Circuit, overrides: Overrides) -> str:
        used = [split_reference(r)[0] for _, r in references(circuit) if r != GROUND]
        _require_distinct(circuit.name, "node", list(dict.fromkeys([*circuit.shapes(), *used])))
        devices = tuple(_with_overrides(circuit, device, overrides) for device in circuit.devices)
        calls = tuple(chain.from_iterable(self._calls(circuit, i, overrides) for i in circuit.instances))
        ports = tuple(element(p.name, index) for p in circuit.ports for index in np.ndindex(p.shape))
        _require_used(circuit, overrides)
        content = (circuit.name, ports, devices, calls)
        if content not in self.contents:
            self.contents[content] = name = self._free_name(circuit.name)
            self.definitions.append(Definition(name, ports, devices, calls))
        return self.contents[content]

    def _calls(
        self, circuit: Circuit, instance: Instance | InstanceArray, overrides: Overrides
    ) -> Iterator[Call]:
        shape, shapes, ports = instance.shape, circuit.shapes(), instance.circuit.ports
        nodes = [_broadcast(instance.connections[p.name], shapes, shape, p.shape) for p in ports]
        parameters = {
            k: np.broadcast_to(np.asarray(v, np.float64), shape) for k, v in instance.parameters.items()
        }
        prefix = f"{instance.name}."
        outer = {k.removeprefix(prefix): v for k, v in overrides.items() if k.startswith(prefix)}
        for index in np.ndindex(shape):
            inner = {k: float(v[index]) for k, v in parameters.items()} | outer
            connected = tuple(str(n) for port in nodes for n in port[(*index, ...)].ravel())
            yield Call(instance.name, index, self.visit(instance.circuit, inner), connected)

    def _free_name(self, wanted: str) -> str:
        """`wanted`, or `wanted_2`, `wanted_3`, ... where it is taken; case does not count."""
        name, number = wanted, 1
        while name.lower() in self.names:
            number += 1
            name = f"{wanted}_{number}"
        self.names.add(name.lower())
        return name


def _with_overrides(circuit: Circuit, device: Device, overrides: Overrides) -> Device:
    known = device.parameters()
    own = {a: overrides[f"{device.name}.{a}"] for a in known if f"{device.name}.{a}" in overrides}
    if not own:
        return device
    frozen: Any = device
    changed: Device = replace(frozen, **own)
    try:
        changed.check()
    except ParameterError as error:
        raise ParameterError(f"{circuit.name}.{error}") from None
    return changed


def _require_used(circuit: Circuit, overrides: Overrides) -> None:
    own = {f"{d.name}.{a}" for d in circuit.devices for a in d.parameters()}
    inside = tuple(f"{i.name}." for i in circuit.instances)
    for key in overrides:
        if key not in own and not (inside and key.startswith(inside)):
            raise unknown_name(f"{circuit.name} parameter", key, own)


def _broadcast(reference: str, shapes: Mapping[str, Shape], outer: Shape, port: Shape) -> Names:
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
