"""The nonlinear laws of devices as text of expressions, with constants folded into literal numbers.

The equations are those of `circuits.devices.transistor` and `circuits.devices.operational_amplifier` at one
temperature; a dialect says how it writes the voltage between two nodes. All dialects here share
`+ - * / ^`, `a?b:c` and `ln exp sqrt abs max min tanh`; those that write `**` or `log` change the text.

ngspice's `exp` saturates at 1e99 and `ln(1 + y)` loses its digits for small y, so that `ln(1 + e^x)` has
branches: `e^x (1 - e^x / 2)` below -12 (relative error e^-24 / 3 = 1e-11) and `x` above 37 (error e^-37).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

from circuits.devices.operational_amplifier import OperationalAmplifier
from circuits.devices.transistor import INDUCED_LIMIT, Transistor
from circuits.silicon.process import TransistorAtTemperature

Difference = Callable[[str, str], str]  # text of the voltage between two nodes, ZERO for a node and itself
Softplus = Callable[[str], str]  # text of ln(1 + e^x)

ZERO = "0.0"
_JUNCTION_LIMIT = 20.0  # U_T of forward bias, where a junction's exponential goes on as its tangent


def softplus(x: str) -> str:
    """`ln(1 + e^x)` with relative error below 1e-9 wherever it is above 1e-40."""
    return f"({x}<-12?exp({x})*(1-0.5*exp({x})):({x}>37?{x}:ln(1+exp({x}))))"


class Channel(NamedTuple):
    """Current of a channel, and what stands in it several times as the voltage of a node.

    A simulator derives an expression anew by each voltage in it, and wherever it is nested in another: with
    the pinch-off voltage inside, ngspice takes three times as long for a transistor with second-order
    effects, and with `u` and the mobility inside 1.2 to 2.8 times for blocks of such; so do powers, which are
    products here. A node's voltage may be anything on the way to a solution, where `u` below zero would be a
    current that grows.

    Attributes
    ----------
    terms
        Value of each node by its tag, none where the law is simple: `vp`, the pinch-off voltage to the bulk,
        V; `fx` and `rx`, `x` of source and drain; `f` and `r`, `u = ln(1 + e^x)`, whose squares are the
        forward and the reverse current over I_S; `m`, the mobility over that of a weak field.
    current
        Current from drain to source, A (nFET), or from source to drain (pFET).
    """

    terms: Mapping[str, str]
    current: str


def channel_current(
    device: Transistor,
    law: TransistorAtTemperature,
    difference: Difference,
    held: Callable[[str], str],
    form: Softplus = softplus,
) -> Channel:
    """Current of a channel; `held` gives the text of the voltage of the node with a tag."""
    drain, gate, source, _ = device.terminals()
    u_gate, u_source, u_drain = (_to_bulk(device, t, difference) for t in (gate, source, drain))
    terms: dict[str, str] = {}
    pinch_off = None
    of_second_order = law.gamma > 0.0 or law.mobility_reduction > 0.0
    if of_second_order:
        terms["vp"], pinch_off = _pinch_off(law, u_gate), held("vp")
    arguments = (_argument(law, u_gate, u, pinch_off) for u in (u_source, u_drain))
    if of_second_order:
        for tag, argument in zip("fr", arguments, strict=True):
            terms |= {f"{tag}x": argument, tag: form(held(f"{tag}x"))}
        forward, reverse = (f"max({held(tag)},0)" for tag in "fr")
        squares = f"{forward}*{held('f')}-{reverse}*{held('r')}"
    else:
        forward, reverse = map(form, arguments)
        squares = f"{forward}^2-{reverse}^2"
    specific = law.square_current * device.multiplicity * device.width / device.length
    current = f"{specific!r}*({squares})"
    if law.early_field > 0.0:
        early = f"{1.0 / (law.early_field * device.length)!r}*abs({difference(drain, source)})"
        if law.early_rise > 0.0:
            early = f"{early}/(1+{law.early_rise!r}*({forward}+{reverse}))"
        current = f"{current}*(1+{early})"
    if law.mobility_reduction > 0.0:
        twice = f"({pinch_off}+sqrt({pinch_off}*{pinch_off}+{2.0 * law.u_t**2!r}))"
        terms["m"] = f"1/(1+{0.5 * law.mobility_reduction!r}*{twice})"
        current = f"{current}*{held('m')}"
    return Channel(terms, current)


def junction_current(
    device: Transistor, law: TransistorAtTemperature, terminal: str, difference: Difference
) -> str:
    """Leakage from `terminal` to the bulk, A (nFET), or from the bulk to `terminal` (pFET).

    `J (1 - e^y)` with `y = -v / U_T`, beyond y = 20 its tangent; J with what the gate induces.
    """
    width = device.width * device.multiplicity
    leakage = repr(law.junction_leakage * width)
    if law.gate_induced_leakage > 0.0:
        ends = (terminal, device.gate) if device.polarity == "n" else (device.gate, terminal)
        above = f"({difference(*ends)}-{law.gate_induced_from!r})/{law.gate_induced_slope!r}"
        leakage = f"({leakage}+{law.gate_induced_leakage * width!r}*exp(min({above},{INDUCED_LIMIT!r})))"
    y = f"({-1.0 / law.u_t!r}*{_to_bulk(device, terminal, difference)})"
    limit = _JUNCTION_LIMIT
    return f"{leakage}*({y}<{limit!r}?1-exp({y}):1-{math.exp(limit)!r}*({y}-{limit - 1.0!r}))"


def amplifier_currents(device: OperationalAmplifier, difference: Difference) -> tuple[str, str]:
    """Currents from the output to v_dd and to v_ss, A: the output current by the shares `(1 +- tanh)/2`."""
    half = f"(0.5*{difference(device.vdd, device.vss)})"
    drive = f"{device.gain!r}*({difference(device.positive, device.negative)}{_signed(device.offset)})"
    swing = f"tanh({drive}/{half})"
    into = f"({difference(device.output, device.vss)}-{half}-{half}*{swing})/{device.output_resistance!r}"
    return f"0.5*(1+{swing})*{into}", f"0.5*(1-{swing})*{into}"


def _to_bulk(device: Transistor, terminal: str, difference: Difference) -> str:
    """Voltage of a terminal to the bulk, a pFET's mirrored."""
    return difference(terminal, device.bulk) if device.polarity == "n" else difference(device.bulk, terminal)


def _argument(law: TransistorAtTemperature, u_gate: str, u_end: str, pinch_off: str | None) -> str:
    """`(v_p - v_end) / 2 U_T`."""
    scale = 0.5 / law.u_t
    if pinch_off is not None:
        return f"({scale!r}*({pinch_off}-{u_end}))"
    if law.gamma == 0.0:
        end = "" if u_end == ZERO else f"-{scale!r}*{u_end}"
        return f"({law.kappa * scale!r}*{u_gate}{end}{_signed(-law.kappa * law.v_t0 * scale)})"
    return f"({scale!r}*({_pinch_off(law, u_gate)}-{u_end}))"


def _pinch_off(law: TransistorAtTemperature, u_gate: str) -> str:
    """Pinch-off voltage to the bulk, v_p."""
    if law.gamma == 0.0:
        return f"({law.kappa!r}*{u_gate}{_signed(-law.kappa * law.v_t0)})"
    # below flat band, v_x < 0, the pinch-off voltage stays at -phi
    gamma, phi = law.gamma, law.surface_potential
    v_x = f"max({u_gate}{_signed(phi + gamma * math.sqrt(phi) - law.v_t0)},0)"
    return f"({v_x}-{gamma!r}*sqrt({v_x}+{0.25 * gamma**2!r}){_signed(0.5 * gamma**2 - phi)})"


def _signed(value: object) -> str:
    """A number with its sign, for a sum; one that is text has its sign inside."""
    return repr(value) if isinstance(value, float) and value < 0.0 else f"+{value!r}"
