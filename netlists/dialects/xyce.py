"""Xyce: B sources with `{}` around expressions, `**` for powers, nodes of sub-circuits behind `:`.

Written to the Xyce Reference Guide (release 7): expressions know `ln`, `a ? b : c` and `max`; `^` is
exclusive or. Temperature and gmin are options of the device package, tolerances of the time integrator.
Not run here.
"""

from __future__ import annotations

from collections.abc import Sequence

from circuits.silicon.process import Polarity
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.dialects.spice import Syntax, format_mos, make_formatter, make_writer
from netlists.naming import make_naming
from netlists.registry import Dialect, Settings
from netlists.write.bsim3 import Form, make_cards, make_transistors
from netlists.write.deck import Control, format_deck, format_voltages, no_cards, wrap

_RESERVED = frozenset({"gnd", "time", "temp", "temper", "freq", "hertz", "vt", "pi", "gmin"})


def _current(name: str, start: str, end: str, expression: str) -> list[str]:
    return [f"b{name} {start} {end} i={{{expression.replace('^', '**')}}}"]


def _card(name: str, polarity: Polarity, parameters: Sequence[str]) -> list[str]:
    return wrap([".model", name, f"{polarity}mos", "level=9", "version=3.3", *parameters])


def _control(control: Control) -> list[str]:
    temperature, step = repr(control.silicon.temperature_c), repr(control.step)
    uic = " uic" if control.uic else ""
    analysis = "op" if control.analysis == "op" else "tran"
    return [
        *format_voltages(".nodeset", control.starts),
        *format_voltages(".ic", control.held),
        f".options device temp={temperature} tnom={temperature} gmin=1e-15",
        f".options timeint method={control.method} reltol={control.reltol!r} abstol=1e-9",
        *wrap([".print", "dc" if analysis == "op" else "tran", *(f"v({name})" for name in control.saved)]),
        ".op" if analysis == "op" else f".tran {step} {control.stop!r} 0 {step}{uic}",
        ".end",
    ]


_NAMING = make_naming("underscore", _RESERVED)
_SYNTAX = Syntax("xyce", _NAMING, _current, _control, separator=":")
_WRITER = make_writer(_SYNTAX)

_BSIM3 = Form(_NAMING, _card, format_mos, instance=False)

format_device = make_formatter(_SYNTAX)


def write(testbench: Testbench, silicon: Silicon, settings: Settings, title: str | None = None) -> str:
    """Complete netlist of a testbench; raises `ParameterError` for models that Xyce's text lacks."""
    formatter = DIALECT.formatter(settings.models)
    cards = make_cards(_BSIM3, silicon) if settings.models == "bsim3" else no_cards
    return format_deck(_WRITER, formatter, cards, testbench, silicon, settings, title)


DIALECT = Dialect(
    name="xyce",
    summary="B sources, or BSIM3; not run here",
    runs=False,
    comment="*",
    naming=_NAMING,
    devices={"ekv": format_device, "bsim3": make_formatter(_SYNTAX, make_transistors(_BSIM3))},
    write=write,
)
