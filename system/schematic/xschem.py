"""A circuit as a schematic of xschem's, drawn as `noctule show --schematic` draws it.

The symbols are those of xschem's own folder `devices`: nmos4, pmos4, capa, res, diode, vccs, lab_pin, gnd,
ipin, opin and iopin. A point of the layout is 2 units across and 15/14 units down, by which a transistor's
gate, drain and source are at the pins of its symbol. Nets that are wired stand as wires; each piece of a net
has a label, so that xschem's netlist of the file has the circuit's names and is an equal circuit. Hierarchy
is flat: a net inside an instance is `x1.a`, and an element of an array is a bit of a bus, `spike[3]`. Names
of devices have letters, digits and `_` (`netlists.naming`). Transistors name the models `nmos` and `pmos`.

Source: the file format 1.1 in xschem's manual, "developer info".
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import networkx as nx

from circuits.circuit import GROUND, Circuit
from circuits.devices import Capacitor, ControlledSource, Diode, Resistor, Transistor
from circuits.errors import ParameterError
from circuits.lowering.flatten import DeviceGroup, flatten
from netlists.naming import make_naming
from system.schematic.geometry import GATE, HALF, Layout, Symbol
from system.schematic.picture import layout_of

_ACROSS, _DOWN = 2.0, 15.0 / 14.0  # units a point: 20 of a gate to 40, 28 of half a symbol to 30
_BULK = (20.0, 0.0)  # of nmos4 and pmos4
_SHIFT = 20.0  # units from a transistor's centre to its channel's axis
_PORTS = 120.0, 20.0  # units of the ports' column left of the drawing, and between its rows; ours
_HEAD = "v {xschem version=2.9.9 file_version=1.1}\nG {}\nV {}\nS {}\nE {}\n"
_NAMING = make_naming("underscore")
_PLAIN = re.compile(r"[\w.]+(?:\[[0-9]+\])?")  # what xschem takes as one net or as one bit of a bus
_PIN = {"in": "ipin", "out": "opin"}

Point = tuple[float, float]


class _Pin(NamedTuple):
    """A pin of a symbol: where xschem has it, where the layout does, and the net that it is on."""

    at: Point
    drawn: Point
    net: str


@dataclass(frozen=True, slots=True)
class _Placed:
    """A symbol at its place, with its pins."""

    text: str
    pins: tuple[_Pin, ...]


def to_xschem(circuit: Circuit) -> str:
    """Draw a circuit as a schematic of xschem's.

    Raises `ParameterError` for a device that xschem has no symbol for, and for a circuit without devices.
    """
    known = _devices(circuit)
    layout = layout_of(circuit, most=inf)
    placed = [_symbol(each, known) for each in layout.symbols]
    wires = [*_wires(layout), *(w for each in placed for w in _leads(each))]
    lines = [each.text for each in placed]
    lines += [f"N {_numbers(*a, *b)} {{lab={_net(net)}}}" for net, a, b in wires]
    lines += _labels(placed, wires)
    lines += _ports(circuit, layout)
    return _HEAD + "\n".join(lines) + "\n"


def _devices(circuit: Circuit) -> Mapping[str, tuple[DeviceGroup, int, list[str]]]:
    """Group and copy of each device by its path, and its nets."""
    flat = flatten(circuit)
    names = flat.node_names()
    return {
        group.label(k): (group, k, [names[int(n)] for n in group.nodes[:, k]])
        for group in flat.groups
        for k in range(group.nodes.shape[1])
    }


def _symbol(symbol: Symbol, known: Mapping[str, tuple[DeviceGroup, int, list[str]]]) -> _Placed:
    group, k, nets = known[symbol.part.name]
    values = {name: float(value[k]) for name, value in group.parameters.items()}
    name = _NAMING.text(symbol.part.name)
    if isinstance(group.device, Transistor):
        return _transistor(symbol, name, group.device, values, nets)
    x, y = _at((symbol.x, symbol.y))
    offsets: dict[int, Point] = {0: (0.0, -30.0), 1: (0.0, 30.0)}
    turn = 0
    if isinstance(group.device, Capacitor | Resistor):
        kind, letter = ("capa", "c") if isinstance(group.device, Capacitor) else ("res", "r")
        (value,) = values.values()
        nets = [symbol.part.top, symbol.part.bottom]
        text = f"name={letter}{name} m=1 value={value!r}"
    elif isinstance(group.device, Diode):
        kind, text = "diode", f"name=d{name} model=diode area={values['area']!r}"
        if symbol.part.kind == "diode up":
            offsets = {0: (0.0, 30.0), 1: (0.0, -30.0)}
            turn = 2
    elif isinstance(group.device, ControlledSource):
        kind, text = "vccs", f"name=g{name} value={values['transconductance']!r}"
        offsets |= {2: (-40.0, -20.0), 3: (-40.0, 20.0)}
    else:
        raise ParameterError(
            f"{symbol.part.name}: {symbol.part.kind}, which xschem has no symbol for; export another dialect"
        )
    return _place(symbol, f"C {{devices/{kind}.sym}} {_numbers(x, y)} {turn}", (x, y), offsets, nets, text)


def _transistor(
    symbol: Symbol, name: str, device: Transistor, values: Mapping[str, float], nets: list[str]
) -> _Placed:
    """A transistor, turned by half a turn where its source is at the other end than the symbol's."""
    upside_down = symbol.part.source_up != (device.polarity == "p")
    axis, y = _at((symbol.x, symbol.y))
    x = axis + (_SHIFT if symbol.flipped else -_SHIFT)
    up = 30.0 if symbol.part.source_up else -30.0
    offsets = {0: (_SHIFT, up), 1: (-20.0, 0.0), 2: (_SHIFT, -up), 3: _BULK}
    size = f"w={values['width']!r} l={values['length']!r} m={values['multiplicity']!r}"
    text = f"name=m{name} model={device.polarity}mos {size}"
    kind = "nmos4" if device.polarity == "n" else "pmos4"
    # half a turn and a mirrored half a turn keep the gate at the side where the layout has it
    turn = 2 if upside_down else 0
    return _place(symbol, f"C {{devices/{kind}.sym}} {_numbers(x, y)} {turn}", (x, y), offsets, nets, text)


def _place(
    symbol: Symbol, head: str, at: Point, offsets: Mapping[int, Point], nets: list[str], text: str
) -> _Placed:
    side = -1.0 if symbol.flipped else 1.0
    turned = head.endswith(" 2")
    mirrored = int(symbol.flipped != turned)
    pins = []
    for (dx, dy), net in zip(offsets.values(), nets, strict=True):
        where = at[0] + side * dx, at[1] + dy
        pins.append(_Pin(where, _drawn(symbol, net, dx, dy), net))
    return _Placed(f"{head} {mirrored} {{{text}}}", tuple(pins))


def _drawn(symbol: Symbol, net: str, dx: float, dy: float) -> Point:
    """Where the layout has the pin at an offset from its symbol, in units."""
    side = GATE if symbol.flipped else -GATE
    if dx < 0.0:  # a gate, or controls
        rise = 0.0 if dy == 0.0 else (10.0 if dy < 0.0 else -10.0)
        return _at((symbol.x + side, symbol.y + rise))
    if (dx, dy) == _BULK:
        return _at((symbol.x, symbol.y))
    return _at((symbol.x, symbol.y + (HALF if dy < 0.0 else -HALF)))


def _at(point: Point) -> Point:
    """A point of the layout, whose y goes up, in whole units, whose y goes down."""
    return float(round(_ACROSS * point[0])), float(round(-_DOWN * point[1]))


Wired = tuple[str, Point, Point]


def _wires(layout: Layout) -> Iterator[Wired]:
    for w in layout.wires:
        yield w.net, _at((w.x0, w.y0)), _at((w.x1, w.y1))


def _leads(placed: _Placed) -> Iterator[Wired]:
    """Wires from pins to where the layout has them, and from a bulk to a source on its net."""
    for pin in placed.pins:
        if max(abs(pin.at[0] - pin.drawn[0]), abs(pin.at[1] - pin.drawn[1])) > 0.01:
            yield pin.net, pin.at, pin.drawn
    if len(placed.pins) == 4 and placed.text.startswith(("C {devices/nmos4", "C {devices/pmos4")):
        source, bulk = placed.pins[2:]
        if source.net == bulk.net:
            yield bulk.net, bulk.at, source.at


def _labels(placed: list[_Placed], wires: list[Wired]) -> Iterator[str]:
    """One label for each piece of a net that pins and wires make, at a pin of it."""
    graph: nx.Graph = nx.Graph()
    ends = [pin.at for each in placed for pin in each.pins]
    graph.add_nodes_from(ends)
    for _, a, b in wires:
        graph.add_edge(a, b)
    for point in list(graph):
        for _, a, b in wires:
            if _within(point, a, b):
                graph.add_edge(point, a)
    nets = {pin.at: pin.net for each in placed for pin in each.pins}
    for number, piece in enumerate(nx.connected_components(graph)):
        own = sorted(p for p in piece if p in nets)
        net = nets[own[0]]
        at = max(own, key=lambda p: p[1]) if net == GROUND else own[0]  # the symbol of ground at the bottom
        if {nets[p] for p in own} != {net}:
            raise ParameterError(f"node {net}: its wires touch those of another; export another dialect")
        kind = "gnd" if net == GROUND else "lab_pin"
        yield f"C {{devices/{kind}.sym}} {_numbers(*at)} 0 0 {{name=l{number} lab={_net(net)}}}"


def _within(point: Point, a: Point, b: Point) -> bool:
    """Whether a point is on a wire, which goes across or down."""
    across, down = sorted((a[0], b[0])), sorted((a[1], b[1]))
    return across[0] <= point[0] <= across[1] and down[0] <= point[1] <= down[1]


def _ports(circuit: Circuit, layout: Layout) -> Iterator[str]:
    """Ports in a column at the left, each by its name."""
    x, y = _at((layout.extent.left, layout.extent.top))
    names = [(port, element) for port in circuit.ports for element in port.elements()]
    for k, (port, element) in enumerate(names):
        kind = "iopin" if port.kind == "supply" else _PIN[port.direction]
        where = _numbers(x - _PORTS[0], y + k * _PORTS[1])
        yield f"C {{devices/{kind}.sym}} {where} 0 0 {{name=p{k} lab={_net(element)}}}"


def _net(net: str) -> str:
    """Name of a net as a label: itself, but where an index stands inside it or has two dimensions."""
    return net if _PLAIN.fullmatch(net) else _NAMING.text(net)


def _numbers(*values: float) -> str:
    return " ".join(f"{value:.10g}" for value in values)
