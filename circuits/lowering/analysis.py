"""Closed forms of a circuit: the equation of each device as text, with its numbers.

Every device type registers its own equation, as in the other lowerings.
"""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode, diode_arrays
from circuits.silicon.silicon import Silicon


@singledispatch
def to_equation(device: Device, silicon: Silicon) -> str:
    """A device's constitutive relation as text with its numbers in SI, at the silicon's temperature."""
    raise TypeError(f"{type(device).__name__}: no closed form")


@to_equation.register
def _(device: Transistor, silicon: Silicon) -> str:
    law = silicon.law(device.polarity).of_size(device.width, device.length)
    specific = law.square_current * device.multiplicity * device.width / device.length
    sign = "" if device.polarity == "n" else "-"
    pinch_off = f"{law.kappa:g} ({sign}(v_g - v_b) - {law.v_t0:g})"
    if law.gamma > 0.0:
        pinch_off = f"pinch-off voltage with gamma {law.gamma:.4g} V^0.5"
    early, mobility = "", ""
    if law.early_field > 0.0:
        early = f" (1 + |v_ds| / ({law.early_field * device.length:.4g} (1 + {law.early_rise:g} q)))"
    if law.mobility_reduction > 0.0:
        mobility = f" / (1 + {law.mobility_reduction:g} v_m)"
    return (
        f"I_d = {sign}{specific:.4g} [F((v_p - {sign}(v_s - v_b)) / {law.u_t:.6g})"
        f" - F((v_p - {sign}(v_d - v_b)) / {law.u_t:.6g})]{early}{mobility}, v_p = {pinch_off},"
        " F(u) = ln^2(1 + e^(u/2))"
        f"{', q = sqrt(F_f) + sqrt(F_r)' if early else ''}"
        f"{', v_m = (v_p + sqrt(v_p^2 + 2 U_T^2)) / 2' if mobility else ''}"
    )


@to_equation.register
def _(device: Capacitor, silicon: Silicon) -> str:
    return f"q = {device.capacitance:.4g} (v_a - v_b)"


@to_equation.register
def _(device: Resistor, silicon: Silicon) -> str:
    return f"I = (v_a - v_b) / {device.resistance:.4g}"


@to_equation.register
def _(device: Diode, silicon: Silicon) -> str:
    one = {name: np.array([value]) for name, value in device.parameters().items()}
    at = diode_arrays(np.zeros((2, 1), np.int64), np.zeros(1, np.int64), one, silicon.temperature_c)
    equation = f"I = {at.saturation[0]:.4g} (e^(v / {at.slope[0]:.6g}) - 1), v = v_anode - v_cathode"
    if device.breakdown_voltage > 0.0:
        equation += (
            f", -{at.saturation[0]:.4g} e^(-(v + {at.breakdown[0]:.4g}) / {at.breakdown_slope[0]:.4g})"
        )
        equation += f" below -{at.breakdown[0]:.4g} V"
    if device.junction_capacitance > 0.0:
        capacitance = f"{at.capacitance[0]:.4g} (1 - v / {at.potential[0]:.4g})^-{at.grading[0]:g}"
        equation += f", C = {capacitance} up to {at.bend[0]:.4g} V"
    if device.transit_time > 0.0:
        equation += f", q = {device.transit_time:.4g} I beside it"
    return equation


@to_equation.register
def _(device: ControlledSource, silicon: Silicon) -> str:
    return f"I = {device.transconductance:.4g} (v_cp - v_cn)"


@to_equation.register
def _(device: OperationalAmplifier, silicon: Silicon) -> str:
    return (
        f"I_out = (v_out - v_mid - h tanh({device.gain:g} (v_p - v_n + {device.offset:g}) / h))"
        f" / {device.output_resistance:g}, v_mid = (v_dd + v_ss) / 2, h = (v_dd - v_ss) / 2"
    )


@to_equation.register
def _(device: Source, silicon: Silicon) -> str:
    return f"{'v' if device.quantity == 'voltage' else 'I'} = {type(device.waveform).__name__.lower()}(t)"
