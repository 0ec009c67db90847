"""The Spectre dialect, in Spectre's own language.

A line is `name (nodes) master parameter=value`, and a behavioural current is a `bsource`. Written to the
Spectre Circuit Simulator Reference: the current of `bsource`, `isource` and `vccs` leaves the first node,
passes the device and enters the second; powers are `**`, `ln` is the natural logarithm. Names are
letters, digits and `_` (`netlists.naming`, style `underscore`); `//` begins a comment, `+` continues a
line. Not run here.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any

from circuits.circuit import GROUND
from circuits.devices import Capacitor, ControlledSource, Diode, OperationalAmplifier, Resistor, Source
from circuits.devices.device import Device
from circuits.silicon.process import Polarity
from netlists.dialects.spice import Syntax, corners, diode_figures, ekv_transistors, format_amplifier
from netlists.naming import make_naming
from netlists.read.notes.syntax import SpectreSyntax
from netlists.write.bsim3 import Form, make_cards, make_transistors
from netlists.write.deck import NOT_RUN, Control, Writer, no_control, wrap
from netlists.write.dialect import make_dialect, make_formatter, no_cards
from netlists.write.traversal import Definition

# words of the language and its functions, as names of nodes or definitions
_RESERVED = frozenset({
    "gnd", "ground", "time", "temp", "tnom", "temper", "freq", "scale", "if", "else", "end", "ends",
    "for", "to", "true", "false", "subckt", "inline", "parameters", "model", "global", "include",
    "ahdl_include", "library", "section", "simulator", "lang", "analog", "statistics", "correlate",
    "vary", "truncate", "real", "integer", "string", "function", "return", "export", "import", "save",
    "ic", "nodeset", "info", "paramset", "paramtest", "altergroup", "alter", "sweep", "montecarlo",
    "options", "tran", "dc", "ac", "noise", "pz", "sp", "xf", "tdr", "envlp", "hb", "pss", "march",
    "plot", "print", "sens", "title", "vector", "abs", "acos", "acosh", "asin", "asinh", "atan",
    "atan2", "atanh", "ceil", "cos", "cosh", "exp", "floor", "hypot", "int", "ln", "log", "log10",
    "max", "min", "pow", "sin", "sinh", "sqrt", "tan", "tanh", "v", "i",
})  # fmt: skip
_METHODS = {"gear": "gear2only", "trap": "traponly"}
_OF_DIODE = {"bv": "bvj", "nbv": "nz"}  # words of breakdown; the others are SPICE's

_NAMING = make_naming("underscore", _RESERVED)


def _current(name: str, start: str, end: str, expression: str) -> list[str]:
    return [f"b{name} ({start} {end}) bsource i={expression.replace('^', '**')}"]


def _charge(name: str, a: str, b: str, value: float) -> str:
    return f"c{name} ({a} {b}) capacitor c={value!r}"


def _element(letter: str, device: Device, master: str) -> str:
    nodes = " ".join(map(_NAMING.node, device.terminals()))
    return f"{letter}{_NAMING.plain(device.name)} ({nodes}) {master}"


_SYNTAX = Syntax("spectre", _NAMING, _current, no_control, capacitor=_charge)


def _card(name: str, polarity: Polarity, parameters: Sequence[str]) -> list[str]:
    return wrap(["model", name, "bsim3v3", f"type={polarity}", "version=3.3", *parameters])


def _mos(name: str, nodes: Sequence[str], model: str, parameters: Sequence[str]) -> list[str]:
    return wrap([name, f"({' '.join(nodes)})", model, *parameters])


_BSIM3 = Form(_NAMING, _card, _mos, instance=False)


def _capacitor(device: Capacitor) -> list[str]:
    begin = "" if device.ic is None else f" ic={float(device.ic)!r}"
    return [_element("c", device, f"capacitor c={float(device.capacitance)!r}{begin}")]


def _diode(device: Diode) -> list[str]:
    model = _NAMING.part(device.name, "model")
    pairs = (figure.partition("=") for figure in diode_figures(device))
    figures = [f"{_OF_DIODE.get(word, word)}={value}" for word, _, value in pairs]
    line = f"{_element('d', device, model)} area={float(device.area)!r}"
    return [line, *wrap(["model", model, "diode", "level=1", *figures])]


def _source(device: Source) -> list[str]:
    pairs = corners(device)
    head = "v" if device.quantity == "voltage" else "i"
    ends = (device.node, GROUND) if head == "v" else (GROUND, device.node)
    name, nodes = head + _NAMING.text(device.name), " ".join(map(_NAMING.node, ends))
    direct = pairs[0][1] if device.direct is None else float(device.direct)
    words = [name, f"({nodes})", f"{head}source", f"dc={direct!r}"]
    if len(pairs) > 1:
        words += ["type=pwl", "wave=[", *(f"{t!r} {v!r}" for t, v in pairs), "]"]
    return wrap(words)


_OTHERS: dict[type[Device], Callable[[Any], list[str]]] = {
    Capacitor: _capacitor,
    Diode: _diode,
    Resistor: lambda device: [_element("r", device, f"resistor r={float(device.resistance)!r}")],
    ControlledSource: lambda device: [_element("g", device, f"vccs gm={float(device.transconductance)!r}")],
    OperationalAmplifier: functools.partial(format_amplifier, _SYNTAX),
    Source: _source,
}


def _open(name: str, definition: Definition) -> list[str]:
    return wrap(["subckt", name, *map(_NAMING.node, definition.ports)])


def _call(name: str, nodes: list[str], definition: str) -> list[str]:
    return wrap([name, "(", *nodes, ")", definition])


def _control(control: Control) -> list[str]:
    temperature = repr(control.silicon.temperature_c)
    starts, held = ([f"{name}={v!r}" for name, v in given] for given in (control.starts, control.held))
    tolerances = f"reltol={control.reltol!r} vabstol=1e-6 iabstol=1e-15 gmin=1e-15"
    run = f"stop={control.stop!r} maxstep={control.step!r} method={_METHODS[control.method]}"
    run += " skipdc=yes" if control.uic else ""
    return [
        *(wrap(["nodeset", *starts]) if starts else ()),
        *(wrap(["ic", *held]) if held else ()),
        f"set_up options temp={temperature} tnom={temperature} {tolerances}",
        *wrap(["save", *control.saved]),
        "operating_point dc" if control.analysis == "op" else f"transient tran {run}",
    ]


_WRITER = Writer(
    dialect="spectre",
    remark=NOT_RUN,
    comment="//",
    naming=_NAMING,
    separator=".",
    open=_open,
    close=lambda name: [f"ends {name}"],
    call=_call,
    head=lambda: ["simulator lang=spectre"],
    control=_control,
)


DIALECT = make_dialect(
    _WRITER,
    "bsource elements, or BSIM3; not run here",
    {
        "ekv": (make_formatter("spectre", ekv_transistors(_SYNTAX), _OTHERS), no_cards),
        "bsim3": (make_formatter("spectre", make_transistors(_BSIM3), _OTHERS), make_cards(_BSIM3)),
    },
    syntax=SpectreSyntax,
)
