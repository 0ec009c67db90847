"""The Xyce dialect: transistors are B sources, with `{}` around expressions.

Written to the Xyce Reference Guide (release 7). Powers are `**`, since `^` is exclusive or; expressions know
`ln`, `a ? b : c` and `max`. Nodes of sub-circuits stand behind `:`. Temperature and gmin are options of the
device package, tolerances of the time integrator. Diodes are of level 2, which has NBV. Not run here.
"""

from __future__ import annotations

from netlists.dialects.spice import Syntax, analysis_card, mos_form, spice_dialect
from netlists.naming import make_naming
from netlists.write.deck import Control, wrap

_RESERVED = frozenset({"gnd", "time", "temp", "temper", "freq", "hertz", "vt", "pi", "gmin"})


def _current(name: str, start: str, end: str, expression: str) -> list[str]:
    return [f"b{name} {start} {end} i={{{expression.replace('^', '**')}}}"]


def _control(control: Control) -> list[str]:
    temperature, step = repr(control.silicon.temperature_c), repr(control.step)
    printed = "dc" if control.analysis == "op" else "tran"
    return [
        f".options device temp={temperature} tnom={temperature} gmin=1e-15",
        f".options timeint method={control.method} reltol={control.reltol!r} abstol=1e-9",
        *wrap([".print", printed, *(f"v({name})" for name in control.saved)]),
        analysis_card(control, "0", step),
    ]


_NAMING = make_naming("underscore", _RESERVED)

DIALECT = spice_dialect(
    Syntax("xyce", _NAMING, _current, _control, separator=":", diode=("d", "level=2")),
    "B sources, or BSIM3; not run here",
    mos_form(_NAMING, "level=9", "version=3.3", instance=False),
)
