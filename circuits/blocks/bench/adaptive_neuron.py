"""Adaptive integrate-and-fire neuron of the teaching chip, with a DPI as its leak.

* input: a direct current through an enabling switch, which the refractory time cuts off.
* leak: the input is divided between ground and the membrane by a pair of pFETs with gates v_gain and v_mem,
  and a leak draws from the membrane:
  `C dv/dt = I_in / (1 + e^(kappa (v_mem - v_gain) / U_T)) + I_fb - I_leak`.
* spike: an inverter between two diodes, which keep its current small. The upper diode's current is mirrored
  into the membrane once the inverter turns: the positive feedback.
* refractory: the spike charges C_refr at once, and I_refr empties it. While it is high the membrane is held
  at ground: `t_refr = C_refr (V_dd - V_off) / I_refr`.
* adaptation, where `adapt` is high: spikes feed a DPI, and a mirror draws its current from the membrane.

Source: parts, sizes, capacitors (32 um and 22.2 um square) and the biases' codes are the laboratory's list.
How they are wired is ours where the list leaves it open: the refractory switch in the input's branch, the
acknowledge, which comes a tenth of a microsecond after the spike, so that this is whole, and the adaptation,
whose biases are ours too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import powered
from circuits.blocks.measure import last_rate, spike_outcome
from circuits.blocks.mos import current_mirror, mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in, biased, event_out
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor
from circuits.silicon.process import ROLLS_180
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors (F) and sizes (um)."""

    membrane_capacitance: float = quantity(2.08e-12, "F")
    refractory_capacitance: float = quantity(1e-12, "F")
    adaptation_capacitance: float = quantity(1e-12, "F")
    acknowledge_capacitance: float = quantity(1e-12, "F")  # makes the acknowledge late; ours
    line_capacitance: float = quantity(0.0, "F", least=0.0)  # of the membrane, beside: the buffer's input
    input_width: float = um(3.4)
    input_length: float = um(1.0)
    pair_width: float = um(4.0)  # of what is square: the pairs, leaks and discharges
    pair_length: float = um(4.0)
    spike_width: float = um(2.0)
    spike_length: float = um(2.0)
    switch_length: float = um(0.25)
    logic_width: float = um(0.5)
    logic_length: float = um(0.5)


def soma(params: Params) -> Circuit:
    """Input, leak and spike: ports v_mem, v_refr, spike (out), v_dc, dc_off, v_gain, v_leak, the supply."""
    given, pair, core, logic = params.sizes("input", "pair", "spike", "logic")
    biases = bias_in("v_dc", "dc_off", "v_gain", "v_leak")
    return Circuit(
        "adaptive_soma",
        (SUPPLY, *analog_in("v_refr"), *analog_out("v_mem"), *event_out("spike"), *biases),
        (
            mos("m_dc", "p", "d1", "v_dc", "vdd", *given),
            mos("m_dcen", "p", "d2", "dc_off", "d1", *given),
            mos("m_rst", "p", "i_in", "v_refr", "d2", *given),
            mos("m_gain", "p", "0", "v_gain", "i_in", *pair),
            mos("m_mem", "p", "v_mem", "v_mem", "i_in", *pair),
            mos("m_leak", "n", "v_mem", "v_leak", "0", *pair),
            Capacitor("c_mem", "v_mem", "0", params.membrane_capacitance + params.line_capacitance),
            mos("m3", "p", "high", "high", "vdd", *core),
            mos("m4", "p", "v_o", "v_mem", "high", *core),
            mos("m5", "n", "v_o", "v_mem", "low", *core),
            mos("m6", "n", "low", "low", "0", *core),
            mos("m2", "p", "back", "high", "vdd", 2.0 * core[0], core[1]),
            mos("m1", "p", "v_mem", "v_o", "back", core[0], params.switch_length),
            mos("mop", "p", "spike", "v_o", "vdd", *logic),
            mos("mon", "n", "spike", "v_o", "0", *logic),
        ),
    )


def refractory(params: Params) -> Circuit:
    """What holds the membrane at ground after a spike: ports spike (in), v_mem, v_ref, v_refr, the supply.

    v_ref: its bias; v_refr: its capacitor, high while the membrane is held.
    """
    logic = params.size("logic")
    return Circuit(
        "adaptive_refractory",
        (SUPPLY, *analog_in("spike"), *analog_out("v_mem", "v_refr"), *bias_in("v_ref")),
        (
            mos("mr1", "p", "r1", "spike", "vdd", *logic),
            mos("mr2", "n", "r1", "spike", "0", *logic),
            Capacitor("c_ack", "r1", "0", params.acknowledge_capacitance),
            mos("mr3", "p", "v_refr", "r1", "vdd", *logic),
            mos("mr4", "n", "v_refr", "v_ref", "0", *params.size("pair")),
            Capacitor("c_refr", "v_refr", "0", params.refractory_capacitance),
            mos("mr5", "n", "v_mem", "v_refr", "0", *logic),
        ),
    )


def adaptation(params: Params) -> Circuit:
    """A DPI that spikes feed, and what draws its current: ports spike (in), v_mem, v_adp, adapt, biases."""
    pair, weight = params.sizes("pair", "spike")
    switch = params.spike_width, params.logic_length
    biases = bias_in("adapt", "v_aw", "v_athr", "v_atau", "v_casc")
    return Circuit(
        "adaptation_dpi",
        (SUPPLY, *analog_in("spike"), *analog_out("v_mem", "v_adp"), *biases),
        (
            mos("ma1", "n", "w1", "adapt", "0", *switch),
            mos("ma2", "n", "w2", "spike", "w1", *switch),
            mos("ma3", "n", "w3", "v_aw", "w2", *weight),
            mos("ma4", "n", "vdd", "v_athr", "w3", *pair),
            mos("ma5", "n", "v_adp", "v_adp", "w3", *pair),
            mos("ma6", "p", "v_adp", "v_atau", "vdd", *pair),
            Capacitor("c_adp", "vdd", "v_adp", params.adaptation_capacitance),
            mos("ma7", "p", "v_m", "v_adp", "vdd", 2.0 * weight[0], weight[1]),
            *current_mirror("ma8", "ma9", "n", "v_m", "x1", pair),
            mos("ma10", "n", "x2", "v_casc", "x1", *switch),
            mos("ma11", "n", "v_mem", "adapt", "x2", *switch),
        ),
    )


SQUARE = (4.0, 4.0)
BIASES = (
    coded_bias("dc", MASTERS[3], 10, "soma.m_dc", (3.4, 1.0)),
    coded_bias("gain", MASTERS[0], 6, "soma.m_leak", SQUARE),  # of type N, though it is a pFET's gate
    coded_bias("leak", MASTERS[0], 2, "soma.m_leak", SQUARE),
    coded_bias("ref", MASTERS[3], 10, "refractory.mr4", SQUARE),
    coded_bias("aw", MASTERS[2], 100, "adaptation.ma3", (2.0, 2.0)),  # of the adaptation: ours
    coded_bias("athr", MASTERS[0], 40, "adaptation.ma6", SQUARE),
    coded_bias("atau", MASTERS[0], 5, "adaptation.ma6", SQUARE),
    Bias("v_casc", "v_casc", "voltage", 0.9),
    Bias("v_dc_off", "dc_off", "voltage", 0.0),
    Bias("v_adapt", "adapt", "voltage", 0.0),
)


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports v_mem, spike (out), biases and the supply; params: capacitors and sizes."""
    instances = (
        soma(params).instance("soma"),
        refractory(params).instance("refractory"),
        adaptation(params).instance("adaptation"),
    )
    ports = (SUPPLY, *analog_out("v_mem"), *event_out("spike"))
    return biased("adaptive_neuron", ports, BIASES, (), instances)


DURATION = 60e-3  # s

STIMULI = (
    Stimulus("adapt", "", None, "whether spikes slow it down", can_be_off=True),
    lasting(DURATION),
)
PLOTTED = ("v_mem", "soma.v_o", "v_refr", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A direct current, from a membrane at ground on; with `adapt` the adaptation is on."""
    sources = powered(v_dd, {"adapt": 0.0 if stimuli["adapt"] is None else v_dd})
    stop = stimuli["duration"] or DURATION
    begin = {"v_mem": 0.0}
    return Testbench("adaptive neuron", circuit, sources, stop, watch=("spike",), initial=begin)


HELD = 0.1  # V, below which the membrane is held at ground


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `interval_s`, `rate_Hz`, `refractory_s`, `adaptation` and `peak_V`.

    interval, rate: of the last two spikes. refractory: from the last spike but one until the membrane is
    above 0.1 V again. adaptation: the last interval over the first, None below three spikes. peak: the
    highest v_mem.
    """
    spikes = result.spikes["spike"]
    gaps = spikes[1:] - spikes[:-1]
    return {
        "interval_s": float(gaps[-1]) if gaps.size else None,
        "rate_Hz": last_rate(spikes),
        "refractory_s": _refractory(result, float(spikes[-2])) if gaps.size else None,
        "adaptation": float(gaps[-1] / gaps[0]) if gaps.size > 1 else None,
        "peak_V": float(result["v_mem"].max()),
    }


def _refractory(result: Result, since: float) -> float | None:
    """How long the membrane is below 0.1 V after a spike at `since`, s."""
    after = result.time > since
    time, held = result.time[after], result["v_mem"][after] < HELD
    if not held.any():
        return None
    first = int(np.argmax(held))
    free = np.flatnonzero(~held[first:])
    return float(time[first + free[0]] - since) if free.size else None


BLOCK = catalogued("adaptive-neuron", build, STIMULI, testbench, measures, spike_outcome, PLOTTED, ROLLS_180)
