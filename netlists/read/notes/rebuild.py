"""Circuits made from the definitions of a netlist and their notes.

They have the arrays, and the parameters of instances, of the circuits that were written.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from circuits.circuit import Bias, Circuit, Instance, InstanceArray, Node, Port
from circuits.devices import Capacitor, Device
from circuits.errors import CircuitError, unknown_name
from circuits.silicon.silicon import Change, Deviation
from netlists.read.card import Card, shown
from netlists.read.limits import Limits
from netlists.write.annotation import ArrayNote, InstanceNote, ParameterNote, to_parameters


@dataclass(slots=True)
class Called:
    """An instance or array of a definition, and the definitions of its elements' calls."""

    card: Card
    note: InstanceNote | ArrayNote
    parameters: list[ParameterNote] = field(default_factory=list)
    calls: list[tuple[str, str]] = field(default_factory=list)  # (element's name, definition)


@dataclass(slots=True)
class Definition:
    """What stands between `.subckt` and `.ends`."""

    card: Card
    name: str
    circuit: str = ""
    ports: list[Port] = field(default_factory=list)
    nodes: list[Node] = field(default_factory=list)
    biases: list[Bias] = field(default_factory=list)
    devices: list[Device] = field(default_factory=list)
    deviations: dict[str, Deviation | Change] = field(default_factory=dict)
    parasitics: list[Capacitor] = field(default_factory=list)
    called: list[Called] = field(default_factory=list)


@dataclass(slots=True)
class Build:
    """Circuits of definitions, each once; `open` are those that wait for what they call."""

    definitions: dict[str, Definition]
    limits: Limits
    built: dict[str, Circuit] = field(default_factory=dict)
    open: list[str] = field(default_factory=list)

    def circuit(self, name: str, caller: Card) -> Circuit:
        """Circuit of a definition; raises `DataError` where its notes make none."""
        if name in self.built:
            return self.built[name]
        definition = self.definitions.get(name)
        if definition is None:
            raise caller.error(f"{shown(name)}: definition is not there; write the netlist again")
        if name in self.open or len(self.open) >= self.limits.call_depth:
            raise caller.error(f"{shown(name)}: calls itself, or calls too deep; write the netlist again")
        self.open.append(name)
        instances = tuple(self._instance(called) for called in definition.called)
        self.open.pop()
        try:
            self.built[name] = Circuit(
                definition.circuit or definition.name, tuple(definition.ports), tuple(definition.devices),
                instances, tuple(definition.nodes), tuple(definition.biases),
            )  # fmt: skip
        except CircuitError as error:
            raise definition.card.error(str(error)) from None
        return self.built[name]

    def _instance(self, called: Called) -> Instance | InstanceArray:
        note = called.note
        calls = 1 if isinstance(note, InstanceNote) else math.prod(note.shape)
        if len(called.calls) != calls or not calls:
            found = f"{len(called.calls)} calls after its note, must be {calls}"
            raise called.card.error(f"{shown(note.name)}: {found}; write the netlist again")
        circuit = self.circuit(called.calls[0][1], called.card)
        try:
            circuit = _with_values(circuit, {p.key: p.base for p in called.parameters})
            parameters = to_parameters(called.parameters)
        except CircuitError as error:
            raise called.card.error(str(error)) from None
        if isinstance(note, InstanceNote):
            return Instance(note.name, circuit, dict(note.connections), parameters)
        return InstanceArray(note.name, circuit, note.shape, dict(note.connections), parameters)


def _with_values(circuit: Circuit, values: Mapping[str, float]) -> Circuit:
    """`circuit` with values set by key, `device.attribute` dotted through instances."""
    if not values:
        return circuit
    inner: dict[str, dict[str, float]] = defaultdict(dict)
    own: dict[str, dict[str, float]] = defaultdict(dict)
    for key, value in values.items():
        head, _, rest = key.partition(".")
        (inner if "." in rest else own)[head][rest] = value
    for name in own:
        circuit.device(name)  # raises for a device that is not there
    instances = tuple(replace(i, circuit=_with_values(i.circuit, inner[i.name])) for i in circuit.instances)
    devices = tuple(_with_attributes(d, own[d.name]) if d.name in own else d for d in circuit.devices)
    return replace(circuit, devices=devices, instances=instances)


def _with_attributes(device: Device, values: Mapping[str, float]) -> Device:
    for attribute in values:
        if attribute not in device.parameters():
            raise unknown_name(f"{device.name} parameter", attribute, device.parameters())
    frozen: Any = device
    changed: Device = replace(frozen, **values)
    return changed
