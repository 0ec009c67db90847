"""Coincidence detector: it spikes where two of its three inputs come within a window of each other.

Each input switches the same current on for the length of the window (`circuits.blocks.latency.synapse`). The
currents meet at the node `sum`, from which the transistor `mk` takes 1.4 of them away:

    sum rises where two currents or more are on:  |t_i - t_j| < T_w = C_t V_ref / I_window

less the 15 us that the node takes to rise. What `mk` takes is a copy of what 1.4 inputs would give: `me`, of
the inputs' length and gate and 1.4 times their width, feeds the mirror, so that whatever all devices share
moves both alike. One input is as far below it as two inputs are above it, by a factor of the square root of
2. Two inverters make the spike, which lasts as long as the overlap. An input that comes again within the
window lengthens its own step, and coincides with nothing.

Source: Wen & Horiuchi 2022, section 3, "Evaluation Memory": the coincidence detector of a latency unit is
excited by A, B and the integrating neuron, and spikes where two of them do within 3 ms. Circuit and numbers
are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import powered
from circuits.blocks.latency.synapse import comparator_biases, events, step_synapse
from circuits.blocks.measure import latency, low_time, spiking
from circuits.blocks.mos import current_mirror, inverter, mos
from circuits.blocks.ports import SUPPLY, biased, event_out
from circuits.blocks.rest import rested
from circuits.blocks.sizes import Sizes
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

INPUTS = ("A", "B", "integrating")
SHARE = 1.4  # of an input's current that is taken away; ours, between 1 and 2 by equal factors


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors, F; ours."""

    timer_capacitance: float = quantity(5e-12, "F")
    sum_capacitance: float = quantity(20e-15, "F")


BIASES = (
    Bias("i_exc", "v_exc", "gate", 25e-9, "input0.me"),
    Bias("i_window", "v_window", "gate", 3.37e-9, "input0.mt"),  # ours: 3 ms
    *comparator_biases("input0.timer.mc0"),
)


def build(params: Params = Params()) -> Circuit:
    """The detector: ports event[3] (inputs A, B, integrating), spike (event out), biases and the supply."""
    part = step_synapse(params.timer_capacitance)
    event = Port("event", "event", "in", (len(INPUTS),))
    ports = (SUPPLY, event, *event_out("spike"))
    devices = (
        mos("ms", "p", "foot", "0", "vdd", 6, 1.5),  # as the inputs' switches, which are on
        mos("me", "p", "taken", "v_exc", "foot", SHARE * 6, 24),
        *current_mirror("md", "mk", "n", "taken", "sum", (6, 24)),
        Capacitor("cs", "sum", "0", params.sum_capacitance),
        *inverter("mi", "sum", "none", width=3.0, length=1.5),
        *inverter("mj", "none", "spike", width=3.0, length=1.5),
    )
    inputs = tuple(
        part.instance(f"input{k}", event=node, v_step="v_window", v_mem="sum")
        for k, node in enumerate(event.elements())
    )
    return biased("latency_coincidence", ports, BIASES, devices, inputs)


START = 1e-3  # s, ours: the first input of the testbench
STOP = 12e-3  # s

STIMULI = (
    Stimulus("second", "s", 2e-3, "second input after the first", can_be_off=True),
    Stimulus("third", "s", None, "third input after the first", can_be_off=True),
    DURATION,
)
PLOTTED = ("event[0]", "event[1]", "input0.timer", "sum", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """The first input comes at 1 ms, and the others `second` and `third` (s) after it, or not at all."""
    times = (0.0, stimuli["second"], stimuli["third"])
    sources = powered(v_dd, events(circuit.port("event"), times, START, v_dd))
    return rested("coincidence", circuit, sources, stimuli["duration"] or STOP, watch=("spike",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `latency_s`, from the first input to the spike, and `window_s`.

    window: how long the current of the first input is on. None where what is asked for is not in the run.
    """
    return {
        "latency_s": latency(result, START),
        "window_s": low_time(result, "input0.off"),
    }


outcome = spiking("coincidence", "none")

BLOCK = catalogued("coincidence-detector", build, STIMULI, testbench, measures, outcome, PLOTTED)
