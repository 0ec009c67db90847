"""Closed forms of a rebound neuron by its own circuit: equations (3) to (17) with its sizes and biases.

The paper does not print `V_inhH` and `V_hl`. In weak inversion the diode mi4, with gate and drain at V_dd,
charges C for the length t of the call: `V_inhH = v_p + U_T ln(I_S t / (C U_T))`. The starved inverter
switches where its nFET mi8 carries the limited current: `I_lim = I_S ln^2(1 + e^(v_p / 2U_T))`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from circuits.bias import bias_voltages, closed_current
from circuits.blocks.block import ClosedForm
from circuits.blocks.sonar import rebound_equations as eq
from circuits.circuit import Circuit
from circuits.devices.pinch_off import pinch_off
from circuits.devices.softplus import inverse_softplus
from circuits.event import WIDTH
from circuits.lowering.capacitance import node_capacitances
from circuits.lowering.flatten import flatten
from circuits.lowering.on_die import transistor_of
from circuits.silicon.process import TransistorAtTemperature
from circuits.silicon.silicon import Silicon


@dataclass(frozen=True, slots=True)
class Analysis:
    """Parameters of the closed forms: with the drawn capacitors, and with all capacitance at the nodes."""

    drawn: eq.ReboundParameters
    loaded: eq.ReboundParameters


def analyse(circuit: Circuit, silicon: Silicon) -> Analysis:
    """Parameters of the closed forms for a rebound neuron on the nominal die."""
    flat = flatten(circuit)
    currents = {
        name: closed_current(circuit, circuit.bias(name), silicon)
        for name in ("i_rslope", "i_rtau", "i_inh_tau", "i_ex_tau", "i_lim")
    }
    voltages = {
        name: float(bias_voltages(circuit, circuit.bias(name), silicon)) for name in ("v_rest", "v_ex_max")
    }
    load = node_capacitances(circuit, silicon.process)
    drawn_c = {
        g.device.name: float(g.parameters["capacitance"][0])
        for g in flat.groups
        if "capacitance" in g.parameters
    }
    n, p = _law(circuit, silicon, "membrane.m1"), _law(circuit, silicon, "membrane.m2")
    i_sn, i_sp = _specific(circuit, silicon, "membrane.m1"), _specific(circuit, silicon, "membrane.m2")
    c_inh = load["inhibition.v_inh"]
    v_hl = n.v_t0 + 2.0 * n.u_t / n.kappa * inverse_softplus(
        math.sqrt(currents["i_lim"] / _specific(circuit, silicon, "inhibition.mi8"))
    )
    charged = _specific(circuit, silicon, "inhibition.mi4") * WIDTH / (c_inh * n.u_t)
    v_inh_high = float(pinch_off(n.kappa, silicon.process.v_dd, n.v_t0)) + n.u_t * math.log(charged)
    drawn = eq.ReboundParameters(
        u_t=n.u_t,
        kappa_n=n.kappa,
        kappa_p=p.kappa,
        i_0n=eq.weak_inversion_prefactor(i_sn, n.kappa, n.v_t0, n.u_t),
        i_0p=eq.weak_inversion_prefactor(i_sp, p.kappa, p.v_t0, p.u_t),
        i_sn=i_sn,
        i_sp=i_sp,
        v_dd=silicon.process.v_dd,
        v_rest=voltages["v_rest"],
        i_rslope=currents["i_rslope"],
        i_rtau=currents["i_rtau"],
        i_inh_tau=currents["i_inh_tau"],
        i_ex_tau=currents["i_ex_tau"],
        v_ex_max=voltages["v_ex_max"],
        c_m=drawn_c["c_m"],
        c_r=drawn_c["c_r"],
        c_ex=drawn_c["c_ex"],
        c_inh=drawn_c["c_inh"],
        v_inh_high=v_inh_high,
        v_hl=v_hl,
    )
    loaded = replace(
        drawn, c_m=load["v_mem"], c_r=load["membrane.v_r"], c_ex=load["excitation.v_ex"], c_inh=c_inh
    )
    return Analysis(drawn, loaded)


def closed_forms(circuit: Circuit, silicon: Silicon) -> tuple[ClosedForm, ...]:
    """Times and voltages as printed, with the drawn capacitors, and as corrected, with all capacitance."""
    analysis = analyse(circuit, silicon)
    drawn, loaded = analysis.drawn, analysis.loaded
    t_reb = eq.rebound_duration(loaded)
    return (
        ClosedForm(
            3,
            "t_inh_s",
            eq.inhibition_duration_as_printed(drawn),
            eq.inhibition_duration(drawn, loaded.c_inh),
        ),
        ClosedForm(4, "v_r_peak_V", eq.rebound_slow_equilibrium(drawn), None),
        ClosedForm(6, "v_mem_rest_V", eq.membrane_equilibrium_as_printed(drawn), eq.membrane_rest(drawn)),
        ClosedForm(8, "v_r_min_V", eq.rebound_slow_minimum(drawn), None),
        ClosedForm(12, "t_reb_s", eq.rebound_duration_as_printed(drawn), t_reb),
        ClosedForm(
            13,
            "v_mem_peak_V",
            eq.rebound_peak_as_printed(drawn, eq.rebound_duration(drawn)),
            eq.rebound_peak_rounded(loaded, t_reb),
        ),
        ClosedForm(
            17,
            "epsc_time_constant_s",
            eq.excitatory_time_constant(drawn),
            eq.excitatory_time_constant(loaded),
        ),
        ClosedForm(
            17, "epsc_peak_A", eq.excitatory_peak_current(drawn), eq.excitatory_peak_current_ekv(drawn)
        ),
    )


def _law(circuit: Circuit, silicon: Silicon, name: str) -> TransistorAtTemperature:
    """Numbers of a transistor of its size."""
    device = transistor_of(circuit, name)
    return silicon.law(device.polarity).of_size(device.width, device.length)


def _specific(circuit: Circuit, silicon: Silicon, name: str) -> float:
    """Specific current of a transistor, A."""
    device = transistor_of(circuit, name)
    law = _law(circuit, silicon, name)
    return law.square_current * device.multiplicity * device.width / device.length
