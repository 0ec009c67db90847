"""The Verilog-A dialect: modules for the laws of devices, for circuits, and for the testbench.

There is a module for each device law in use and for each circuit. Circuits are structural: their devices and
instances are instances of modules, with literal parameters. All
devices have notes, their values and names as we have them. The module `testbench` drives the circuit: a
source with vertices holds its last one and its slope, renewed by a timer at each. Ground is `gnd`, declared
`ground` in each module that has it. A testbench's start voltages and its analysis have no text here but the
note: they belong to the simulator, as the temperature does; the head says so. Written to the Verilog-AMS
Language Reference Manual 2.4. Not run here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from circuits.circuit import GROUND
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode
from circuits.silicon.silicon import Deviation, Silicon
from netlists.dialects.spice import corners
from netlists.naming import make_naming
from netlists.read.notes.syntax import VerilogSyntax
from netlists.verilog_a.law import (
    AMPLIFIER,
    CAPACITOR,
    DIODE,
    MODULES,
    RESISTOR,
    TRANSCONDUCTOR,
    TRANSISTORS,
    module_text,
)
from netlists.write.annotation import Annotation, format_annotation
from netlists.write.bsim3 import total_deviation
from netlists.write.deck import WIDTH, Control, Writer
from netlists.write.dialect import make_dialect, make_formatter
from netlists.write.traversal import Definition, Design

_TESTBENCH, _GROUND = "testbench", "gnd"
_KEYWORDS = {
    "above", "abs", "absdelay", "absdelta", "access", "acos", "acosh", "ac_stim", "aliasparam", "always",
    "analog", "analysis", "and", "asin", "asinh", "assert", "assign", "atan", "atan2", "atanh", "automatic",
    "begin", "branch", "buf", "bufif0", "bufif1", "case", "casex", "casez", "ceil", "cell", "cmos", "config",
    "connect", "connectmodule", "connectrules", "continuous", "cos", "cosh", "cross", "ddt", "ddt_nature",
    "ddx", "deassign", "default", "defparam", "design", "disable", "discipline", "discrete", "domain",
    "driver_update", "edge", "else", "end", "endcase", "endconfig", "endconnectrules", "enddiscipline",
    "endfunction", "endgenerate", "endmodule", "endnature", "endparamset", "endprimitive", "endspecify",
    "endtable", "endtask", "event", "exclude", "exp", "final_step", "flicker_noise", "floor", "flow", "for",
    "force", "forever", "fork", "from", "function", "generate", "genvar", "ground", "highz0", "highz1",
    "hypot", "idt", "idtmod", "idt_nature", "if", "ifnone", "incdir", "include", "inf", "initial",
    "initial_step", "inout", "input", "instance", "integer", "join", "laplace_nd", "laplace_np", "laplace_zd",
    "laplace_zp", "large", "last_crossing", "liblist", "library", "limexp", "ln", "localparam", "log",
    "macromodule", "max", "medium", "merged", "min", "module", "nand", "nature", "negedge", "net_resolution",
    "nmos", "noise_table", "nor", "noshowcancelled", "not", "notif0", "notif1", "or", "output", "parameter",
    "paramset", "pmos", "posedge", "potential", "pow", "primitive", "pull0", "pull1", "pulldown", "pullup",
    "pulsestyle_onevent", "pulsestyle_ondetect", "rcmos", "real", "realtime", "reg", "release", "repeat",
    "resolveto", "rnmos", "rpmos", "rtran", "rtranif0", "rtranif1", "scalared", "showcancelled", "signed",
    "sin", "sinh", "slew", "small", "specify", "specparam", "split", "sqrt", "string", "strong0", "strong1",
    "supply0", "supply1", "table", "tan", "tanh", "task", "time", "timer", "tran", "tranif0", "tranif1",
    "transition", "tri", "tri0", "tri1", "triand", "trior", "trireg", "units", "unsigned", "use", "uwire",
    "vectored", "wait", "wand", "weak0", "weak1", "while", "white_noise", "wire", "wor", "wreal", "xnor",
    "xor", "zi_nd", "zi_np", "zi_zd", "zi_zp", "electrical",
}  # fmt: skip
_NAMING = make_naming("underscore", frozenset({*_KEYWORDS, *MODULES, _TESTBENCH, _GROUND}))


def _transistor(device: Transistor, silicon: Silicon, deviation: Deviation) -> list[str]:
    size = {"w": device.width, "l": device.length, "m": device.multiplicity}
    total = total_deviation(silicon, device.polarity, deviation)
    own = (
        {"delta_v_t0": float(total.v_t0), "delta_beta": float(total.beta)} if total.v_t0 or total.beta else {}
    )
    return _instance("m", device, TRANSISTORS[device.polarity], size | own)


def _capacitor(device: Capacitor) -> list[str]:
    return [*_note("capacitor", device), *_instance("c", device, CAPACITOR, {"c": device.capacitance})]


def _resistor(device: Resistor) -> list[str]:
    return [*_note("resistor", device), *_instance("r", device, RESISTOR, {"r": device.resistance})]


def _diode(device: Diode) -> list[str]:
    return _instance("d", device, DIODE, device.parameters())


def _transconductor(device: ControlledSource) -> list[str]:
    parameters = {"gm": device.transconductance}
    return [*_note("transconductor", device), *_instance("g", device, TRANSCONDUCTOR, parameters)]


def _amplifier(device: OperationalAmplifier) -> list[str]:
    parameters = {"gain": device.gain, "resistance": device.output_resistance, "offset": device.offset}
    return _instance("u", device, AMPLIFIER, parameters)


def _source(device: Source) -> list[str]:
    """Contributions inside the testbench's analog block."""
    pairs, node = corners(device), format_node(device.node)
    branch = f"V({node}, {_GROUND})" if device.quantity == "voltage" else f"I({_GROUND}, {node})"
    if len(pairs) == 1:
        return [f"    {branch} <+ {pairs[0][1]!r};"]
    lines = [f"    begin : {device.quantity[0]}{_NAMING.text(device.name)}", "      real t0, v0, slope;"]
    for k, (time, value) in enumerate(pairs):
        after = pairs[k + 1] if k + 1 < len(pairs) else (time + 1.0, value)
        slope = (after[1] - value) / (after[0] - time)
        when = f"timer({time!r})" if k else "initial_step"
        lines.append(f"      @({when}) begin t0 = {time!r}; v0 = {value!r}; slope = {slope!r}; end")
    return [*lines, f"      {branch} <+ v0 + slope * ($abstime - t0);", "    end"]


def format_node(reference: str) -> str:
    """Name of a node, ground included."""
    return _GROUND if reference == GROUND else _NAMING.node(reference)


def _note(kind: str, device: Device) -> list[str]:
    return format_annotation(Annotation(kind, device), "//")


def _instance(letter: str, device: Device, module: str, parameters: Mapping[str, float]) -> list[str]:
    given = ", ".join(f".{name}({float(value)!r})" for name, value in parameters.items())
    nodes = ", ".join(map(format_node, device.terminals()))
    return [f"  {module} #({given}) {letter}{_NAMING.plain(device.name)}({nodes});"]


def _open(name: str, definition: Definition) -> list[str]:
    used = [t for device, _ in definition.devices for t in device.terminals()]
    used += [n for calls in definition.calls for call in calls for n in call.nodes]
    used += [n for device in definition.parasitics for n in device.terminals()]
    inner = [n for n in dict.fromkeys(used) if n not in definition.ports]
    return _module(name, [_NAMING.node(p) for p in definition.ports], inner)


def _module(name: str, ports: list[str], inner: Iterable[str]) -> list[str]:
    """First lines of a module: ports and nodes, ground declared where it is used."""
    nodes = [format_node(n) for n in inner]
    return [
        *format_list(f"module {name}(", ports, ");", ""),
        *(format_list("inout ", ports, ";") if ports else ()),
        *(format_list("electrical ", [*ports, *nodes], ";") if ports or nodes else ()),
        *([f"  ground {_GROUND};"] if _GROUND in nodes else ()),
    ]


def format_list(head: str, names: list[str], end: str, indent: str = "  ") -> list[str]:
    """Names behind a head with commas between them, in lines of about `WIDTH` characters."""
    lines, line = [], indent + head
    for k, name in enumerate(names):
        word = name + ("," if k + 1 < len(names) else end)
        if len(line) + len(word) >= WIDTH:
            lines.append(line.rstrip())
            line = "   "
        line += word if line.endswith(("(", " ")) else f" {word}"
    return [*lines, line if names else line + end]


def _close(name: str) -> list[str]:
    return ["endmodule"]


def _call(name: str, nodes: list[str], definition: str) -> list[str]:
    return format_list(f"{definition} {name}(", [_GROUND if n == GROUND else n for n in nodes], ");")


def _top(name: str, nodes: list[str], definition: str) -> list[str]:
    head = [
        f"module {_TESTBENCH};",
        *format_list("electrical ", [*nodes, _GROUND], ";"),
        f"  ground {_GROUND};",
    ]
    return [*head, *_call(name, nodes, definition), "  analog begin"]


def _control(control: Control) -> list[str]:
    return ["  end", "endmodule"]


def _modules(silicon: Silicon, design: Design) -> list[str]:
    """Modules of the devices that a design has."""
    lines = []
    for name in sorted(
        {_module_of(d) for each in design.definitions for d, _ in each.devices} | _loads(design)
    ):
        lines += module_text(name, silicon).splitlines()
    return lines


def _loads(design: Design) -> set[str]:
    return {CAPACITOR for each in design.definitions if each.parasitics}


def _module_of(device: Device) -> str:
    if isinstance(device, Transistor):
        return TRANSISTORS[device.polarity]
    return _MODULE_OF[type(device)]


_HEAD = (
    "// transistors take the simulator's $temperature, or a temperature_c of their own; sources of biases",
    "// stay those of the temperature above; channels, junctions and resistors make noise",
)
_MODULE_OF: dict[type[Device], str] = {
    Capacitor: CAPACITOR,
    Resistor: RESISTOR,
    Diode: DIODE,
    ControlledSource: TRANSCONDUCTOR,
    OperationalAmplifier: AMPLIFIER,
}
_WRITER = Writer(
    dialect="verilog-a",
    remark="not run here: written to the language's manual",
    comment="//",
    naming=_NAMING,
    separator=".",
    open=_open,
    close=_close,
    call=_call,
    head=lambda: [*_HEAD, '`include "disciplines.vams"'],
    control=_control,
    top=_top,
)

_FORMATTER = make_formatter(
    "verilog-a",
    _transistor,
    {
        Capacitor: _capacitor,
        Resistor: _resistor,
        Diode: _diode,
        ControlledSource: _transconductor,
        OperationalAmplifier: _amplifier,
        Source: _source,
    },
)

DIALECT = make_dialect(
    _WRITER,
    "the laws as modules, circuits structural; not run here",
    {"ekv": (_FORMATTER, _modules)},
    syntax=VerilogSyntax,
)
