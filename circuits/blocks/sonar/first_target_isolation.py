"""First-target isolation: after the array's first spike it shuts off excitation until the next call.

From the first spike on, V_ex,max of all neurons is switched to the supply. Cheely & Horiuchi 2003, section 4,
say what it does; the circuit and its values are ours. Thirteen nFETs pull a line with a pull-up low (a wired
OR). The inverse of the line sets a latch of two cross-coupled NOR gates, and a call resets it: `q = not (call
or q_bar)`, `q_bar = not (set or q)`, `set = spike_0 or ... or spike_12`; a call wins over a spike. Two
transmission gates put `V_dd` on the output while q is high, and the bias `v_ex_max_set` while it is low. So,
ideally, the output is `V_dd` from the first spike after a call to the next call.

The latch has two rest states; `rest(v_dd)` starts a run with the array open.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import elements, powered
from circuits.blocks.measure import between
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, analog_out, bias_in, event_in
from circuits.blocks.sonar.board import LENGTH, inverter, nor, strays, transmission_gate
from circuits.blocks.sonar.centroid_board import NEURONS, neuron_index
from circuits.circuit import Bias, Circuit, Instance, Port
from circuits.devices import Capacitor, Resistor
from circuits.event import falling_crossing, pulse, rising_crossing
from circuits.lowering.supply import half_supply
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

V_EX_MAX = 4.301  # V, of the rebound neuron's facts: I_max 1 nA


@dataclass(frozen=True, slots=True)
class Params:
    """Pull-up (Ohm) and capacitance of the load (F); ours.

    The load is a pad (2 pF) and the gates' side of 13 synapses (20 fF each).
    """

    pull_up_resistance: float = quantity(20e3, "Ohm")
    load_capacitance: float = quantity(2e-12 + NEURONS * 20e-15, "F")


def build(params: Params = Params()) -> Circuit:
    """The board: ports spike[13], call (events in), v_ex_max_set (bias), v_ex_max (out) and the supply."""
    spike = Port("spike", "event", shape=(NEURONS,))
    ports = (SUPPLY, spike, *event_in("call"), *bias_in("v_ex_max_set"), *analog_out("v_ex_max"))
    devices = (
        *(mos(f"m_or{k}", "n", "quiet", f"spike[{k}]", "0", 6, LENGTH) for k in range(NEURONS)),
        Resistor("r_pull_up", "vdd", "quiet", params.pull_up_resistance),
        *inverter("i_set", "quiet", "set"),
        *nor("nor_q", "call", "q_bar", "q"),
        *nor("nor_q_bar", "set", "q", "q_bar"),
        *inverter("i_open", "q", "open"),
        Capacitor("c_load", "v_ex_max", "0", params.load_capacitance),
        *strays("quiet", "set", "q", "q_bar", "open"),
    )
    gate = transmission_gate()
    wires = {"vdd": "vdd", "b": "v_ex_max"}
    gates = (
        Instance("isolate", gate, wires | {"control": "q", "a": "vdd"}),
        Instance("pass", gate, wires | {"control": "open", "a": "v_ex_max_set"}),
    )
    biases = (Bias("v_ex_max_set", "v_ex_max_set", "voltage", V_EX_MAX),)
    return Circuit("first_target_isolation", ports, devices, gates, biases=biases)


def rest(v_dd: float) -> dict[str, float]:
    """Start voltages (V), by node, of the rest state in which the array is open; v_dd: V."""
    return {"q": 0.0, "q_bar": v_dd}


STIMULI = (
    Stimulus("neuron", "", 2.0, "index of the neuron that spikes"),
    Stimulus("spike", "s", 0.1e-3, "time of the spike", can_be_off=True),
    Stimulus("call", "s", 0.3e-3, "time of the call", can_be_off=True),
    lasting(0.4e-3),
)
PLOTTED = ("call", "spike[2]", "q", "v_ex_max")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A spike of `neuron` at `spike` (s) and a call at `call` (s), each of which can be off.

    `duration` is the length of the run, s.
    """
    stop = stimuli["duration"] or 0.0
    neuron = neuron_index("neuron", stimuli["neuron"])
    spike, call = (() if time is None else (time,) for time in (stimuli["spike"], stimuli["call"]))
    spikes = elements(circuit.port("spike"), {neuron: pulse(spike, v_dd)})
    sources = powered(v_dd, {"call": pulse(call, v_dd), **spikes})
    return Testbench("first-target isolation", circuit, sources, stop, start=rest(v_dd))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `set_delay_s`, `reset_delay_s`, `v_ex_max_V` at the end, and `v_ex_max_peak_V`.

    A delay is from when the first spike or call passes half the supply to when the output passes the middle
    of its two levels; None where either does not happen.
    """
    process = result.machine.silicon.process
    half, level = 0.5 * process.v_dd, 0.5 * (process.v_dd + float(result["v_ex_max_set"][0]))
    spikes = [rising_crossing(result.time, result[f"spike[{k}]"], half) for k in range(NEURONS)]
    spike = min((t for t in spikes if t is not None), default=None)
    out = result["v_ex_max"]
    return {
        "set_delay_s": between(spike, rising_crossing(result.time, out, level)),
        "reset_delay_s": between(
            rising_crossing(result.time, result["call"], half), falling_crossing(result.time, out, level)
        ),
        "v_ex_max_V": float(out[-1]),
        "v_ex_max_peak_V": float(out.max()),
    }


def outcome(result: Result) -> str:
    """`isolated` or `open`, at the end of the run."""
    half = half_supply(result.machine)
    return "isolated" if float(result["q"][-1]) > half else "open"


BLOCK = catalogued("first-target-isolation", build, STIMULI, testbench, measures, outcome, PLOTTED)
