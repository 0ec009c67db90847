"""Tonic inhibitory neuron, which spikes by itself, and the long synapse that keeps it silent.

A current I_tonic charges the membrane. At the reference a comparator makes a spike, which discharges it:

    T_tonic = C_mem V_ref / I_tonic + C_d (V_dd - V_i) / I_cmp        for as long as nothing inhibits

Two inverters make the edge of the comparator steep, and a starved inverter lets the membrane be discharged
only some 13 us later: by itself the comparator would follow the membrane back before it has risen.

An event at the long synapse holds the membrane at ground for T_hold = C_t V_ref / I_hold; another event makes
that last longer. An event at `end` ends it and starts the membrane from ground. The switch of the synapse
sinks far more than I_tonic, so that the inhibition is complete.

At rest a simulator finds the membrane balanced at the reference, where noise would not leave it. So the
testbench begins while `end` is high, as a chip begins with a reset.

Source: Wen & Horiuchi 2022, section 3, "Evaluation Memory": INH fires tonically, an excitation of the
coincidence detector silences it for around 300 ms (150 ms in Figure 12), and a reset makes it fire again. The
circuit and all numbers are ours: 10 ms and 177 ms, as in the network.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import powered
from circuits.blocks.latency.synapse import comparator_biases, compared, events, timer
from circuits.blocks.latency.tap import starved_inverter
from circuits.blocks.measure import high_time
from circuits.blocks.mos import inverter, mos
from circuits.blocks.ports import SUPPLY, bias_in, biased, event_in, event_out
from circuits.blocks.rest import rested
from circuits.blocks.sizes import Sizes
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor
from circuits.devices.device import Device
from circuits.devices.source import PiecewiseLinear
from circuits.errors import ParameterError
from circuits.event import EDGE, WIDTH
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors, F; ours."""

    membrane_capacitance: float = quantity(5e-12, "F")
    timer_capacitance: float = quantity(5e-12, "F")


BIASES = (
    Bias("i_tonic", "v_tonic", "gate", 1e-9, "cell.mp"),  # ours: 10 ms
    Bias("i_hold", "v_hold", "gate", 57e-12, "hold.mt"),  # ours: 177 ms
    *comparator_biases("cell.threshold.mc0"),
)


def _long_synapse(timer_capacitance: float) -> Circuit:
    """A timer that an event starts anew: ports event, end (events in), on (event out), biases.

    timer_capacitance: F.
    """
    biases = bias_in("v_hold", "v_cmp", "v_ref")
    ports = (SUPPLY, *event_in("event", "end"), *event_out("on"), *biases)
    devices = (
        *timer("event", "v_hold", timer_capacitance),
        *inverter("mi", "end", "going", width=3.0, length=1.5),
        mos("me", "p", "timer", "going", "vdd", 6, 1.5),
        *inverter("mo", "off", "on", width=3.0, length=1.5),
    )
    return Circuit("long_synapse", ports, devices, (compared("timer", "timer", "off"),))


def spike_and_reset(*, held: bool = False) -> tuple[Device, ...]:
    """Devices that make a spike of the node `above`, and then empty the node `v_mem`.

    held: whether the node that empties it falls slowly, by the current set at `v_cmp`. Else a comparator that
    turns back while the membrane has just begun to fall can end the emptying before its end.
    """
    slow = (
        mos("mop", "p", "drain", "late", "vdd", 3, 1.5),
        mos("mon", "n", "drain", "late", "kept", 3, 1.5),
        mos("mos", "n", "kept", "v_cmp", "0", 6, 6),
    )
    return (
        *inverter("ma", "above", "below", width=3.0, length=1.5),
        *inverter("mb", "below", "spike", width=3.0, length=1.5),
        *starved_inverter("spike"),
        *(slow if held else inverter("mo", "late", "drain", width=3.0, length=1.5)),
        mos("mz", "n", "v_mem", "drain", "0", 6, 1.5),
    )


def _tonic_cell(membrane_capacitance: float) -> Circuit:
    """The membrane that spikes by itself: ports stop, restart (events in), spike (event out), biases.

    membrane_capacitance: F.
    """
    biases = bias_in("v_tonic", "v_cmp", "v_ref")
    ports = (SUPPLY, *event_in("stop", "restart"), *event_out("spike"), *biases)
    devices = (
        mos("mp", "p", "v_mem", "v_tonic", "vdd", 6, 24),
        Capacitor("cm", "v_mem", "0", membrane_capacitance),
        *spike_and_reset(),
        mos("mx", "n", "v_mem", "stop", "0", 6, 1.5),
        mos("mq", "n", "v_mem", "restart", "0", 6, 1.5),
    )
    return Circuit("tonic_cell", ports, devices, (compared("threshold", "v_mem", "above"),))


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports event, end (events in), spike (event out), biases and the supply."""
    hold, cell = _long_synapse(params.timer_capacitance), _tonic_cell(params.membrane_capacitance)
    ports = (SUPPLY, *event_in("event", "end"), *event_out("spike"))
    instances = (hold.instance("hold"), cell.instance("cell", stop="on", restart="end"))
    return biased("tonic_neuron", ports, BIASES, (), instances)


START = 20e-6  # s, ours: from which the testbench counts
STOP = 0.25  # s

STIMULI = (
    Stimulus("inhibit", "s", 15e-3, "event of the long synapse", can_be_off=True),
    Stimulus("end", "s", None, "event that ends it", can_be_off=True),
    DURATION,
)
PLOTTED = ("event", "hold.timer", "on", "cell.v_mem", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """`end` is high until 30 us, and for an event so long (s) after 20 us or not; `event` likewise."""
    inhibit, end = stimuli["inhibit"], stimuli["end"]
    if end is not None and end <= 2.0 * WIDTH:
        raise ParameterError(f"end: {end:g} s, must be after the start's event of {WIDTH:g} s, or off")
    event = events(circuit.port("event"), (inhibit,), START, v_dd)
    sources = powered(v_dd, {**event, "end": reset_wave(None if end is None else START + end, v_dd)})
    return rested("tonic neuron", circuit, sources, stimuli["duration"] or STOP, watch=("spike",))


def reset_wave(again: float | None, v_dd: float) -> PiecewiseLinear:
    """A level that is high until `START` + `WIDTH`, and for an event at `again` (s) unless that is None."""
    last = START + WIDTH
    time, volts = [0.0, last, last + EDGE], [v_dd, v_dd, 0.0]
    if again is not None:
        time += [again, again + EDGE, again + EDGE + WIDTH, again + 2.0 * EDGE + WIDTH]
        volts += [0.0, v_dd, v_dd, 0.0]
    return PiecewiseLinear(tuple(time), tuple(volts))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `period_s` of the last two spikes, `hold_s` of the synapse, `silence_s`.

    silence: the longest time between two spikes. None where what is asked for is not in the run.
    """
    spikes = result.spikes["spike"]
    apart = spikes[1:] - spikes[:-1]
    return {
        "period_s": float(apart[-1]) if apart.size else None,
        "hold_s": high_time(result, "on"),
        "silence_s": float(apart.max()) if apart.size else None,
    }


def outcome(result: Result) -> str:
    """`tonic`, or `silent` with no more than one spike."""
    return "tonic" if result.spikes["spike"].size > 1 else "silent"


BLOCK = catalogued("tonic-neuron", build, STIMULI, testbench, measures, outcome, PLOTTED)
