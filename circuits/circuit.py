"""What a circuit is: ports, devices, instances of other circuits, and biases, all as plain frozen data.

Nodes are named by text. `"vmem"` is a single node, `"spike[3]"` is an element of an array of nodes, and `"0"`
is ground everywhere. An array of nodes is declared once, by a `Node` or a `Port` with a shape; single nodes
need no declaration. A circuit has no stimuli: what drives its ports is said by a testbench
(`circuits.testbench`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from math import isfinite
from typing import Literal, get_args

import numpy as np

from circuits.brief import OPTIONAL, brief
from circuits.checks import (
    keep_allowance,
    require_choice,
    require_plausible,
    require_real,
    require_reals,
    require_type,
)
from circuits.devices.device import Device
from circuits.errors import ParameterError, TopologyError, unknown_name

GROUND = "0"
"""Name of the ground node in every circuit: `0`."""

PortKind = Literal["event", "analog", "bias", "supply"]
Direction = Literal["in", "out"]
BiasKind = Literal["gate", "ideal", "generator", "voltage"]
Shape = tuple[int, ...]

_CALLED_GROUND = frozenset({"gnd", "gnd!", "ground"})  # by SPICE and its users; "vss" is a supply of its own
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_SHOWN = 60  # characters of a name that is none; ours
# nine digits, since an index is a 32-bit word where a die is drawn
_REFERENCE = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)(?:\[([0-9]{1,9}(?:,[0-9]{1,9})*)\])?")


@dataclass(frozen=True, slots=True)
class Node:
    """An array of nodes inside a circuit; single nodes need no declaration.

    Raises `ParameterError` for a name that is no text or a shape that is no tuple of whole numbers.

    Attributes
    ----------
    name
        The array's name.
    shape
        How many nodes it has along each axis.
    """

    name: str
    shape: Shape

    def __post_init__(self) -> None:
        _require_name("node", self.name)
        _require_shape(f"node {self.name}", self.shape)


@dataclass(frozen=True, slots=True, repr=False)
class Port:
    """A node, or an array of nodes, that the outside of a circuit can reach.

    Attributes
    ----------
    name : str
        Name of the port, and of its node.
    kind : str
        What crosses it: `event` for pulses of the full supply, `analog` for voltages and currents, `bias` for
        a bias voltage, `supply`.
    direction : str
        Seen from the circuit: the outside drives `in`, the circuit drives `out`.
    shape : tuple of int
        How many nodes it has along each axis; () for one.
    threshold : float or None
        Voltage that an event rises through, V; half of the supply that the circuit is wired to unless given.

    Raises
    ------
    ParameterError
        A kind or direction is not known, or a value is of the wrong type.
    """

    name: str
    kind: PortKind
    direction: Direction = "in"
    shape: Shape = ()
    threshold: float | None = field(default=None, metadata=OPTIONAL)

    def __repr__(self) -> str:
        return brief(self)

    def __post_init__(self) -> None:
        _require_name("port", self.name)
        require_choice(f"port {self.name}.kind", self.kind, get_args(PortKind))
        require_choice(f"port {self.name}.direction", self.direction, get_args(Direction))
        _require_shape(f"port {self.name}", self.shape)
        if self.threshold is not None:
            require_real(f"port {self.name}.threshold", self.threshold, "V")

    def elements(self) -> list[str]:
        """References of the port's nodes in order, such as `spike[0]`; of one node, its name alone."""
        if not self.shape:
            return [self.name]
        return [f"{self.name}[{','.join(map(str, i))}]" for i in np.ndindex(self.shape)]


@dataclass(frozen=True, slots=True)
class Bias:
    """What a bias port is set to, and by what means.

    Attributes
    ----------
    name : str
        What a designer sets, such as `i_inh_tau`.
    port : str
        The port that is set.
    kind : str
        One of four. A `gate` bias is an ideal gate voltage: the one at which the nominal `device` carries
        `value` in saturation at the reference temperature; it stays there at every temperature. An `ideal`
        bias is an ideal current of `value` at the reference temperature, proportional to absolute
        temperature, into a diode-connected copy of `device` on the same die. A `generator` bias is a line of
        the chip's own bias generator there (`circuits.generator`), at the code nearest to `value`. A
        `voltage` bias is `value` itself.
    value : float or tuple of float
        One number, or one for each element of the port: A, or V for the kind `voltage`. 0 A is a bias that is
        off.
    device : str or None
        Path of the biased transistor in the circuit; None for the kind `voltage`.
    reference_temperature_c : float
        Temperature at which `value` holds, degC.
    place : tuple or None
        Where the copy of an ideal bias or the line of the generator stands on the die, for a block that
        shares its chip's biases (`circuits.place`); inside the circuit itself unless given.
    allow_implausible : bool
        Whether a value outside of what silicon has is meant.

    Raises
    ------
    ParameterError
        A kind is not known, a value is no number, or it is implausible (`circuits.checks`) and that is not
        allowed; of several values the largest is checked.
    """

    name: str
    port: str
    kind: BiasKind
    value: float | tuple[float, ...]
    device: str | None = None
    reference_temperature_c: float = 27.0
    place: tuple[tuple[str, Shape], ...] | None = None
    allow_implausible: bool = field(default=False, repr=False, compare=False, kw_only=True)

    def __post_init__(self) -> None:
        keep_allowance(self)
        _require_name("bias", self.name)
        label = f"bias {self.name}"
        require_choice(f"{label}.kind", self.kind, get_args(BiasKind))
        unit = "V" if self.kind == "voltage" else "A"
        require_reals(f"{label}.value", self.value, unit)
        largest = float(np.abs(self.value).max(initial=0.0))
        if largest != 0.0:
            require_plausible(f"{label}.value", largest, unit, allowed=self.allow_implausible)
        require_real(f"{label}.reference_temperature_c", self.reference_temperature_c, "degC")


@dataclass(frozen=True, slots=True)
class _Placed:
    """A circuit inside another, once or as an array.

    name : of the instance or array, which no other part of the parent has.
    circuit : the circuit that stands there.
    """

    name: str
    circuit: Circuit


@dataclass(frozen=True, slots=True)
class Instance(_Placed):
    """One `circuit` inside another, by a `name` that no other part of the parent has.

    Attributes
    ----------
    connections : mapping of str to str
        Node of the parent that each port of `circuit` is connected to, by the port's name.
    parameters : mapping of str to float
        Parameters of devices that differ from those of `circuit`, by `"device.attribute"`, in SI units.
    """

    connections: Mapping[str, str]
    parameters: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _check_instance(self)

    @property
    def shape(self) -> Shape:
        """The shape (), so that an instance can be treated as an array of one."""
        return ()


@dataclass(frozen=True, slots=True)
class InstanceArray(_Placed):
    """An array of instances of one `circuit`, which is never expanded into objects.

    It has a `name` that no other part of the parent has.

    Attributes
    ----------
    shape : tuple of int
        How many instances it has along each axis.
    connections : mapping of str to str
        Node of the parent that each port is connected to, by the port's name: either one node that all
        instances share, or an array of nodes that broadcasts to `shape` followed by the port's own shape.
    parameters : mapping of str to object
        Parameters of devices that differ from those of `circuit`, by `"device.attribute"` with dots through
        inner instances; each is one number or an array (nested tuples or numpy) that broadcasts to `shape`,
        in SI units.
    """

    shape: Shape
    connections: Mapping[str, str]
    parameters: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _check_instance(self)
        _require_shape(f"instance {self.name}", self.shape)


@dataclass(frozen=True, slots=True)
class Circuit:
    """A circuit: its ports, devices, instances of other circuits, arrays of nodes, and biases.

    Attributes
    ----------
    name : str
        Name of the circuit.
    ports : tuple of Port
        Nodes that the outside can reach.
    devices : tuple of Device
        Its own devices.
    instances : tuple of Instance or InstanceArray
        Other circuits inside it.
    nodes : tuple of Node
        Its arrays of nodes; single nodes need no declaration.
    biases : tuple of Bias
        What its bias ports are set to.

    Raises
    ------
    TopologyError
        A name is malformed or stands twice, a node is called `gnd` instead of `0`, or a connection is missing
        or leads nowhere.
    ParameterError
        A part is none of a circuit's.
    """

    name: str
    ports: tuple[Port, ...] = ()
    devices: tuple[Device, ...] = ()
    instances: tuple[Instance | InstanceArray, ...] = ()
    nodes: tuple[Node, ...] = ()
    biases: tuple[Bias, ...] = ()

    def __post_init__(self) -> None:
        _check_parts(self)
        _check_names(self)
        _check_references(self)
        _check_biases(self)

    def port(self, name: str) -> Port:
        """The port called `name`; raises `UnknownNameError` where there is none."""
        for port in self.ports:
            if port.name == name:
                return port
        raise unknown_name(f"{self.name} port", name, [p.name for p in self.ports])

    def device(self, name: str) -> Device:
        """The device called `name`, where dots reach into instances.

        Raises `UnknownNameError` where there is none.
        """
        head, _, rest = name.partition(".")
        for instance in self.instances if rest else ():
            if instance.name == head:
                return instance.circuit.device(rest)
        for device in self.devices:
            if device.name == name:
                return device
        raise unknown_name(f"{self.name} device", name, [d.name for d in self.devices])

    def bias(self, name: str) -> Bias:
        """The bias called `name`; raises `UnknownNameError` where there is none."""
        for bias in self.biases:
            if bias.name == name:
                return bias
        raise unknown_name(f"{self.name} bias", name, [b.name for b in self.biases])

    def wired(self, **others: str) -> dict[str, str]:
        """Connections of an instance: each port to the node of the same name, or to the one in `others`."""
        return {p.name: p.name for p in self.ports} | others

    def instance(self, name: str, **others: str) -> Instance:
        """Make an instance of this circuit, for use inside another one.

        Parameters
        ----------
        name
            Name of the instance.
        others
            Node of a port by the port's name, for ports whose node has another name than themselves.
        """
        return Instance(name, self, self.wired(**others))

    def array(self, name: str, shape: Shape, **others: str) -> InstanceArray:
        """Make an array of this circuit, for use inside another one.

        `name` is that of the array, `shape` the number of its instances along each axis; `others` are those
        of `instance`.
        """
        return InstanceArray(name, self, shape, self.wired(**others))

    def shapes(self) -> dict[str, Shape]:
        """Shape of every port and of every array of nodes, by name."""
        return {p.name: p.shape for p in self.ports} | {n.name: n.shape for n in self.nodes}


@lru_cache(maxsize=65_536)
def split_reference(reference: str) -> tuple[str, Shape]:
    """Split `"spike[3]"` into `("spike", (3,))`; a plain name gives an empty index.

    Raises `TopologyError` for what is not the name of a node.
    """
    match = _REFERENCE.fullmatch(reference)
    if match is None:
        raise TopologyError(
            f"{reference[:_SHOWN]!r}: not a node name; write letters, digits, _ and an index as in v[2]"
        )
    index = match.group(2)
    return match.group(1), tuple(int(i) for i in index.split(",")) if index else ()


def references(circuit: Circuit) -> Iterator[tuple[str, str]]:
    """Name of a device or instance with each node that it is connected to, one after the other."""
    for device in circuit.devices:
        for terminal in device.terminals():
            yield device.name, terminal
    for instance in circuit.instances:
        for reference in instance.connections.values():
            yield instance.name, reference


def _require_name(kind: str, name: object) -> None:
    require_type(f"{kind}.name", name, str, "a name")


def _require_shape(label: str, shape: object) -> None:
    whole = isinstance(shape, tuple) and all(isinstance(n, int | np.integer) for n in shape)
    if not whole:
        raise ParameterError(f"{label}.shape: {shape!r:.60}, must be a tuple of whole numbers, as in (13,)")


def _check_instance(instance: Instance | InstanceArray) -> None:
    _require_name("instance", instance.name)
    require_type(f"{instance.name}.circuit", instance.circuit, Circuit, "a circuit")
    for port, node in instance.connections.items():
        require_type(f"{instance.name}.{port}", node, str, "the name of a node")
    for key, value in instance.parameters.items():
        require_reals(f"{instance.name}.{key}", value, "SI")


def _check_parts(circuit: Circuit) -> None:
    _require_name("circuit", circuit.name)
    for noun, parts, kind in (
        ("a port", circuit.ports, Port),
        ("a device", circuit.devices, Device),
        ("an instance", circuit.instances, (Instance, InstanceArray)),
        ("an array of nodes", circuit.nodes, Node),
        ("a bias", circuit.biases, Bias),
    ):
        for part in parts:
            require_type(f"{circuit.name}", part, kind, noun)


def _check_names(circuit: Circuit) -> None:
    for kind, names in (
        ("device or instance", [*(d.name for d in circuit.devices), *(i.name for i in circuit.instances)]),
        ("node", [*(p.name for p in circuit.ports), *(n.name for n in circuit.nodes)]),
        ("bias", [b.name for b in circuit.biases]),
    ):
        seen: set[str] = set()
        for name in names:
            if kind == "node" and name.lower() in _CALLED_GROUND:
                raise TopologyError(f'{circuit.name}.{name}: ground is called "0", this floats; write "0"')
            if not _NAME.fullmatch(name):
                raise TopologyError(f"{circuit.name}.{name}: not a name; use letters, digits and _")
            if name.lower() in seen:
                raise TopologyError(
                    f"{circuit.name}.{name}: duplicate {kind} name (case does not count); rename one"
                )
            seen.add(name.lower())
    shapes = {**circuit.shapes(), **{i.name: i.shape for i in circuit.instances}}
    for port in circuit.ports:
        if port.threshold is not None and not isfinite(port.threshold):
            found = f"{circuit.name}.{port.name}.threshold: {port.threshold:g} V"
            raise ParameterError(f"{found}, must be finite; leave it out for half of the supply")
    for name, shape in shapes.items():
        if any(size < 1 for size in shape):
            raise TopologyError(f"{circuit.name}.{name}: shape {shape}, every size must be at least 1")


def _check_references(circuit: Circuit) -> None:
    shapes = circuit.shapes()
    for owner, reference in references(circuit):
        if reference != GROUND:
            _check_index(f"{circuit.name}.{owner}", reference, shapes)
    for device in circuit.devices:
        for reference in device.terminals():
            if shapes.get(reference, ()):
                raise TopologyError(
                    f"{circuit.name}.{device.name}: {reference} is an array of nodes; name one element"
                )
    _check_connections(circuit)


def _check_index(owner: str, reference: str, shapes: Mapping[str, Shape]) -> None:
    if reference.lower() in _CALLED_GROUND:
        raise TopologyError(f'{owner}: {reference}, ground is called "0", this floats; write "0"')
    try:
        name, index = split_reference(reference)
    except TopologyError as error:
        raise TopologyError(f"{owner}: {error}") from None
    shape = shapes.get(name, ())
    if index and (len(index) != len(shape) or any(i >= n for i, n in zip(index, shape, strict=True))):
        raise TopologyError(
            f"{owner}: {reference}: index outside the shape {shape} of {name}; name an element that exists"
        )


def _check_connections(circuit: Circuit) -> None:
    for instance in circuit.instances:
        known = {p.name for p in instance.circuit.ports}
        for port in instance.connections:
            if port not in known:
                raise unknown_name(f"{circuit.name}.{instance.name} port", port, known)
        missing = sorted(known - set(instance.connections))
        if missing:
            raise TopologyError(
                f"{circuit.name}.{instance.name}.{missing[0]}: unconnected port; connect it to a node"
            )


def _check_biases(circuit: Circuit) -> None:
    for bias in circuit.biases:
        port = circuit.port(bias.port)
        if port.kind != "bias":
            raise TopologyError(
                f"{circuit.name}.{bias.port}: a bias on a port of kind {port.kind}; declare it as bias"
            )
        if bias.kind != "voltage":
            if bias.device is None:
                raise TopologyError(
                    f"{circuit.name}.{bias.port}: a {bias.kind} bias must name the device it biases"
                )
            circuit.device(bias.device)
