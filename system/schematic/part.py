"""What a schematic shows of a circuit: one part a device, with its nets, its texts, and which end is up.

Current flows down: a supply is above, ground below; between other nets an nFET has its drain above, a pFET
its source. An array of instances, in a circuit of more than `MANY` devices, is drawn by its first cell with
a count, and devices of one size between elements of the same arrays by the first of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import singledispatch
from math import prod

from circuits.circuit import GROUND, Circuit
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode
from circuits.devices.source import Constant
from circuits.lowering.flatten import DeviceGroup, flatten
from circuits.units import format_quantity

MANY = 40
"""Devices beyond which an array is drawn by its first cell; ours."""
_INDEX = re.compile(r"\[[^]]*\]")
_LOW = ("vss", "vee", "gnd")  # names of supplies that are at the bottom, as where a circuit has no testbench


@dataclass(frozen=True, slots=True)
class Rails:
    """Names of the nets at the top and at the bottom of a schematic."""

    high: frozenset[str]
    low: frozenset[str]


@dataclass(frozen=True, slots=True)
class Part:
    """One symbol of a schematic.

    Attributes
    ----------
    name : str
        Instance path of the device that it stands for.
    kind : str
        `nfet`, `pfet`, `capacitor`, `resistor`, `diode` (its anode above) or `diode up`, `controlled source`,
        `operational amplifier`, `voltage source` or `current source`.
    top, bottom : str
        Nets above and below it.
    left, right : tuple of str
        Nets at its sides, from top to bottom; a gate, the controls of a source, the inputs of an amplifier.
    lines : tuple of str
        What is written beside it.
    source_up : bool
        Whether a transistor's source is its upper end.
    """

    name: str
    kind: str
    top: str
    bottom: str
    left: tuple[str, ...] = ()
    right: tuple[str, ...] = ()
    lines: tuple[str, ...] = ()
    source_up: bool = False

    @property
    def is_transistor(self) -> bool:
        """Whether it is a transistor, whose first net at the left is its gate."""
        return self.kind in {"nfet", "pfet"}

    @property
    def drain(self) -> str:
        """Net of a transistor's drain."""
        return self.bottom if self.source_up else self.top

    @property
    def source(self) -> str:
        """Net of a transistor's source."""
        return self.top if self.source_up else self.bottom

    @property
    def is_diode(self) -> bool:
        """Whether it is a transistor whose gate is tied to its drain."""
        return self.is_transistor and self.left[0] == self.drain


def rails_of(circuit: Circuit) -> Rails:
    """Supplies at the top, and ground with supplies whose name says so at the bottom.

    A net that nothing draws current from, such as a gate that a netlist's source drives, is no rail.
    """
    flat = flatten(circuit)
    names = flat.node_names()
    drawing = {names[int(group.nodes[t, 0])] for group in flat.groups for t in _feeding(group.device)}
    supplies = {p.name for p in circuit.ports if p.kind == "supply"} & drawing
    low = frozenset(name for name in supplies if name.lower().startswith(_LOW))
    return Rails(frozenset(supplies - low), low | {GROUND})


def parts_of(
    circuit: Circuit, currents: Mapping[str, float] | None = None, most: float = MANY
) -> tuple[Part, ...]:
    """Parts of a circuit in its own order.

    currents: A by instance path, where they are to be written. most: devices beyond which an array is drawn
    by its first cell.
    """
    flat = flatten(circuit)
    names, rails = flat.node_names(), rails_of(circuit)
    by_cell = sum(g.nodes.shape[1] for g in flat.groups) > most
    parts = [
        _part(group, k, [names[int(n)] for n in group.nodes[:, k]], rails, currents or {})
        for group in flat.groups
        for k in range(1 if by_cell else group.nodes.shape[1])
    ]
    return tuple(_once(parts) if by_cell else parts)


def source_part(source: Source) -> Part:
    """Part of a source that stands in a testbench; its value is written where it is constant."""
    wave, unit = source.waveform, "V" if source.quantity == "voltage" else "A"
    value = (format_quantity(wave.value, unit),) if isinstance(wave, Constant) else ()
    return Part(source.name, f"{source.quantity} source", source.node, GROUND, lines=(source.name, *value))


def cells_of(circuit: Circuit) -> dict[str, int]:
    """Arrays of which only the first cell is drawn, with the number of cells in each."""
    flat = flatten(circuit)
    if sum(g.nodes.shape[1] for g in flat.groups) <= MANY:
        return {}
    counts = {".".join(n for n, _ in g.path): prod(k for _, s in g.path for k in s) for g in flat.groups}
    outer = {path: counts.get(path.rpartition(".")[0], 1) for path in counts}
    return {path: count for path, count in counts.items() if count > outer[path]}


def _once(parts: list[Part]) -> Iterator[Part]:
    """The first of parts of one size between elements of the same arrays, with their number."""
    alike: dict[object, list[Part]] = {}
    for part in parts:
        nets = (part.top, part.bottom, *part.left, *part.right)
        bases = tuple(_INDEX.sub("", net) for net in nets)
        own = "" if "." not in part.name and bases != nets else part.name
        alike.setdefault((own, part.kind, bases, part.lines[1:]), []).append(part)
    for same in alike.values():
        first, count = same[0], len(same)
        yield first if count == 1 else replace(first, lines=(*first.lines, f"x{count} in all"))


def _part(group: DeviceGroup, k: int, nets: list[str], rails: Rails, currents: Mapping[str, float]) -> Part:
    name = group.label(k)
    sizes = {key: float(value[k]) for key, value in group.parameters.items()}
    part = _of(group.device, nets, rails)
    lines = (name, *_sizes(group.device, sizes), *part.lines)
    if name in currents:
        ampere = currents[name]
        small = 0.0 < ampere < 1e-18  # for which there is no prefix
        lines += (f"{ampere:.2e}A" if small else format_quantity(float(f"{ampere:.3g}"), "A"),)
    return replace(part, name=name, lines=lines)


def _feeding(device: Device) -> tuple[int, ...]:
    """Terminals of a device that may take current from a supply."""
    kinds = {Transistor: (0, 2, 3), OperationalAmplifier: (3, 4), ControlledSource: (0, 1)}
    return kinds.get(type(device), tuple(range(len(device.terminals()))))


@singledispatch
def _of(device: Device, nets: list[str], rails: Rails) -> Part:
    raise TypeError(f"{type(device).__name__}: no symbol in a schematic")


@_of.register
def _(device: Transistor, nets: list[str], rails: Rails) -> Part:
    drain, gate, source, bulk = nets
    source_up = _is_above(source, drain, rails, otherwise=device.polarity == "p")
    top, bottom = (source, drain) if source_up else (drain, source)
    usual = rails.high if device.polarity == "p" else {GROUND}
    note = () if bulk in usual else (f"bulk {'= source' if bulk == source else bulk}",)
    return Part("", f"{device.polarity}fet", top, bottom, (gate,), lines=note, source_up=source_up)


@_of.register
def _(device: Capacitor, nets: list[str], rails: Rails) -> Part:
    return _between("capacitor", nets, rails)


@_of.register
def _(device: Resistor, nets: list[str], rails: Rails) -> Part:
    return _between("resistor", nets, rails)


@_of.register
def _(device: Diode, nets: list[str], rails: Rails) -> Part:
    anode, cathode = nets
    above = _is_above(cathode, anode, rails, otherwise=False)
    return Part("", "diode up" if above else "diode", *((cathode, anode) if above else (anode, cathode)))


@_of.register
def _(device: Source, nets: list[str], rails: Rails) -> Part:
    return Part("", f"{device.quantity} source", nets[0], GROUND)


@_of.register
def _(device: ControlledSource, nets: list[str], rails: Rails) -> Part:
    positive, negative, *controls = nets
    return Part("", "controlled source", positive, negative, tuple(controls))


@_of.register
def _(device: OperationalAmplifier, nets: list[str], rails: Rails) -> Part:
    positive, negative, output, high, low = nets
    return Part("", "operational amplifier", high, low, (positive, negative), (output,))


def _between(kind: str, nets: list[str], rails: Rails) -> Part:
    a, b = nets
    return Part("", kind, *((b, a) if _is_above(b, a, rails, otherwise=False) else (a, b)))


def _is_above(one: str, other: str, rails: Rails, *, otherwise: bool) -> bool:
    """Whether net `one` is above net `other`, by the rails among them."""
    up = (one in rails.high) - (one in rails.low)
    than = (other in rails.high) - (other in rails.low)
    return otherwise if up == than else up > than


def _sizes(device: Device, sizes: Mapping[str, float]) -> Iterator[str]:
    """Lines of a device's sizes: width over length in um, or a value with its unit."""
    if isinstance(device, Transistor):
        count = sizes.get("multiplicity", 1.0)
        times = "" if count == 1.0 else f" x{count:g}"
        yield f"{sizes['width'] * 1e6:.3g}/{sizes['length'] * 1e6:.3g}um{times}"
    if isinstance(device, Diode) and sizes["area"] != 1.0:
        yield f"x{sizes['area']:g}"
    for key, unit in (("capacitance", "F"), ("resistance", "Ohm"), ("transconductance", "S")):
        if key in sizes:
            yield format_quantity(float(f"{sizes[key]:.4g}"), unit)
