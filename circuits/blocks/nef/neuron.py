"""Integrate-and-fire neuron of the NEF chip, with a constant leak, a threshold, and a refractory reset.

Its parts are:

* membrane: C_mem takes the input current. An nFET with its gate at `v_leak` draws I_leak from it, which is
  constant while its drain is above 4 U_T. So `C dv_mem/dt = I - I_leak` between reset and threshold.
* threshold: an nFET at v_mem stands against the I_buf of a pFET. `v_o1` falls where `I_n(v_mem) = I_buf`, and
  pulls the membrane up by a pFET, so that the spike is whole; an inverter makes `spike`.
* reset: `spike` fills C_ref to the supply. While `v_ref` is above the threshold V_inv of an inverter, the
  membrane is held at `v_reset`, above 4 U_T up to 40 degC. The reset ends the spike, the sooner the larger
  the input is, so C_k holds it back until C_ref is full. I_rfr empties C_ref: `t_ref = C_ref (V_dd - V_inv) /
  I_rfr`. `v_reset` is the gate voltage at which a transistor like that of the threshold carries I_reset, so
  that V_th - v_reset is PTAT where both currents are. So is I_leak, and Q / I_leak follows no temperature: by
  0.2 % over 40 degrees.

So a steady current fires it at the rate

    r = 1 / (t_ref + Q / (I - I_leak)),    Q = C (V_th - v_reset),    I > I_leak

whose three numbers are a neuron's own on every die. The leak is of the constant kind (linear
integrate-and-fire: Fusi and Mattia 1999; Indiveri et al. 2011, "Neuromorphic silicon neuron circuits").
Topology, sizes and numbers are ours. Nominally, at 27 degC, the least current that fires it is 40 pA, Q /
I_leak is 19 ms, and the refractory period is 2.0 ms: that of the neurons in whose place it stands (Stöckel
2017, II.B), since by it rates saturate as theirs do above the radius.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import powered, step
from circuits.blocks.measure import last_rate, latency, spike_outcome
from circuits.blocks.mos import inverter, mos
from circuits.blocks.ports import SUPPLY, analog_in, biased, event_out
from circuits.blocks.rest import rested
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor, Source
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

LEAK = 40e-12  # A
RESET_CURRENT = 4.83e-12  # A: a reset to 0.15 V at 27 degC, under the ideal law
REFRACTORY_CURRENT = 0.27e-9  # A: a refractory period of 2.0 ms


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors (F) and sizes (um); ours."""

    membrane_capacitance: float = quantity(2e-12, "F")
    refractory_capacitance: float = quantity(0.5e-12, "F")
    hold_capacitance: float = quantity(200e-15, "F")  # holds the reset back until C_ref is full
    leak_width: float = um(0.5)
    leak_length: float = um(4.0)
    # of the transistor that senses the membrane: long, so that V_th is high
    sense_width: float = um(1.0)
    sense_length: float = um(8.0)
    # of what is shut while the membrane charges; off current I_0 / 32
    switch_width: float = um(0.5)
    switch_length: float = um(16.0)
    logic_length: float = um(0.18)


BIASES = (
    Bias("i_leak", "v_leak", "gate", LEAK, "mf1"),
    Bias("i_buf", "v_buf", "gate", 50e-9, "mc2"),
    Bias("i_rfr", "v_rfr", "gate", REFRACTORY_CURRENT, "mk5"),
    Bias("i_reset", "v_reset", "gate", RESET_CURRENT, "mc1"),
)


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports v_mem (current in), spike (event out), biases and the supply."""
    ports = (SUPPLY, *analog_in("v_mem"), *event_out("spike"))
    length, switch = params.logic_length, params.size("switch")
    devices = (
        Capacitor("c_mem", "v_mem", "0", params.membrane_capacitance),
        mos("mf1", "n", "v_mem", "v_leak", "0", *params.size("leak")),
        mos("mc1", "n", "v_o1", "v_mem", "0", *params.size("sense")),
        mos("mc2", "p", "v_o1", "v_buf", "vdd", 1.0, 1.0),
        *inverter("mc3", "v_o1", "spike", width=0.5, length=length),
        mos("mc4", "p", "v_mem", "v_o1", "vdd", *switch),
        Capacitor("c_ref", "v_ref", "0", params.refractory_capacitance),
        *inverter("mk1", "spike", "quiet", width=0.5, length=length),
        mos("mk4", "p", "v_ref", "quiet", "vdd", 0.5, 2.0),
        mos("mk5", "n", "v_ref", "v_rfr", "0", 1.0, 2.0),
        *inverter("mk6", "v_ref", "k1", width=0.5, length=6.0),
        Capacitor("c_k", "k1", "0", params.hold_capacitance),
        *inverter("mk7", "k1", "k2", width=0.5, length=length),
        mos("mk8", "n", "v_mem", "k2", "v_reset", *switch),
    )
    return biased("nef_neuron", ports, BIASES, devices)


STEP_TIME = 1e-3  # s, when the testbench's current begins; ours
STEP_RISE = 1e-6  # s

STIMULI = (
    Stimulus("current", "A", 0.4e-9, "step into the membrane"),
    lasting(12e-3),
)
PLOTTED = ("v_mem", "v_o1", "v_ref", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A step of current into the membrane at 1 ms."""
    values = {name: value or 0.0 for name, value in stimuli.items()}
    current = step(STEP_TIME, STEP_TIME + STEP_RISE, 0.0, values["current"])
    sources = (*powered(v_dd), Source("i_in", "v_mem", current, "current"))
    return rested("NEF neuron", circuit, sources, values["duration"], ROLLS_180_IDEAL, watch=("spike",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `latency_s` from the step to the first spike, and `rate_Hz` of the last interval.

    None where there are no, or fewer than two, spikes.
    """
    return {
        "latency_s": latency(result, STEP_TIME),
        "rate_Hz": last_rate(result.spikes["spike"]),
    }


BLOCK = catalogued("nef-neuron", build, STIMULI, testbench, measures, spike_outcome, PLOTTED, ROLLS_180)
