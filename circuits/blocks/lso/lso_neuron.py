"""Neuron of the lateral superior olive: it spikes for what one ear hears more than the other.

Every event of the near ear switches a current I on for a time T, and every event of the far ear switches on
one that is taken away. The synapses of both are those of `circuits.blocks.latency.synapse`, and a mirror
turns the sum of the inhibitory ones around. So both sides come from pFETs of the same lines, and nothing but
local mismatch tells them apart. The membrane integrates what is left and is emptied at the reference:

    C dV/dt = I (n_exc - n_inh),  V >= 0;    spike and V = 0 at V_ref
    spikes of simultaneous inputs = (n_exc - n_inh) I T / (C V_ref),    T = C_t V_ref / I_step

The number of spikes is a ratio of two currents, which neither temperature nor the process moves. Each spike
costs a dead time of some 8 us: two inverters make the edge of the comparator steep, and a starved inverter
empties the membrane a little later, as in `circuits.blocks.latency.tonic`. The node that empties it falls
slowly as well, so that the membrane is at ground on any die before it is let go. The call, at `reset`,
empties the membrane too.

Source: Cheely & Horiuchi 2003, section 4, names the circuit (their reference 23, Horiuchi & Hynna 2001):
excitation from one side and inhibition from the other. The circuit and all numbers are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import Wave, powered
from circuits.blocks.latency.synapse import comparator_biases, compared, events, step_synapse
from circuits.blocks.latency.tonic import START, reset_wave, spike_and_reset
from circuits.blocks.measure import latency, low_time, spiking
from circuits.blocks.mos import current_mirror, mos
from circuits.blocks.ports import SUPPLY, analog_in, bias_in, biased, event_in, event_out
from circuits.blocks.rest import rested
from circuits.blocks.sizes import Sizes
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor
from circuits.errors import ParameterError
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors (F) and numbers of synapses; ours."""

    membrane_capacitance: float = quantity(5e-12, "F")
    timer_capacitance: float = quantity(5e-12, "F")
    excitations: int = quantity(2, "")
    inhibitions: int = quantity(2, "")


BIASES = (
    Bias("i_exc", "v_exc", "gate", 6e-9, "excite0.me"),  # I; ours: 2.4 spikes an input
    Bias("i_step", "v_step", "gate", 2.5e-9, "excite0.mt"),  # ours: T is 4 ms
    *comparator_biases("cell.threshold.mc0"),
)


def _spiking_cell(membrane_capacitance: float) -> Circuit:
    """A membrane that spikes and is emptied: ports v_mem (currents in), reset (event in), spike, biases.

    membrane_capacitance: F.
    """
    events = (*event_in("reset"), *event_out("spike"))
    ports = (SUPPLY, *analog_in("v_mem"), *events, *bias_in("v_cmp", "v_ref"))
    devices = (
        Capacitor("cm", "v_mem", "0", membrane_capacitance),
        *spike_and_reset(held=True),
        mos("mq", "n", "v_mem", "reset", "0", 6, 1.5),
    )
    return Circuit("spiking_cell", ports, devices, (compared("threshold", "v_mem", "above"),))


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports excite[n], inhibit[m], reset (events in), spike (out), biases and the supply."""
    synapse, cell = step_synapse(params.timer_capacitance), _spiking_cell(params.membrane_capacitance)
    counts = {"excite": int(params.excitations), "inhibit": int(params.inhibitions)}
    ports = (
        SUPPLY,
        *(Port(name, "event", "in", (count,)) for name, count in counts.items()),
        *event_in("reset"),
        *event_out("spike"),
    )
    devices = current_mirror("md", "mk", "n", "turned", "v_mem", (12, 12))
    into = {"excite": "v_mem", "inhibit": "turned"}
    synapses = (
        synapse.instance(f"{name}{k}", event=f"{name}[{k}]", v_mem=into[name])
        for name, count in counts.items()
        for k in range(count)
    )
    return biased("lso_neuron", ports, BIASES, devices, (*synapses, cell.instance("cell")))


STOP = 10e-3  # s

STIMULI = (
    Stimulus("excite_1", "s", 0.5e-3, "first event of the near ear, after the reset", can_be_off=True),
    Stimulus("excite_2", "s", 0.54e-3, "second event of the near ear", can_be_off=True),
    Stimulus("inhibit_1", "s", 0.6e-3, "first event of the far ear", can_be_off=True),
    Stimulus("inhibit_2", "s", None, "second event of the far ear", can_be_off=True),
    DURATION,
)
PLOTTED = ("excite[0]", "inhibit[0]", "turned", "v_mem", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A reset until 30 us, and events at the first two synapses of either side so long (s) after 20 us.

    Each of the events can be off. Raises `ParameterError` for an event at a synapse that is not there.
    """
    waves: dict[str, Wave] = {"reset": reset_wave(None, v_dd)}
    for port in (circuit.port("excite"), circuit.port("inhibit")):
        times = (stimuli[f"{port.name}_1"], stimuli[f"{port.name}_2"])
        if port.shape[0] < 2 and times[1] is not None:
            found = f"{port.name}_2: {times[1]:g} s"
            raise ParameterError(f"{found}, there is one synapse; give off, or two synapses")
        waves |= events(port, times, START, v_dd)
    stop = stimuli["duration"] or STOP
    return rested("lso neuron", circuit, powered(v_dd, waves), stop, watch=("spike",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `spikes`, `latency_s` of the first after the reset, `step_s` of a synapse.

    step: from the closing of the first excitatory synapse's switch to its opening. None where what is asked
    for is not in the run.
    """
    return {
        "spikes": float(result.spikes["spike"].size),
        "latency_s": latency(result, START),
        "step_s": low_time(result, "excite0.off"),
    }


outcome = spiking("spikes", "silent")

BLOCK = catalogued("lso-neuron", build, STIMULI, testbench, measures, outcome, PLOTTED)
