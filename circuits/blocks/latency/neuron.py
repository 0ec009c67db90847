"""Integrate-and-fire neuron with step-current synapses, which turns spike latencies into a latency.

Each synapse (`circuits.blocks.latency.synapse`) answers an event by a current E_0 into the membrane for a
fixed time, and the membrane spikes where it comes to a reference. With inputs at t_1 to t_n, and as long as
all currents are on,

    T_eval = (C_mem V_ref + E_0 sum t_i) / (n E_0)          (9)

`spike` rises where the membrane passes the reference, and stays high until the ping at `reset` discharges the
membrane: one spike for each ping. After the spike the currents flow on, into a membrane that ends at the
supply.

Source: Wen & Horiuchi 2022, section 3, equation (9), step of 20 ms. The circuit and all numbers are ours: 8
ms from one input to the spike, and parasitics of about a hundredth of the capacitors, which are large for it.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import powered
from circuits.blocks.latency.synapse import MembraneSizes, comparator_biases, compared, events, step_synapse
from circuits.blocks.measure import latency, low_time, spiking
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, biased, event_in, event_out
from circuits.blocks.rest import rested
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor
from circuits.event import pulse
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

INPUTS = 3  # of the block as it is simulated by itself


@dataclass(frozen=True, slots=True)
class Params(MembraneSizes):
    """Capacitors (F) and number of synapses; ours."""

    synapses: int = quantity(INPUTS, "")


BIASES = (
    Bias("i_exc", "v_exc", "gate", 2.5e-9, "synapse0.me"),  # E_0; ours: 8 ms
    Bias("i_step", "v_step", "gate", 0.5e-9, "synapse0.mt"),  # ours: 20 ms
    *comparator_biases("threshold.mc0"),
)


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports event[n], reset (events in), spike (event out), biases and the supply."""
    part = step_synapse(params.timer_capacitance)
    event = Port("event", "event", "in", (int(params.synapses),))
    ports = (SUPPLY, event, *event_in("reset"), *event_out("spike"))
    devices = (
        Capacitor("cm", "v_mem", "0", params.membrane_capacitance),
        mos("mz", "n", "v_mem", "reset", "0", 6, 1.5),
    )
    synapses = (part.instance(f"synapse{k}", event=node) for k, node in enumerate(event.elements()))
    threshold = compared("threshold", "v_mem", "spike")
    return biased("latency_neuron", ports, BIASES, devices, (*synapses, threshold))


PING = 20e-6  # s, ours: the testbench's reset
STOP = 30e-3  # s

STIMULI = (
    Stimulus("first", "s", 3e-3, "first event after the ping", can_be_off=True),
    Stimulus("second", "s", 6e-3, "second event", can_be_off=True),
    Stimulus("third", "s", None, "third event", can_be_off=True),
    DURATION,
)
PLOTTED = ("event[0]", "synapse0.timer", "synapse0.off", "v_mem", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """The ping at 20 us, and an event at each of three synapses so long (s) after it, or none."""
    times = (stimuli["first"], stimuli["second"], stimuli["third"])
    inputs = events(circuit.port("event"), times, PING, v_dd)
    sources = powered(v_dd, {"reset": pulse((PING,), v_dd), **inputs})
    return rested("latency neuron", circuit, sources, stimuli["duration"] or STOP, watch=("spike",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `latency_s` from the ping to the spike, and `step_s` of the first synapse.

    step: from the closing of the first synapse's switch to its opening. None where what is asked for is not
    in the run.
    """
    return {
        "latency_s": latency(result, PING),
        "step_s": low_time(result, "synapse0.off"),
    }


outcome = spiking("spike", "none")

BLOCK = catalogued("latency-neuron", build, STIMULI, testbench, measures, outcome, PLOTTED)
