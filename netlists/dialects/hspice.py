r"""HSPICE: behavioural currents are G elements with `cur='...'`, since B elements are IBIS buffers.

Written to the HSPICE User Guide: simulation and analysis: `log` is the natural logarithm and `**` the power;
a line has at most 1,024 characters, and an expression goes on after `\\` at the end of the line. Largest time
step: option `delmax`. Not run here.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from circuits.silicon.process import Polarity
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.dialects.spice import Syntax, format_mos, make_formatter, make_writer, tolerances
from netlists.naming import make_naming
from netlists.registry import Dialect, Settings
from netlists.write.bsim3 import Form, make_cards, make_transistors
from netlists.write.deck import Control, format_deck, format_voltages, no_cards, wrap

_RESERVED = frozenset({"gnd", "ground", "time", "temper", "hertz"})
_WIDTH = 1000
_BREAK = re.compile(r"(?<=[?:*/])")  # an expression may go on after these; a line with `*` first is a comment


def _current(name: str, start: str, end: str, expression: str) -> list[str]:
    # cut while a power is still one letter, so that it stays in one piece
    pieces = _BREAK.split(expression.replace("ln(", "log("))
    lines, line = [], f"g{name} {start} {end} cur='"
    for piece in (p.replace("^", "**") for p in pieces):
        if len(line) + len(piece) >= _WIDTH:
            lines.append(line + "\\\\")
            line = ""
        line += piece
    return [*lines, line + "'"]


def _card(name: str, polarity: Polarity, parameters: Sequence[str]) -> list[str]:
    return wrap([".model", name, f"{polarity}mos", "level=49", "version=3.3", *parameters])


def _control(control: Control) -> list[str]:
    temperature, step = repr(control.silicon.temperature_c), repr(control.step)
    options = f".option {tolerances(control.models)} reltol={control.reltol!r} method={control.method}"
    uic = " uic" if control.uic else ""
    return [
        *format_voltages(".nodeset", control.starts),
        *format_voltages(".ic", control.held),
        f".temp {temperature}",
        f"{options} tnom={temperature} delmax={step} post=2 ingold=2",
        *wrap([".probe", control.analysis, *(f"v({name})" for name in control.saved)]),
        ".op" if control.analysis == "op" else f".tran {step} {control.stop!r}{uic}",
        ".end",
    ]


_NAMING = make_naming("underscore", _RESERVED)
_SYNTAX = Syntax("hspice", _NAMING, _current, _control)
_WRITER = make_writer(_SYNTAX)

_BSIM3 = Form(_NAMING, _card, format_mos, instance=True)

format_device = make_formatter(_SYNTAX)


def write(testbench: Testbench, silicon: Silicon, settings: Settings, title: str | None = None) -> str:
    """Complete netlist of a testbench; raises `ParameterError` for models that HSPICE's text lacks."""
    formatter = DIALECT.formatter(settings.models)
    cards = make_cards(_BSIM3, silicon) if settings.models == "bsim3" else no_cards
    return format_deck(_WRITER, formatter, cards, testbench, silicon, settings, title)


DIALECT = Dialect(
    name="hspice",
    summary="G elements with cur='...', or BSIM3; not run here",
    runs=False,
    comment="*",
    naming=_NAMING,
    devices={"ekv": format_device, "bsim3": make_formatter(_SYNTAX, make_transistors(_BSIM3))},
    write=write,
)
