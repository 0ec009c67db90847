"""The CDL dialect, for layout versus schematic: it has what is drawn in a layout, and nothing else.

Transistors are M elements with W, L and M, bulk included, and their models are `nmos` and `pmos`. Capacitors
and resistors have their values, diodes their area. There is no source, no analysis and no call of the top
cell. `*.PININFO` gives the ports (`I` in, `O` out, `B` a supply). Ground is the global net `0`. Node arrays
are buses, `v_mem<3>`.

A die has no deviation here: all dies are drawn alike, so the nominal die is written whatever was asked for.
What is not drawn as one device is a black box: an operational amplifier is a call of `black_box_amplifier`
(positive, negative, output, vdd, vss), a linear controlled source one of `black_box_transconductor`
(positive, negative, control positive, control negative); the cells are empty and stand first, if used.
Written to the Cadence and Calibre manuals' description of the format. Not run here.
"""

from __future__ import annotations

from circuits.circuit import Port
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode
from circuits.silicon.silicon import Deviation, Silicon
from netlists.dialects.spice import open_definition
from netlists.naming import make_naming
from netlists.write.annotation import Annotation, format_annotation
from netlists.write.deck import NOT_RUN, Writer, no_control, wrap
from netlists.write.dialect import make_dialect, make_formatter
from netlists.write.traversal import Definition, Design

_AMPLIFIER, _TRANSCONDUCTOR = "black_box_amplifier", "black_box_transconductor"
_BOXES: dict[type[Device], list[str]] = {
    OperationalAmplifier: [f".subckt {_AMPLIFIER} positive negative output vdd vss", f".ends {_AMPLIFIER}"],
    ControlledSource: [
        f".subckt {_TRANSCONDUCTOR} positive negative control_positive control_negative",
        f".ends {_TRANSCONDUCTOR}",
    ],
}
_NAMING = make_naming("angle", frozenset({_AMPLIFIER, _TRANSCONDUCTOR}))


def _transistor(device: Transistor, silicon: Silicon, deviation: Deviation) -> list[str]:
    size = f"w={float(device.width)!r} l={float(device.length)!r} m={float(device.multiplicity)!r}"
    return [f"{_element('m', device)} {device.polarity}mos {size}"]


def _capacitor(device: Capacitor) -> list[str]:
    begin = "" if device.ic is None else f" ic={float(device.ic)!r}"
    return [f"{_element('c', device)} {float(device.capacitance)!r}{begin}"]


def _transconductor(device: ControlledSource) -> list[str]:
    note = format_annotation(Annotation("transconductor", device))
    return [*note, f"{_element('x', device)} {_TRANSCONDUCTOR}"]


def _diode(device: Diode) -> list[str]:
    return [f"{_element('d', device)} diode area={float(device.area)!r}"]


def _element(letter: str, device: Device) -> str:
    return " ".join((letter + _NAMING.plain(device.name), *map(_NAMING.node, device.terminals())))


def _open(name: str, definition: Definition) -> list[str]:
    ports = [
        f"{_NAMING.node(each)}:{_pin(port)}" for port in definition.circuit.ports for each in port.elements()
    ]
    pins = [f"*.PININFO {line}" for line in _lines(ports)]
    return [*open_definition(_NAMING, name, definition), *pins]


def _lines(words: list[str]) -> list[str]:
    """Words in lines of their own; a comment has no continuation."""
    return [line.removeprefix("+ ") for line in wrap(words)] if words else []


def _pin(port: Port) -> str:
    return "B" if port.kind == "supply" else "O" if port.direction == "out" else "I"


def _boxes(silicon: Silicon, design: Design) -> list[str]:
    used = {type(device) for definition in design.definitions for device, _ in definition.devices}
    return [line for kind, lines in _BOXES.items() if kind in used for line in lines]


def _no_call(name: str, nodes: list[str], definition: str) -> list[str]:
    """Leave the top cell uncalled."""
    return []


_WRITER = Writer(
    dialect="cdl",
    remark=NOT_RUN,
    comment="*",
    naming=_NAMING,
    separator="/",
    open=_open,
    close=lambda name: [f".ends {name}"],
    call=lambda name, nodes, definition: wrap([name, *nodes, definition]),
    head=lambda: ["*.SCALE METER", "*.GLOBAL 0:G"],
    control=no_control,
    top=_no_call,
)

_FORMATTER = make_formatter(
    "cdl",
    _transistor,
    {
        Capacitor: _capacitor,
        Diode: _diode,
        Resistor: lambda device: [f"{_element('r', device)} {float(device.resistance)!r}"],
        ControlledSource: _transconductor,
        OperationalAmplifier: lambda device: [f"{_element('x', device)} {_AMPLIFIER}"],
        Source: lambda _: [],  # no part of the layout
    },
)

DIALECT = make_dialect(
    _WRITER, "for LVS: M, C, R and D as drawn; not run here", {"ekv": (_FORMATTER, _boxes)}, drawing=True
)
