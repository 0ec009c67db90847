"""ngspice text of a testbench: one `.subckt` a definition, EKV transistors as B sources, constants folded.

Names. ngspice ignores case, and a node array has no form of its own: `v_mem[3]` is written `v_mem#3`,
`w[1,2]` is `w#1#2`. Our names have no `#`, so nothing collides and `node_path` reads them back. Names that
ngspice gives a meaning wherever they stand (`gnd`, `time`, `limit`, ...) get a `#` at the end. An instance
`neuron[2]` is `xneuron#2` and a device `mi5` is `bmi5` or `rmi5`, its capacitances `cmi5#gb` and so on.
Node `neuron[2].v_r` of circuit `chip` is known to a run as `xchip.xneuron#2.v_r`, ports of the chip by their
name alone.

Time. `.tran` stores every accepted point; the largest step is a 2000th of the run unless given. Defaults
(gear, reltol 1e-5, trtol 1, gmin 1e-15) put a rebound neuron's spike within 0.2 us of the converged time;
ngspice's own are 200 us off.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial, singledispatch
from typing import Literal

import numpy as np

from circuits.circuit import GROUND, split_reference
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.source import polyline
from circuits.devices.transistor import capacitances
from circuits.errors import TopologyError
from circuits.silicon import Deviation, Silicon
from circuits.testbench import Testbench
from netlists import law
from netlists.traversal import Call, Definition, element, split_path, to_design

DEFAULT_RELTOL = 1e-5
POINTS = 2000  # steps at least in a run, unless tmax is given

Method = Literal["gear", "trap"]
Analysis = Literal["tran", "op"]

_TOLERANCES = "gmin=1e-15 abstol=1e-15 chgtol=1e-17 trtol=1.0"
_WIDTH = 100
# gnd is ground; time is the axis of a run; the others crash ngspice's parser inside v(...)
_RESERVED = frozenset({"gnd", "time", "temper", "hertz", "limit", "agauss", "aunif", "gauss", "unif"})
_TERMINALS = "dgsb"
_NONE = Deviation(0.0, 0.0)


def format_testbench(
    testbench: Testbench,
    silicon: Silicon,
    title: str | None = None,
    *,
    analysis: Analysis = "tran",
    reltol: float = DEFAULT_RELTOL,
    tmax: float | None = None,
    method: Method = "gear",
    nodes: Iterable[str] | None = None,
) -> str:
    """Complete deck of a testbench, the same text for the same input.

    Parameters
    ----------
    testbench
        Circuit, sources and stop time; `start` becomes `.nodeset`.
    silicon
        Process and temperature; every law is applied here, the deck has literal numbers only.
    title
        What the first line begins with; the testbench's title by default. Die and temperature follow.
    analysis
        `tran` up to the stop time, or `op` with the sources as they are at time 0.
    reltol, method
        ngspice's options.
    tmax
        Largest step, s; a 2000th of the stop time by default.
    nodes
        Paths of the nodes to save; all by default.

    Raises
    ------
    TopologyError
        Two names of one circuit, or of two sources, differ in case only.
    """
    design = to_design(testbench, silicon)
    top = design.top
    step = testbench.stop / POINTS if tmax is None else tmax
    call = Call(top.name, (), top.name, top.ports)
    saved = [f"v({run_name(path, top)})" for path in (design.nodes if nodes is None else nodes)]
    starts = [f"v({run_name(path, top)})={v!r}" for path, v in sorted(testbench.start.items())]
    lines = [
        _title(title or testbench.title, testbench.circuit.name, silicon),
        *(line for definition in design.definitions for line in _definition(definition, silicon)),
        *_wrap(_call(call)),
        *(line for source in design.sources for line in format_device(source, silicon)),
        *(_wrap([".nodeset", *starts]) if starts else ()),
        f".options temp={silicon.temperature_c!r} tnom={silicon.temperature_c!r}",
        f".options {_TOLERANCES} reltol={reltol!r} method={method}",
        *_wrap([".save", *saved]),
        ".op" if analysis == "op" else f".tran {step!r} {testbench.stop!r} 0 {step!r}",
        ".end",
    ]
    return "\n".join(lines) + "\n"


def node_name(reference: str) -> str:
    """Name in ngspice of one of our node references: `v_mem[3]` is `v_mem#3`."""
    if reference == GROUND:
        return reference
    name, index = split_reference(reference)
    return "#".join((name, *map(str, index))) + ("#" if not index and name.lower() in _RESERVED else "")


def run_name(path: str, top: Definition) -> str:
    """Name, in lower case, by which a run of circuit `top` knows the node at `path`."""
    *instances, node = (node_name(element(*part)) for part in split_path(path))
    if path in top.ports:
        return node.lower()
    return ".".join(["x" + node_name(top.name), *("x" + name for name in instances), node]).lower()


def node_path(name: str) -> str:
    """Our path of a node by its name in a run, in lower case; the inverse of `run_name`."""
    *instances, node = name.split(".")
    return ".".join(_reference(part) for part in (*(i.removeprefix("x") for i in instances[1:]), node))


@singledispatch
def format_device(device: Device, silicon: Silicon, deviation: Deviation = _NONE) -> list[str]:
    """Element lines of one device, deviating by what its place on the die adds to it."""
    raise TypeError(f"{type(device).__name__}: no lowering to ngspice text")


@format_device.register
def _(device: Transistor, silicon: Silicon, deviation: Deviation = _NONE) -> list[str]:
    model = silicon.process.model(device.polarity)
    shared = silicon.law(device.polarity)
    at = replace(
        shared,
        v_t0=float(shared.v_t0 + deviation.v_t0),
        square_current=float(shared.square_current * (1.0 + deviation.beta)),
    )
    drain, _, source, bulk = device.terminals()
    current = partial(_current, reverse=device.polarity == "p")
    lines = [current(device.name, drain, source, law.channel_current(device, at, _difference))]
    if at.junction_leakage > 0.0:
        for terminal, letter in ((drain, "d"), (source, "s")):
            leak = law.junction_current(device, at, terminal, _difference)
            lines.append(current(f"{device.name}#{letter}b", terminal, bulk, leak))
    size = (np.array([device.width]), np.array([device.length]), np.array([device.multiplicity]))
    for (i, j), value in capacitances(model, *size).items():
        a, b = device.terminals()[i], device.terminals()[j]
        if a != b:
            suffix = f"#{_TERMINALS[i]}{_TERMINALS[j]}"
            lines.append(_element("c", device.name + suffix, (a, b), float(value[0])))
    return lines


@format_device.register
def _(device: Capacitor, silicon: Silicon, deviation: Deviation = _NONE) -> list[str]:
    return [_element("c", device.name, device.terminals(), device.capacitance)]


@format_device.register
def _(device: Resistor, silicon: Silicon, deviation: Deviation = _NONE) -> list[str]:
    return [_element("r", device.name, device.terminals(), device.resistance)]


@format_device.register
def _(device: ControlledSource, silicon: Silicon, deviation: Deviation = _NONE) -> list[str]:
    return [_element("g", device.name, device.terminals(), device.transconductance)]


@format_device.register
def _(device: OperationalAmplifier, silicon: Silicon, deviation: Deviation = _NONE) -> list[str]:
    up, down = law.amplifier_currents(device, _difference)
    return [
        _current(f"{device.name}#up", device.output, device.vdd, up),
        _current(f"{device.name}#down", device.output, device.vss, down),
    ]


@format_device.register
def _(device: Source, silicon: Silicon, deviation: Deviation = _NONE) -> list[str]:
    """Write a source whose vertices before time 0 are cut off there: ngspice starts at 0."""
    time, value = polyline(device.name, device.waveform)
    first = float(np.interp(0.0, time, value))
    kept = time > 0.0
    pairs = [(0.0, first), *zip(time[kept].tolist(), value[kept].tolist(), strict=True)]
    head = "v" if device.quantity == "voltage" else "i"
    ends = (device.node, GROUND) if head == "v" else (GROUND, device.node)
    words = [head + _identifier(device.name), *map(node_name, ends), "dc", repr(first)]
    if len(pairs) > 1:
        corners = [f"{t!r} {v!r}" for t, v in pairs]
        words += ["pwl(" + corners[0], *corners[1:-1], corners[-1] + ")"]
    return _wrap(words)


def _title(what: str, circuit: str, silicon: Silicon) -> str:
    """First line of a deck; `what` is folded into one line."""
    place = "" if silicon.place is None else " at " + "/".join(element(*part) for part in silicon.place)
    made = f"process {silicon.process.name}, {silicon.die}, temperature {silicon.temperature_c!r} degC"
    return f"* {' '.join(what.split())}: circuit {circuit}{place}, {made}"


def _definition(definition: Definition, silicon: Silicon) -> list[str]:
    name = node_name(definition.name)
    lines = _wrap([".subckt", name, *map(node_name, definition.ports)])
    for device, deviation in definition.devices:
        lines += format_device(device, silicon, deviation)
    for call in definition.calls:
        lines += _wrap(_call(call))
    return [*lines, f".ends {name}"]


def _call(call: Call) -> list[str]:
    name = node_name(element(call.name, call.index))
    return [f"x{name}", *map(node_name, call.nodes), node_name(call.definition)]


def _current(name: str, start: str, end: str, expression: str, *, reverse: bool = False) -> str:
    """B source whose current leaves node `start`, passes the source and enters node `end`."""
    ends = (end, start) if reverse else (start, end)
    return f"b{name} {' '.join(map(node_name, ends))} i={expression}"


def _element(letter: str, name: str, terminals: tuple[str, ...], value: float) -> str:
    return f"{letter}{name} {' '.join(map(node_name, terminals))} {value!r}"


def _difference(a: str, b: str) -> str:
    """Voltage from node `b` to node `a`."""
    if a == b:
        return law.ZERO
    if b == GROUND:
        return f"v({node_name(a)})"
    return f"(-v({node_name(b)}))" if a == GROUND else f"v({node_name(a)},{node_name(b)})"


def _identifier(name: str) -> str:
    """Name of a source: an array's element, or free text whose odd characters become `#` and their code."""
    try:
        return node_name(name)
    except TopologyError:
        return "".join(c if c.isascii() and (c.isalnum() or c == "_") else f"#{ord(c):02x}" for c in name)


def _reference(part: str) -> str:
    name, *index = part.split("#")
    return element(name, tuple(int(k) for k in index if k))


def _wrap(words: list[str]) -> list[str]:
    """One card of `words` in lines of about 100 characters, continued by `+`."""
    lines, line = [], words[0]
    for word in words[1:]:
        if len(line) + len(word) >= _WIDTH:
            lines.append(line)
            line = "+"
        line += f" {word}"
    return [*lines, line]
