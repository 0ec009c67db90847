"""What the SPICE family writes alike: devices, sources, definitions and calls; a `Syntax` says what differs.

EKV transistors are behavioural currents with the constants folded, and their constant capacitances; a
definition has literal numbers only. A device `mi5` is an element of its type's letter and its name, what it
is made of has a tag (`netlists.naming`): its capacitances `gb`, its junctions' leakage `db`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from circuits.circuit import GROUND
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.source import polyline
from circuits.devices.transistor import capacitances
from circuits.silicon.process import Polarity, TransistorAtTemperature, TransistorModel
from circuits.silicon.silicon import Deviation, Silicon
from netlists.naming import Naming
from netlists.registry import NO_DEVIATION, DeviceFormatter
from netlists.write import law
from netlists.write.deck import NOT_RUN, Control, Writer, wrap
from netlists.write.traversal import Definition

TERMINALS = "dgsb"
# A, by models. BSIM3's currents are noisier: of 52 runs of the rebound neuron (26 dies, two settings) 7 ended
# with a timestep too small at 1e-15, none from 1e-14 to 1e-12; at 1e-13 spikes are within 0.5 us of 1e-14.
_ABSTOL = {"ekv": "1e-15", "bsim3": "1e-13"}
_CACHED = 1 << 14

Transistors = Callable[[Transistor, Silicon, Deviation], list[str]]


def _capacitor(name: str, a: str, b: str, value: float) -> str:
    return f"c{name} {a} {b} {value!r}"


@dataclass(frozen=True, slots=True)
class Syntax:
    """How a dialect of the family differs.

    `current(name, start, end, expression)`: lines of a behavioural current that leaves node `start`, passes
    the source and enters node `end` (the dialect's names). `control`: analysis, options, what is saved.
    `capacitor(name, a, b, value)`: line of a capacitance between two nodes.
    """

    dialect: str
    naming: Naming
    current: Callable[[str, str, str, str], list[str]]
    control: Callable[[Control], list[str]]
    runs: bool = False
    separator: str = "."
    capacitor: Callable[[str, str, str, float], str] = _capacitor


def make_writer(syntax: Syntax) -> Writer:
    """The dialect's part in the walk over a design."""
    return Writer(
        syntax.dialect,
        "" if syntax.runs else NOT_RUN,
        "*",
        syntax.naming,
        syntax.separator,
        functools.partial(open_definition, syntax.naming),
        lambda name: [f".ends {name}"],
        lambda name, nodes, definition: wrap([name, *nodes, definition]),
        list,
        syntax.control,
    )


def tolerances(models: str) -> str:
    """Options gmin (S), abstol (A) and chgtol (C)."""
    return f"gmin=1e-15 abstol={_ABSTOL[models]} chgtol=1e-17"


def open_definition(naming: Naming, name: str, definition: Definition) -> list[str]:
    """The `.subckt` card."""
    return wrap([".subckt", name, *map(naming.node, definition.ports)])


def make_formatter(syntax: Syntax, transistors: Transistors | None = None) -> DeviceFormatter:
    """Formatter of all device types; `transistors` writes transistors, else they are EKV currents."""
    naming = syntax.naming

    def element(letter: str, name: str, terminals: tuple[str, ...], value: float) -> str:
        return f"{letter}{naming.plain(name)} {' '.join(map(naming.node, terminals))} {float(value)!r}"

    @functools.singledispatch
    def format_device(device: Device, silicon: Silicon, deviation: Deviation = NO_DEVIATION) -> list[str]:
        raise TypeError(f"{type(device).__name__}: no lowering to {syntax.dialect} text")

    @format_device.register
    def _(device: Capacitor, silicon: Silicon, deviation: Deviation = NO_DEVIATION) -> list[str]:
        line = element("c", device.name, device.terminals(), device.capacitance)
        return [line if device.ic is None else f"{line} ic={float(device.ic)!r}"]

    @format_device.register
    def _(device: Resistor, silicon: Silicon, deviation: Deviation = NO_DEVIATION) -> list[str]:
        return [element("r", device.name, device.terminals(), device.resistance)]

    @format_device.register
    def _(device: ControlledSource, silicon: Silicon, deviation: Deviation = NO_DEVIATION) -> list[str]:
        return [element("g", device.name, device.terminals(), device.transconductance)]

    @format_device.register
    def _(device: OperationalAmplifier, silicon: Silicon, deviation: Deviation = NO_DEVIATION) -> list[str]:
        return format_amplifier(syntax, device)

    @format_device.register
    def _(device: Source, silicon: Silicon, deviation: Deviation = NO_DEVIATION) -> list[str]:
        return format_source(naming, device)

    own = ekv_transistors(syntax) if transistors is None else transistors

    @format_device.register
    def _(device: Transistor, silicon: Silicon, deviation: Deviation = NO_DEVIATION) -> list[str]:
        return own(device, silicon, deviation)

    formatter: Any = format_device
    typed: DeviceFormatter = formatter
    return typed


def ekv_transistors(syntax: Syntax) -> Transistors:
    """Transistors as currents of the law, and capacitances."""
    naming, between = syntax.naming, difference(syntax.naming)

    @functools.lru_cache(_CACHED)
    def charges(device: Transistor, model: TransistorModel) -> tuple[str, ...]:
        return tuple(
            syntax.capacitor(naming.part(device.name, tag), naming.node(a), naming.node(b), value)
            for tag, a, b, value in device_capacitances(device, model)
        )

    def transistor(device: Transistor, silicon: Silicon, deviation: Deviation) -> list[str]:
        at = law_of(silicon, device.polarity, deviation)
        drain, source, bulk = map(naming.node, (device.drain, device.source, device.bulk))
        turn = device.polarity == "p"

        def current(name: str, start: str, end: str, expression: str) -> list[str]:
            return syntax.current(name, *((end, start) if turn else (start, end)), expression)

        lines = current(naming.plain(device.name), drain, source, law.channel_current(device, at, between))
        if at.junction_leakage > 0.0:
            for terminal, node, letter in ((device.drain, drain, "d"), (device.source, source, "s")):
                leak = law.junction_current(device, at, terminal, between)
                lines += current(naming.part(device.name, f"{letter}b"), node, bulk, leak)
        return [*lines, *charges(device, silicon.process.model(device.polarity))]

    return transistor


def format_amplifier(syntax: Syntax, device: OperationalAmplifier) -> list[str]:
    """Currents of an operational amplifier from its output to both supplies."""
    naming = syntax.naming
    up, down = law.amplifier_currents(device, difference(naming))
    out, top, bottom = map(naming.node, (device.output, device.vdd, device.vss))
    return [
        *syntax.current(naming.part(device.name, "up"), out, top, up),
        *syntax.current(naming.part(device.name, "down"), out, bottom, down),
    ]


def format_mos(name: str, nodes: Sequence[str], model: str, parameters: Sequence[str]) -> list[str]:
    """M element of a transistor with a card."""
    return wrap([name, *nodes, model, *parameters])


def law_of(silicon: Silicon, polarity: Polarity, deviation: Deviation) -> TransistorAtTemperature:
    """Law of a transistor: what the die shares, and what its place adds."""
    shared = _shared_law(silicon, polarity)
    return replace(
        shared,
        v_t0=float(shared.v_t0 + deviation.v_t0),
        square_current=float(shared.square_current * (1.0 + deviation.beta)),
    )


@functools.lru_cache(8)
def _shared_law(silicon: Silicon, polarity: Polarity) -> TransistorAtTemperature:
    return silicon.law(polarity)


def device_capacitances(device: Transistor, model: TransistorModel) -> list[tuple[str, str, str, float]]:
    """Capacitances of a transistor that are between two nodes: tag, our two nodes, F."""
    size = (np.array([device.width]), np.array([device.length]), np.array([device.multiplicity]))
    ends = device.terminals()
    found = capacitances(model, *size).items()
    return [
        (TERMINALS[i] + TERMINALS[j], ends[i], ends[j], float(value[0]))
        for (i, j), value in found
        if ends[i] != ends[j]
    ]


def difference(naming: Naming) -> law.Difference:
    """Text of the voltage between two of our nodes, `v(a,b)`."""

    def between(a: str, b: str) -> str:
        if a == b:
            return law.ZERO
        if b == GROUND:
            return f"v({naming.node(a)})"
        return f"(-v({naming.node(b)}))" if a == GROUND else f"v({naming.node(a)},{naming.node(b)})"

    return between


def corners(source: Source) -> list[tuple[float, float]]:
    """Vertices (s, value) of a source from time 0, where a run begins; earlier ones are cut off there."""
    time, value = polyline(source.name, source.waveform)
    first = float(np.interp(0.0, time, value))
    kept = time > 0.0
    return [(0.0, first), *zip(time[kept].tolist(), value[kept].tolist(), strict=True)]


def format_source(naming: Naming, source: Source) -> list[str]:
    """Card of a source of one node."""
    pairs = corners(source)
    head = "v" if source.quantity == "voltage" else "i"
    ends = (source.node, GROUND) if head == "v" else (GROUND, source.node)
    words = [head + naming.text(source.name), *map(naming.node, ends), "dc", repr(pairs[0][1])]
    if len(pairs) > 1:
        vertices = [f"{t!r} {v!r}" for t, v in pairs]
        words += ["pwl(" + vertices[0], *vertices[1:-1], vertices[-1] + ")"]
    return wrap(words)
