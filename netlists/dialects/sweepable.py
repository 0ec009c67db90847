"""Transistors that a simulator sweeps: a sub-circuit a polarity, with temperature and sizes left open.

The law is that of `netlists.write.law`. Where the other text has a number at one temperature, this one has an
expression of `temper`, the simulator's own temperature in degC, so that `.temp` and `.dc temp` move the
transistors as the solver does. A call has the parameters `w`, `l` (m), `parallel` (devices), `delta_v_t0` (V,
of the magnitude) and `delta_beta` (relative), and what the die does to a device is in the last two. With T
over the nominal temperature T_0, both in kelvin:

    U_T = U_T0 T / T_0,   V_T0 = V_T00 + drift (T - T_0),   I_S = I_S0 (T / T_0)^(2 + exponent)
    J = J_0 2^((T - T_0) / doubling)

Numbers of a process that follow the size are refused: `netlists.write.bsim3.refuse_sizes`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from circuits.devices import Transistor
from circuits.devices.transistor import capacitances
from circuits.silicon.process import (
    Polarity,
    TransistorAtTemperature,
    TransistorModel,
    at_temperature,
    kelvin,
)
from circuits.silicon.silicon import Deviation, Silicon
from netlists.dialects.spice import TERMINALS, Syntax, law_lines
from netlists.write.bsim3 import refuse_sizes, total_deviation
from netlists.write.deck import wrap
from netlists.write.dialect import Cards, Transistors
from netlists.write.traversal import Design

CELLS: dict[Polarity, str] = {"n": "noctule_nfet", "p": "noctule_pfet"}
_NODES = tuple(TERMINALS)
_DEFAULTS = "w=1e-06 l=1e-06 parallel=1 delta_v_t0=0 delta_beta=0"


Operator = Callable[["Symbol", object], "Symbol"]


def _operators(sign: str) -> tuple[Operator, Operator]:
    """What a sign means between a symbol and another number, and between another number and a symbol."""
    return lambda one, other: _joined(one, sign, other), lambda one, other: _joined(other, sign, one)


@dataclass(frozen=True, slots=True, repr=False)
class Symbol:
    """A number that is known as text only; sums, products and powers of it are text again."""

    text: str

    def __repr__(self) -> str:
        """Return the text, as of a float its digits."""
        return self.text

    def __neg__(self) -> Symbol:
        """Return the number with its sign turned."""
        return Symbol(f"(-{self.text})")

    __add__, __radd__ = _operators("+")
    __sub__, __rsub__ = _operators("-")
    __mul__, __rmul__ = _operators("*")
    __truediv__, __rtruediv__ = _operators("/")
    __pow__, __rpow__ = _operators("^")


class _Cell(NamedTuple):
    """The one transistor of a sub-circuit, whose sizes are text."""

    polarity: Polarity
    name: str
    drain: str
    gate: str
    source: str
    bulk: str
    width: Symbol
    length: Symbol
    multiplicity: Symbol

    def terminals(self) -> tuple[str, ...]:
        """The nodes drain, gate, source and bulk."""
        return self.drain, self.gate, self.source, self.bulk


def sweepable(syntax: Syntax) -> tuple[Transistors, Cards]:
    """Give how a dialect with `temper` calls transistors as sub-circuits, and what writes these."""

    def transistor(device: Transistor, silicon: Silicon, deviation: Deviation) -> list[str]:
        total = total_deviation(silicon, device.polarity, deviation)
        size = {"w": device.width, "l": device.length, "parallel": device.multiplicity}
        made = {"delta_v_t0": total.v_t0, "delta_beta": total.beta} if total.v_t0 or total.beta else {}
        values = (f"{name}={float(value)!r}" for name, value in (size | made).items())
        nodes = map(syntax.naming.node, device.terminals())
        return wrap([f"x{syntax.naming.plain(device.name)}", *nodes, CELLS[device.polarity], *values])

    def cards(silicon: Silicon, design: Design) -> list[str]:
        refuse_sizes(silicon, "sweepable transistors")
        devices = (device for each in design.definitions for device, _ in each.devices)
        used = sorted({device.polarity for device in devices if isinstance(device, Transistor)})
        head = [
            "* transistors follow temper, as .dc temp and .temp move it, and their w, l and parallel;",
            f"* all else stays: sources of biases are those of {silicon.temperature_c!r} degC",
        ]
        return head + [line for polarity in used for line in _definition(syntax, silicon, polarity)]

    return transistor, cards


def _definition(syntax: Syntax, silicon: Silicon, polarity: Polarity) -> list[str]:
    """The sub-circuit of a polarity's transistors."""
    model = silicon.process.model(polarity)
    sizes = (Symbol(f"{{{name}}}") for name in ("w", "l", "parallel"))
    cell: Any = _Cell._make((polarity, "m", *_NODES, *sizes))
    leaks = model.junction_leakage > 0.0 or model.gate_induced_leakage > 0.0
    name = CELLS[polarity]
    return [
        *wrap([".subckt", name, *_NODES, *_DEFAULTS.split()]),
        *law_lines(syntax, cell, _law(silicon, model), leaks=leaks),
        *_capacitors(syntax, model),
        f".ends {name}",
    ]


def _law(silicon: Silicon, model: TransistorModel) -> TransistorAtTemperature:
    """The law of a model as text of `temper` and of what a call says of its die."""
    nominal = silicon.process.nominal_temperature_c
    law: Any = at_temperature(model, silicon.process, nominal)
    rise = Symbol("temper") - nominal
    ratio = (Symbol("temper") - (nominal - kelvin(nominal))) / kelvin(nominal)
    made = Symbol("({delta_beta})") + 1.0
    leakage = law.junction_leakage
    swept: TransistorAtTemperature = replace(
        law,
        u_t=law.u_t * ratio,
        v_t0=law.v_t0 + rise * model.v_t0_drift + Symbol("({delta_v_t0})"),
        square_current=law.square_current * made * ratio ** (2.0 + model.mobility_exponent),
        junction_leakage=leakage * 2.0 ** (rise / model.leakage_doubling) if leakage > 0.0 else leakage,
    )
    return swept


def _capacitors(syntax: Syntax, model: TransistorModel) -> list[str]:
    """Capacitances between the terminals, whose sizes the call says."""
    size: Any = [np.array([Symbol(name)], dtype=object) for name in ("w", "l", "parallel")]
    return [
        syntax.capacitor(
            syntax.naming.part("m", _NODES[i] + _NODES[j]), _NODES[i], _NODES[j], _braced(value[0])
        )
        for (i, j), value in capacitances(model, *size).items()
    ]


def _braced(value: Any) -> Any:
    """A value that the simulator works out once, before it runs."""
    return Symbol(f"{{{value!r}}}")


def _joined(left: object, sign: str, right: object) -> Symbol:
    return Symbol(f"({_number(left)}{sign}{_number(right)})")


def _number(value: object) -> str:
    """Text of a number as it may stand behind a sign."""
    if isinstance(value, Symbol):
        return value.text
    number = float(value)  # type: ignore[arg-type]
    return repr(number) if number >= 0.0 else f"({number!r})"
