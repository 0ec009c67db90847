"""Rebound neuron: a range-tuned neuron that fires when an echo meets its postinhibitory rebound.

It has five sub-circuits (Cheely & Horiuchi 2003, Figure 3): an inhibitory synapse that the call starts, a
membrane with a slow restoring node, an excitatory synapse that the echo starts, a comparator, and an axon.
The schematic of the paper is reconstructed. The topology is from its text and the capacitors C_m, C_r, C_ex
and C_inh are the paper's; the sizes, C_ax, C_fb and the reset of the membrane (ma8) are ours.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from circuits.blocks.block import DURATION, EquationText, Stimulus, Values, catalogued
from circuits.blocks.drive import powered
from circuits.blocks.measure import between, fall, peak, rise, spike_outcome
from circuits.blocks.mos import current_mirror, mos
from circuits.blocks.ports import (
    SUPPLY,
    analog_in,
    analog_out,
    bias_in,
    biased,
    event_in,
    event_out,
)
from circuits.blocks.sonar.rebound_analysis import closed_forms
from circuits.blocks.sonar.rebound_equation_table import EQUATIONS
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor, Device
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params:
    """Capacitors, F: those of the paper, and ours where the field says so."""

    membrane_capacitance: float = quantity(600e-15, "F")
    rebound_capacitance: float = quantity(600e-15, "F")
    excitation_capacitance: float = quantity(400e-15, "F")
    inhibition_capacitance: float = quantity(440e-15, "F")
    axon_capacitance: float = quantity(150e-15, "F")  # ours
    feedback_capacitance: float = quantity(50e-15, "F")  # ours


# Neuron 2 of the array: best delay 6.33 ms.
I_INH_TAU = 199.9e-12
I_EX_TAU = 60.7e-12


def _inverter(p: str, n: str, a: str, y: str, top: str = "vdd") -> tuple[Device, ...]:
    return mos(p, "p", y, a, top, 6, 1.5), mos(n, "n", y, a, "0", 3, 1.5)


def _starved(top: str, p: str, n: str, a: str, y: str) -> tuple[Device, ...]:
    """An inverter whose pFET gets no more than I_lim, which `top` carries from the supply to node `{y}p`."""
    return mos(top, "p", f"{y}p", "v_ilim", "vdd", 3, 3), *_inverter(p, n, a, y, f"{y}p")


def inhibitory_synapse(params: Params) -> Circuit:
    """The call charges C_inh through a diode and I_inh_tau empties it; until then v_mem is held down."""
    return Circuit(
        "inhibitory_synapse",
        (SUPPLY, *event_in("call"), *analog_out("v_mem"), *bias_in("v_inh_tau", "v_ilim")),
        (
            *_inverter("mi1", "mi2", "call", "callb"),
            mos("mi3", "p", "nd", "callb", "vdd", 3, 1.5),
            mos("mi4", "n", "nd", "nd", "v_inh", 3, 1.5),
            mos("mi5", "n", "v_inh", "v_inh_tau", "0", 6, 6),
            Capacitor("c_inh", "v_inh", "0", params.inhibition_capacitance),
            *_starved("mi6", "mi7", "mi8", "v_inh", "a"),
            *_starved("mi9", "mi10", "mi11", "a", "b"),
            mos("mi12", "n", "v_mem", "b", "0", 3, 1.5),
        ),
    )


def membrane(params: Params) -> Circuit:
    """C_m, charged by I_rslope and tied to V_rest by m1, whose gate v_r follows v_mem at I_rtau / C_r."""
    return Circuit(
        "membrane",
        (SUPPLY, *analog_out("v_mem"), *bias_in("v_rest", "v_rslope", "v_rtau")),
        (
            Capacitor("c_m", "v_mem", "0", params.membrane_capacitance),
            Capacitor("c_r", "v_r", "0", params.rebound_capacitance),
            mos("m1", "n", "v_mem", "v_r", "v_rest", 3, 6),
            mos("mr1", "p", "v_mem", "v_rslope", "vdd", 6, 6),
            mos("m2", "p", "0", "v_mem", "v_r", 6, 3),
            mos("mr2", "p", "v_r", "v_rtau", "vdd", 6, 6),
        ),
    )


def excitatory_synapse(params: Params) -> Circuit:
    """The echo pulls v_ex to V_ex,max, and I_ex_tau charges it back: the current decays exponentially."""
    return Circuit(
        "excitatory_synapse",
        (SUPPLY, *event_in("echo"), *analog_out("v_mem"), *bias_in("v_ex_max", "v_ex_tau")),
        (
            *_inverter("me1", "me2", "echo", "echob"),
            mos("me3", "p", "v_ex_max", "echob", "v_ex", 3, 1.5),
            mos("me4", "p", "v_ex", "v_ex_tau", "vdd", 6, 6),
            Capacitor("c_ex", "v_ex", "vdd", params.excitation_capacitance),
            mos("me5", "p", "v_mem", "v_ex", "vdd", 6, 3),
        ),
    )


def comparator(params: Params) -> Circuit:
    """A differential pair that charges the input of the axon while v_mem is above V_th."""
    return Circuit(
        "comparator",
        (SUPPLY, *analog_in("v_mem"), *analog_out("v_ax"), *bias_in("v_th", "v_bcmp")),
        differential_stage("v_mem", "v_th", pair=(6, 3), mirror=(6, 3)),
    )


def differential_stage(
    plus: str, minus: str, *, pair: tuple[float, float], mirror: tuple[float, float]
) -> tuple[Device, ...]:
    """Devices that charge the node `v_ax` while `plus` is above `minus`, with the current set at `v_bcmp`.

    pair, mirror: width and length of the differential pair's pFETs and of the mirror's nFETs, um.
    """
    return (
        mos("mc3", "p", "tail", "v_bcmp", "vdd", 6, 6),
        mos("mc1", "p", "m", plus, "tail", *pair),
        mos("mc2", "p", "v_ax", minus, "tail", *pair),
        *current_mirror("mc4", "mc5", "n", "m", "v_ax", mirror),
    )


def axon(params: Params) -> Circuit:
    """The axon hillock: two inverters with capacitive feedback; a spike resets v_ax, at I_pw, and v_mem."""
    return Circuit(
        "axon",
        (SUPPLY, *analog_out("v_ax", "v_mem"), *event_out("spike"), *bias_in("v_ilim", "v_pw")),
        (
            Capacitor("c_ax", "v_ax", "0", params.axon_capacitance),
            Capacitor("c_fb", "spike", "v_ax", params.feedback_capacitance),
            *_starved("ma1", "ma2", "ma3", "v_ax", "x"),
            *_inverter("ma4", "ma5", "x", "spike"),
            mos("ma6", "n", "v_ax", "spike", "rm", 3, 1.5),
            mos("ma7", "n", "rm", "v_pw", "0", 6, 6),
            mos("ma8", "n", "v_mem", "spike", "0", 3, 1.5),
        ),
    )


BIASES = (
    Bias("i_inh_tau", "v_inh_tau", "gate", I_INH_TAU, "inhibition.mi5"),
    Bias("i_ex_tau", "v_ex_tau", "gate", I_EX_TAU, "excitation.me4"),
    Bias("i_rslope", "v_rslope", "gate", 500e-12, "membrane.mr1"),
    Bias("i_rtau", "v_rtau", "gate", 400e-12, "membrane.mr2"),
    Bias("i_lim", "v_ilim", "gate", 6.3e-6, "axon.ma1"),
    Bias("i_cmp", "v_bcmp", "gate", 500e-9, "comparator.mc3"),
    Bias("i_pw", "v_pw", "gate", 650e-9, "axon.ma7"),
    Bias("v_rest", "v_rest", "voltage", 1.8),
    Bias("v_th", "v_th", "voltage", 2.5),
    Bias("v_ex_max", "v_ex_max", "voltage", 4.301),
)

# Ours, for neuron 2: with these, others as above, all of dies A/0 to A/299 work at 27 degC under mismatch
# alone, on the same areas and I_cmp. The nominal neuron keeps its best delay within 1 %, its interval within
# a tenth, and one spike an echo. Found by a random search; its steps, and the yield on dies that it never
# saw, are in benchmarks/bias_search.py. What it does: a larger echo current, and a threshold that is higher
# above the rest, so that the call alone stays below it.
ROBUST_BIASES: Mapping[str, float] = {
    "i_inh_tau": 202.3e-12,
    "i_ex_tau": 75.2e-12,
    "i_rslope": 363.3e-12,
    "v_rest": 1.792,
    "v_th": 2.602,
    "v_ex_max": 4.24,
}

# Ours: the same with other echo currents, I_inh_tau chosen so that the nominal best delay stays within 0.1 %.
# On dies A/0 to A/299, mismatch alone, all work; an echo at the best delay makes one spike in 297, two in 3
# when its current decays fast, two to four (three in the nominal neuron) when it decays slowly: each spike
# resets the membrane and its restoring node, and what is left of the current drives the next rebound.
SINGLE_SPIKE_BIASES: Mapping[str, float] = {**ROBUST_BIASES, "i_ex_tau": 102e-12}
BURST_BIASES: Mapping[str, float] = {**ROBUST_BIASES, "i_inh_tau": 186e-12, "i_ex_tau": 25e-12}

# By name on the command line; complete, so that a set means the same wherever the neuron stands.
_FACTS = {b.name: float(np.asarray(b.value)) for b in BIASES}
BIAS_SETS: Mapping[str, Mapping[str, float]] = {
    "facts": _FACTS,
    "robust": {**_FACTS, **ROBUST_BIASES},
    "single-spike": {**_FACTS, **SINGLE_SPIKE_BIASES},
    "burst": {**_FACTS, **BURST_BIASES},
}


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports call, echo (events in), v_mem (analog), spike (event out), biases and the supply."""
    instances = (
        inhibitory_synapse(params).instance("inhibition"),
        membrane(params).instance("membrane"),
        excitatory_synapse(params).instance("excitation"),
        comparator(params).instance("comparator"),
        axon(params).instance("axon"),
    )
    events = (*event_in("call", "echo"), *analog_out("v_mem"), *event_out("spike"))
    ports = (SUPPLY, *events)
    return biased("rebound_neuron", ports, BIASES, (), instances)


CALL_TIME = 1e-3  # s, when the testbench's call arrives
AFTER_RELEASE = 8e-3  # s, how long the testbench goes on after the later of echo and release
NOMINAL_RELEASE = 7e-3  # s

STIMULI = (
    Stimulus("delay", "s", 6.4e-3, "echo after the call"),
    Stimulus("call", "", 1.0, "the call's pulse", can_be_off=True),
    Stimulus("echo", "", 1.0, "the echo's pulse", can_be_off=True),
    DURATION,
)
PLOTTED = ("call", "echo", "v_mem", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A call at 1 ms and an echo `delay` (s) later, each of which can be off.

    `duration` is another length of the run, s. Raises `ParameterError` for a delay below zero.
    """
    delay = stimuli["delay"] or 0.0
    if delay < 0.0:
        raise ParameterError(f"delay: {delay:g} s, must be >= 0; the echo follows the call")
    call = (CALL_TIME,) if stimuli["call"] is not None else ()
    echo = (CALL_TIME + delay,) if stimuli["echo"] is not None else ()
    stop = stimuli["duration"] or CALL_TIME + max(delay, NOMINAL_RELEASE) + AFTER_RELEASE
    sources = powered(v_dd, {"call": pulse(call, v_dd), "echo": pulse(echo, v_dd)})
    return Testbench("rebound neuron", circuit, sources, stop, watch=("spike",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `t_inh_s`, `t_reb_s` and `v_mem_peak_V`.

    t_inh: from the edge of the call to the fall of the inhibition's gate (node inhibition.b) through half the
    supply. t_reb: from there to the first spike, which ends the rise, or to the peak of v_mem. Both are None
    without a call. v_mem_peak: the largest v_mem after the release, or over the whole run without a call.
    """
    call, release = rise(result, "call"), fall(result, "inhibition.b")
    time, height = peak(result, "v_mem", release or 0.0)
    ends = [float(time) for time in result.spikes["spike"] if time > (release or 0.0)]
    top = ends[0] if ends else time
    return {
        "t_inh_s": between(call, release),
        "t_reb_s": None if call is None else between(release, top),
        "v_mem_peak_V": height,
    }


BLOCK = replace(
    catalogued("rebound-neuron", build, STIMULI, testbench, measures, spike_outcome, PLOTTED),
    closed_forms=closed_forms,
    equations=tuple(
        EquationText(e.number, e.name, e.printed_form, e.corrected_form, e.difference) for e in EQUATIONS
    ),
    bias_sets=BIAS_SETS,
)
