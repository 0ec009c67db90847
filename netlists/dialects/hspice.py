r"""HSPICE: behavioural currents are G elements with `cur='...'`, since B elements are IBIS buffers.

Written to the HSPICE User Guide: simulation and analysis: `log` is the natural logarithm and `**` the power;
a line has at most 1,024 characters, and an expression goes on after `\\` at the end of the line. Largest time
step: option `delmax`. Not run here.
"""

from __future__ import annotations

import re

from netlists.dialects.spice import Syntax, analysis_card, mos_form, spice_dialect, tolerances
from netlists.naming import make_naming
from netlists.write.deck import Control, wrap

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


def _control(control: Control) -> list[str]:
    temperature = repr(control.silicon.temperature_c)
    options = f".option {tolerances(control.models)} reltol={control.reltol!r} method={control.method}"
    return [
        f".temp {temperature}",
        f"{options} tnom={temperature} delmax={control.step!r} post=2 ingold=2",
        *wrap([".probe", control.analysis, *(f"v({name})" for name in control.saved)]),
        analysis_card(control),
    ]


_NAMING = make_naming("underscore", _RESERVED)

DIALECT = spice_dialect(
    Syntax("hspice", _NAMING, _current, _control, diode=("d", "level=1")),
    "G elements with cur='...', or BSIM3; not run here",
    mos_form(_NAMING, "level=49", "version=3.3", instance=True),
)
