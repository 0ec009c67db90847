"""Silicon neuron of the ROLLS chip: leak, positive feedback, refractory reset, adaptation, NMDA gate.

I_mem is the current that an nFET with its gate at v_mem carries. The parts are:

* leak, a differential-pair integrator (DPI): the input current divides between ground and the membrane in a
  differential pair of pFETs with gates v_thr and v_mem. The leak is one of two currents, which the latch
  `select` chooses. In weak inversion, with `tau = C_mem U_T / (kappa I_tau)`,
  `(1 + I_th / I_mem) tau dI_mem/dt = (I_th / I_tau)(I_in + ...) - I_th - I_mem (...)`.
* sodium: an nFET at v_mem, its source at `v_shift`, is mirrored into the membrane:
  `I_fb = I_0 (W/L) e^((kappa v_mem - v_shift) / U_T)`. It rises with v_mem as I_mem does, so that it meets
  the leak at a fixed ratio of I_mem to I_th at any temperature, and is far below the leak at rest.
* comparator: `v_o1` falls where I_mem passes I_buf and pulls the membrane up, so that the spike is whole; an
  inverter makes `spike`.
* reset: while `spike` is high I_rfr1 fills C_ref. While `v_ref` is above the threshold V_inv of an inverter
  the membrane is held at ground. I_rfr2 empties C_ref: `t_ref = C_ref (V_dd - V_inv) / I_rfr2`.
* adaptation: a DPI that spikes feed with I_ahw and that draws I_ahp from the membrane.
* NMDA gate: the current into `i_nmda` reaches the input only while v_mem is above v_nmda.
* a direct current I_dc into the input.

Whatever is shut while the membrane rests is long: its off current, that of a gate at the rail, is I_0 / 16 or
I_0 / 9, where the slower leak is five times I_0. A bias of fine code 0 (0.06 pA) is such a current too, so
that it needs no gate voltage beyond the rails at 27 degC; that of a generator would, from 30 degC on.

Sources: the parts and the names of their biases are those of the control software of ROLLS (mn256r1_ncs), and
the current-mode equations those of Chicca et al. 2014 as software models print them. The topology in detail,
sizes and capacitors are ours. IF_RST_N and IF_CASC_N, whose place in the circuit is not public, have none
here.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import current_into, powered, step
from circuits.blocks.measure import last_rate, latency, spike_outcome
from circuits.blocks.mos import current_mirror, inverter, mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in, biased, event_out
from circuits.blocks.rest import rested
from circuits.blocks.rolls.bias import OFF_CURRENT, gate_bias
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors (F) and sizes (um); ours."""

    membrane_capacitance: float = quantity(2e-12, "F")
    refractory_capacitance: float = quantity(0.5e-12, "F")
    hold_capacitance: float = quantity(100e-15, "F")  # holds the reset back until C_ref is full
    adaptation_capacitance: float = quantity(1e-12, "F")
    pair_width: float = um(4.0)  # of a differential pair, and its length
    pair_length: float = um(2.0)
    leak_width: float = um(1.0)  # of what a bias may turn off; off current I_0 / 9
    leak_length: float = um(9.0)
    # of what is shut while the membrane rests; off current I_0 / 16
    switch_width: float = um(0.5)
    switch_length: float = um(8.0)
    feedback_width: float = um(2.0)
    feedback_length: float = um(2.0)
    # of the adaptation's pair: small, for it takes part of a spike's charge
    adaptation_width: float = um(2.0)
    adaptation_length: float = um(1.0)
    mirror_width: float = um(0.5)  # of the feedback's mirror, whose gate must follow
    mirror_length: float = um(4.0)
    logic_length: float = um(0.18)


def leak(params: Params) -> Circuit:
    """The leak, a DPI: ports i_in, v_mem, select (high takes tau1), v_thr, v_tau1, v_tau2, v_dc."""
    pair, slow, switch = params.sizes("pair", "leak", "switch")
    return Circuit(
        "leak",
        (SUPPLY, *analog_out("i_in", "v_mem"), *bias_in("select", "v_thr", "v_tau1", "v_tau2", "v_dc")),
        (
            Capacitor("c_mem", "v_mem", "0", params.membrane_capacitance),
            mos("ml1", "p", "0", "v_thr", "i_in", *pair),
            mos("ml2", "p", "v_mem", "v_mem", "i_in", *pair),
            mos("ml3", "n", "y1", "v_tau1", "0", *slow),
            mos("ml4", "n", "y2", "v_tau2", "0", *slow),
            mos("ml5", "n", "v_mem", "select", "y1", *switch),
            mos("ml6", "n", "v_mem", "deselect", "y2", *switch),
            *inverter("ml7", "select", "deselect", width=0.5, length=0.5),
            mos("ml8", "n", "0", "v_thr", "0", *pair),
            mos("ml9", "p", "i_in", "v_dc", "vdd", *slow),
        ),
    )


def sodium(params: Params) -> Circuit:
    """Positive feedback into v_mem; `v_shift` is the source of the transistor that senses the membrane."""
    mirror = params.size("mirror")
    return Circuit(
        "sodium",
        (SUPPLY, *analog_out("v_mem"), *bias_in("v_shift")),
        (
            mos("mn1", "n", "nf", "v_mem", "v_shift", *params.size("feedback")),
            *current_mirror("mn3", "mn4", "p", "nf", "v_mem", mirror),
        ),
    )


def reset(params: Params) -> Circuit:
    """The comparator, the spike, and the refractory reset of v_mem."""
    length = params.logic_length
    switch = params.size("switch")
    return Circuit(
        "reset",
        (
            SUPPLY,
            *analog_out("v_mem", "v_o1", "v_ref"),
            *event_out("spike"),
            *bias_in("v_buf", "v_rfr1", "v_rfr2"),
        ),
        (
            mos("mc1", "n", "v_o1", "v_mem", "0", 1.0, 1.0),
            mos("mc2", "p", "v_o1", "v_buf", "vdd", 1.0, 1.0),
            *inverter("mc3", "v_o1", "spike", width=0.5, length=length),
            mos("mc4", "p", "v_mem", "v_o1", "vdd", *switch),
            Capacitor("c_ref", "v_ref", "0", params.refractory_capacitance),
            mos("mk1", "p", "kp", "kp", "vdd", 2.0, 0.5),
            mos("mk2", "n", "kp", "spike", "kn", 2.0, length),
            mos("mk3", "n", "kn", "v_rfr1", "0", 2.0, 0.5),
            mos("mk4", "p", "v_ref", "kp", "vdd", 2.0, 0.5),
            mos("mk5", "n", "v_ref", "v_rfr2", "0", 1.0, 2.0),
            *inverter("mk6", "v_ref", "k1", width=0.5, length=6.0),
            Capacitor("c_k", "k1", "0", params.hold_capacitance),
            *inverter("mk7", "k1", "k2", width=0.5, length=length),
            mos("mk8", "n", "v_mem", "k2", "0", *switch),
        ),
    )


def adaptation(params: Params) -> Circuit:
    """A DPI that spikes feed (v_o1 is low then), and whose output draws a current from v_mem."""
    pair, slow = params.sizes("adaptation", "leak")
    return Circuit(
        "adaptation",
        (
            SUPPLY,
            *analog_out("v_mem"),
            *analog_in("v_o1"),
            *analog_out("v_ahp"),
            *bias_in("v_ahw", "v_athr", "v_ahtau"),
        ),
        (
            Capacitor("c_ahp", "v_ahp", "0", params.adaptation_capacitance),
            mos("ma1", "p", "aw", "v_o1", "vdd", 1.0, 0.5),
            mos("ma2", "p", "at", "v_ahw", "aw", *slow),
            mos("ma3", "p", "0", "v_athr", "at", *pair),
            mos("ma4", "p", "v_ahp", "v_ahp", "at", *pair),
            mos("ma5", "n", "v_ahp", "v_ahtau", "0", *slow),
            mos("ma6", "n", "v_mem", "v_ahp", "0", *slow),
            mos("ma7", "n", "0", "v_athr", "0", *slow),
        ),
    )


def nmda_gate(params: Params) -> Circuit:
    """A differential pair that passes the current of `i_nmda` to `i_in` while v_mem is above v_nmda.

    Two mirrors stand between, or the current of the input would leave backwards through the pair.
    """
    pair, mirror = params.sizes("pair", "switch")
    return Circuit(
        "nmda_gate",
        (SUPPLY, *analog_in("i_nmda", "v_mem"), *analog_out("i_in"), *bias_in("v_nmda")),
        (
            mos("mg1", "p", "gn", "v_nmda", "i_nmda", *pair),
            mos("mg2", "p", "0", "v_mem", "i_nmda", *pair),
            mos("mg3", "n", "0", "v_nmda", "0", *params.size("leak")),
            *current_mirror("mg4", "mg5", "n", "gn", "gp", mirror),
            *current_mirror("mg6", "mg7", "p", "gp", "i_in", mirror),
        ),
    )


BIASES = (
    gate_bias("thr", "IF_THR_N", "leak.ml8"),
    gate_bias("tau1", "IF_TAU1_N", "leak.ml3"),
    gate_bias("tau2", "IF_TAU2_N", "leak.ml4"),
    Bias("i_dc", "v_dc", "gate", OFF_CURRENT, "leak.ml9"),
    gate_bias("buf", "IF_BUF_P", "reset.mc2"),
    gate_bias("rfr1", "IF_RFR1_N", "reset.mk3"),
    gate_bias("rfr2", "IF_RFR2_N", "reset.mk5"),
    gate_bias("ahw", "IF_AHW_P", "adaptation.ma2"),
    gate_bias("athr", "IF_ATHR_N", "adaptation.ma7"),
    gate_bias("ahtau", "IF_AHTAU_N", "adaptation.ma5"),
    gate_bias("nmda", "IF_NMDA_N", "nmda_gate.mg3"),
    Bias("v_select", "select", "voltage", 0.0),  # V; latch of the slower leak, tau1, off
    Bias("v_shift", "v_shift", "voltage", 0.15),  # V, ours: keeps the feedback of a resting membrane small
)


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports i_in, i_nmda (currents in), v_mem, spike (event out), biases and the supply."""
    instances = (
        leak(params).instance("leak"),
        sodium(params).instance("sodium"),
        reset(params).instance("reset"),
        adaptation(params).instance("adaptation"),
        nmda_gate(params).instance("nmda_gate"),
    )
    inputs, outputs = analog_in("i_in", "i_nmda"), (*analog_out("v_mem"), *event_out("spike"))
    ports = (SUPPLY, *inputs, *outputs)
    return biased("rolls_neuron", ports, BIASES, (), instances)


STEP_TIME = 2e-3  # s, when the testbench's current begins; ours
STEP_RISE = 1e-6  # s
RESTING = 0.13e-12  # A, ours: leak of a silent filter into the NMDA gate, whose node would float at 0 A

STIMULI = (
    Stimulus("current", "A", 1e-9, "step into the input"),
    Stimulus("nmda", "A", RESTING, "step through the NMDA gate"),
    Stimulus("slow", "", None, "the leak's latch: tau1 where on, tau2 where off", can_be_off=True),
    lasting(20e-3),
)
PLOTTED = ("i_in", "v_mem", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A step of current into the input at 2 ms, and one through the NMDA gate; `slow` takes the leak tau1."""
    values = {name: value or 0.0 for name, value in stimuli.items()}
    supply, select = powered(v_dd, {"select": 0.0 if stimuli["slow"] is None else v_dd})
    edge = STEP_TIME, STEP_TIME + STEP_RISE
    currents = (
        current_into("i_in", step(*edge, 0.0, values["current"])),
        current_into("i_nmda", step(*edge, RESTING, values["nmda"])),
    )
    sources = (supply, *currents, select)
    return rested("ROLLS neuron", circuit, sources, values["duration"], ROLLS_180_IDEAL, watch=("spike",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `latency_s`, `rate_Hz` and `adaptation`.

    latency: from the step to the first spike, None without one. rate: of the last interval, None below two
    spikes. adaptation: the first interval over the last, None below three spikes.
    """
    spikes = result.spikes["spike"]
    gaps = spikes[1:] - spikes[:-1]
    return {
        "latency_s": latency(result, STEP_TIME),
        "rate_Hz": last_rate(spikes),
        "adaptation": float(gaps[0] / gaps[-1]) if gaps.size > 1 else None,
    }


BLOCK = catalogued("rolls-neuron", build, STIMULI, testbench, measures, spike_outcome, PLOTTED, ROLLS_180)
