"""Synapse of the ROLLS chip: pulse extender, weights of four levels of either sign, and two DPI filters.

* pulse extender: the event pulls `v_p` to ground, and I_pwlk lets it rise again. The pulse lasts as long as
  the event and `C_pw V_inv / I_pwlk` more, V_inv being the threshold of the inverter.
* synapse: it has four latches, of which the circuit has the outputs as levels: `recurrent` lets the pulse in,
  `sign` is high for an excitatory synapse, and `w0` and `w1` set the weight. During the pulse it draws
  `I_w = I_const + w0 I_w0 + w1 I_w1` from the line of its sign. Each sign has three currents of its own; the
  excitatory ones are those of pFETs, and mirrored. Between pulses the far node of the switch to the line is
  held at `v_shift`, above ground as the shifted sources of the generator are: with its gate at 0 V the switch
  then leaks `I_0 (W/L) e^(-v_shift / U_T)`.
* filter: a differential-pair integrator (DPI) for each sign. A pair of nFETs with gates v_thr and v_syn
  divides I_w between the supply and a capacitor that I_tau fills again; a pFET at v_syn gives I_syn. In weak
  inversion with equal kappa, and `tau = C_syn U_T / (kappa I_tau)`,
  `(1 + I_th / I_syn) tau dI_syn/dt = (I_th / I_tau) I_w - I_syn - I_th`,
  and where I_syn >> I_th a pulse of width t adds `(I_th I_w / I_tau)(1 - e^(-t / tau))`. Here the pair has
  kappa_n and the output kappa_p, which bends the gain. The inhibitory filter is mirrored, to draw a current.

The line carries the drains of all synapses that share it (`line_capacitance`): 256 drains of 0.5 um.

Sources: names of biases and the sum rule of the weights from the control software of ROLLS (mn256r1_ncs) and
its header; the DPI equation as software models print it (teili, after Chicca et al. 2014; its -I_th term is
kept here). The topology in detail, sizes and capacitors are ours; default weights and times are the
software's codes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import powered, train
from circuits.blocks.measure import between, fall, rise
from circuits.blocks.mos import current_mirror, inverter, mos, nand
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in, biased, event_in
from circuits.blocks.rest import rested
from circuits.blocks.rolls.bias import gate_bias
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor
from circuits.devices.device import Device
from circuits.errors import ParameterError
from circuits.event import falling_crossing, pulse
from circuits.lowering.supply import half_supply
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.solver.power import drain_current
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

LATCHES = ("recurrent", "sign", "w0", "w1")


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors in farad, sizes in um; all ours."""

    synapse_capacitance: float = quantity(1.5e-12, "F")
    pulse_capacitance: float = quantity(0.15e-12, "F")
    line_capacitance: float = quantity(0.1e-12, "F", least=0.0)
    # wide, so that a filter's pair is in weak inversion at the excitatory weights
    pair_width: float = um(8.0)
    pair_length: float = um(0.5)
    tau_width: float = um(0.5)
    tau_length: float = um(4.0)
    # long, so that a silent filter's off current is a quarter of I_0
    output_width: float = um(1.0)
    output_length: float = um(4.0)
    weight_width: float = um(1.0)
    weight_length: float = um(1.0)
    logic_width: float = um(0.5)
    logic_length: float = um(0.18)


def pulse_extender(params: Params) -> Circuit:
    """What makes an event longer: ports event (in), pulse (out), v_pwlk (bias)."""
    size = {"width": params.logic_width, "length": params.logic_length}
    return Circuit(
        "pulse_extender",
        (SUPPLY, *event_in("event"), *analog_out("pulse"), *bias_in("v_pwlk")),
        (
            Capacitor("c_pw", "v_p", "0", params.pulse_capacitance),
            mos("mp1", "n", "v_p", "event", "0", 2.0, params.logic_length),
            mos("mp2", "p", "v_p", "v_pwlk", "vdd", 1.0, 1.0),
            *inverter("mp3", "v_p", "p1", width=params.logic_width, length=1.0),
            *inverter("mp4", "p1", "p2", **size),
            *inverter("mp5", "p2", "pulse", **size),
        ),
    )


def synapse(params: Params) -> Circuit:
    """The synapse: ports pulse, the latches, the lines exc and inh that it draws from, and weight biases."""
    size = {"width": params.logic_width, "length": params.logic_length}
    gates = (
        *nand("mq1", ("pulse", "recurrent", "sign"), "exc_off", **size),
        *nand("mq2", ("pulse", "recurrent", "unsigned"), "inh_off", **size),
        *inverter("mq3", "sign", "unsigned", **size),
        *inverter("mq4", "exc_off", "exc_on", **size),
        *inverter("mq5", "inh_off", "inh_on", **size),
        *inverter("mq6", "w0", "w0_off", **size),
        *inverter("mq7", "w1", "w1_off", **size),
    )
    biases = ("v_exc", "v_exc0", "v_exc1", "v_inh", "v_inh0", "v_inh1")
    return Circuit(
        "nonplastic_synapse",
        (
            SUPPLY,
            *analog_in("pulse"),
            *bias_in(*LATCHES),
            *analog_out("exc", "inh"),
            *bias_in(*biases, "v_shift"),
        ),
        (*gates, *_excitatory(params), *_inhibitory(params)),
    )


def _excitatory(params: Params) -> tuple[Device, ...]:
    """PFETs of the three currents, switched by the pulse and the bits, and their mirror."""
    weight = params.size("weight")
    return (
        mos("me1", "p", "es", "exc_off", "vdd", 4.0, params.logic_length),
        mos("me2", "p", "em", "v_exc", "es", *weight),
        mos("me3", "p", "em", "w0_off", "e0", 4.0, params.logic_length),
        mos("me4", "p", "e0", "v_exc0", "es", *weight),
        mos("me5", "p", "em", "w1_off", "e1", 4.0, params.logic_length),
        mos("me6", "p", "e1", "v_exc1", "es", *weight),
        *current_mirror("me7", "me8", "n", "em", "ed", weight),
        mos("me9", "n", "exc", "exc_on", "ed", 0.5, params.logic_length),
        mos("me10", "n", "ed", "exc_off", "v_shift", 0.5, params.logic_length),
    )


def _inhibitory(params: Params) -> tuple[Device, ...]:
    """NFETs of the three currents, switched by the pulse and the bits."""
    weight = params.size("weight")
    switch = 0.5, params.logic_length
    return (
        mos("mi1", "n", "inh", "inh_on", "ix", *switch),
        mos("mi7", "n", "ix", "inh_on", "is", *switch),
        mos("mi8", "n", "ix", "inh_off", "v_shift", *switch),
        mos("mi2", "n", "is", "v_inh", "0", *weight),
        mos("mi3", "n", "is", "w0", "i0", 4.0, params.logic_length),
        mos("mi4", "n", "i0", "v_inh0", "0", *weight),
        mos("mi5", "n", "is", "w1", "i1", 4.0, params.logic_length),
        mos("mi6", "n", "i1", "v_inh1", "0", *weight),
    )


def _filter(params: Params, plate: str = "vdd") -> tuple[Device, ...]:
    """The pair at `line`, v_syn with its capacitor to `plate`, I_tau, and the gate voltage of I_th."""
    pair = params.size("pair")
    ends = ("v_syn", "0") if plate == "0" else ("vdd", "v_syn")
    line = (Capacitor("c_line", "line", "0", params.line_capacitance),) if params.line_capacitance else ()
    return (
        *line,
        Capacitor("c_syn", *ends, params.synapse_capacitance),
        mos("md1", "n", "vdd", "v_thr", "line", *pair),
        mos("md2", "n", "v_syn", "v_syn", "line", *pair),
        mos("md3", "p", "v_syn", "v_tau", "vdd", *params.size("tau")),
        mos("md4", "p", "0", "v_thr", "vdd", *params.size("output")),
    )


def _filter_ports(out: str) -> tuple[Port, ...]:
    return (SUPPLY, *analog_in("line"), *analog_out("v_syn", out), *bias_in("v_thr", "v_tau"))


def excitatory_filter(params: Params, plate: str = "vdd") -> Circuit:
    """The DPI filter whose output current flows into `i_out`.

    plate: rail at which the capacitor ends, `vdd` or `0`.
    """
    output = mos("md5", "p", "i_out", "v_syn", "vdd", *params.size("output"))
    return Circuit("excitatory_dpi", _filter_ports("i_out"), (*_filter(params, plate), output))


def inhibitory_filter(params: Params, plate: str = "vdd") -> Circuit:
    """The DPI filter whose output current is drawn from `i_out`; arguments as of `excitatory_filter`."""
    size = params.size("output")
    output = (
        mos("md5", "p", "vm", "v_syn", "vdd", *size),
        *current_mirror("md6", "md7", "n", "vm", "i_out", size),
    )
    return Circuit("inhibitory_dpi", _filter_ports("i_out"), (*_filter(params, plate), *output))


BIASES = (
    gate_bias("pwlk", "NPA_PWLK_P", "extender.mp2"),
    gate_bias("exc", "NPA_WEIGHT_EXC_P", "synapse.me2"),
    gate_bias("exc0", "NPA_WEIGHT_EXC0_P", "synapse.me4"),
    gate_bias("exc1", "NPA_WEIGHT_EXC1_P", "synapse.me6"),
    gate_bias("inh", "NPA_WEIGHT_INH_N", "synapse.mi2"),
    gate_bias("inh0", "NPA_WEIGHT_INH0_N", "synapse.mi4"),
    gate_bias("inh1", "NPA_WEIGHT_INH1_N", "synapse.mi6"),
    gate_bias("etau", "NPDPIE_TAU_P", "excitatory.md3"),
    gate_bias("ethr", "NPDPIE_THR_P", "excitatory.md4"),
    gate_bias("itau", "NPDPII_TAU_P", "inhibitory.md3"),
    gate_bias("ithr", "NPDPII_THR_P", "inhibitory.md4"),
    Bias("v_shift", "v_shift", "voltage", 0.25),  # V, ours: ten U_T
    *(Bias(f"v_{name}", name, "voltage", 1.8 if name in ("recurrent", "sign") else 0.0) for name in LATCHES),
)


def build(params: Params = Params()) -> Circuit:
    """The whole: ports event (in), i_exc_out and i_inh_out (currents out and in), biases and the supply."""
    instances = (
        pulse_extender(params).instance("extender"),
        synapse(params).instance("synapse"),
        excitatory_filter(params).instance(
            "excitatory", line="exc", v_syn="v_exc_syn", i_out="i_exc_out", v_thr="v_ethr", v_tau="v_etau"
        ),
        inhibitory_filter(params).instance(
            "inhibitory", line="inh", v_syn="v_inh_syn", i_out="i_inh_out", v_thr="v_ithr", v_tau="v_itau"
        ),
    )
    ports = (SUPPLY, *event_in("event"), *analog_out("i_exc_out", "i_inh_out"))
    return biased("dpi_synapse", ports, BIASES, (), instances)


FIRST_EVENT = 1e-3  # s; ours
MEMBRANE = 0.4  # V, ours: ideal voltage at which both output currents are measured
DECAY_FROM, DECAY_TO = 0.5, 0.1  # of the last peak, between which the decay is measured; ours


def latches(level: float, v_dd: float) -> dict[str, float]:
    """Voltages (V) of the latches for a level from -4 to 4, by name; level 0 lets nothing in.

    Levels 1 to 4 are `weight_0` to `weight_3` of the control software: the constant current alone, with I_w0,
    with I_w1, and with both. Negative levels inhibit. Raises `ParameterError` for another level.
    """
    if level != int(level) or not -4 <= level <= 4:
        raise ParameterError(f"level: {level:g}, must be a whole number from -4 to 4; 0 is off")
    bits = max(abs(int(level)) - 1, 0)
    on = {"recurrent": level != 0, "sign": level > 0, "w0": bool(bits & 1), "w1": bool(bits & 2)}
    return {name: v_dd * up for name, up in on.items()}


def knobs(events: float, rate: float) -> tuple[Stimulus, ...]:
    """What the testbench takes: a level, and unless others are given so many `events` at a `rate`, Hz."""
    return (
        Stimulus("level", "", 1.0, "weight, -4 to 4"),
        Stimulus("events", "", events, "how many events"),
        Stimulus("rate", "Hz", rate, "of the events"),
        DURATION,
    )


STIMULI = knobs(2.0, 1e3)
PLOTTED = ("event", "pulse", "v_exc_syn", "v_inh_syn")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """`events` events at `rate` (Hz) from 1 ms on, at a synapse of a `level`, into ideal voltages."""
    values = {name: value or 0.0 for name, value in stimuli.items()}
    times = train("events", values["events"], values["rate"], FIRST_EVENT)
    held = {"i_exc_out": MEMBRANE, "i_inh_out": MEMBRANE, **latches(values["level"], v_dd)}
    sources = powered(v_dd, {"event": pulse(times, v_dd), **held})
    return rested("DPI synapse", circuit, sources, stimuli["duration"] or times[-1] + 5e-3, ROLLS_180_IDEAL)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `pulse_width_s`, `peak_current_A`, `decay_s` and `charge_C`.

    They are those of the filter of the level's sign, whose current before the first event is taken away.
    decay: the time in which the current falls from half to a tenth of its peak, over ln 5, which is the time
    constant where it falls exponentially. charge: that of the whole run.
    """
    half = half_supply(result.machine)
    excites = bool(result["sign"][0] > half)
    current = np.abs(drain_current(result, "excitatory.md5" if excites else "inhibitory.md7"))
    current = current - float(np.interp(0.99 * FIRST_EVENT, result.time, current))
    return {
        "pulse_width_s": between(rise(result, "pulse"), fall(result, "pulse")),
        "peak_current_A": float(current.max()),
        "decay_s": _decay(result.time, current),
        "charge_C": float(np.trapezoid(current, result.time)),
    }


def _decay(time: F64, current: F64) -> float | None:
    peak = int(current.argmax())
    after, later = current[peak:], time[peak:]
    high, low = (falling_crossing(later, after, share * after[0]) for share in (DECAY_FROM, DECAY_TO))
    took = between(high, low)
    return None if took is None else took / float(np.log(DECAY_FROM / DECAY_TO))


def outcome(result: Result) -> str:
    """`excites`, `inhibits`, or `silent` where the level lets nothing in."""
    half = half_supply(result.machine)
    if result["recurrent"][0] < half:
        return "silent"
    return "excites" if result["sign"][0] > half else "inhibits"


BLOCK = catalogued("dpi-synapse", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
