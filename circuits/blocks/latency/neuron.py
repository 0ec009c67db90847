"""Integrate-and-fire neuron with step-current synapses: spike latencies in, one spike latency out.

Each synapse answers an event by a current E_0 into the membrane for a fixed time, and the membrane spikes
where it comes to a reference: with inputs at t_1 to t_n, as long as all currents are on,

    T_eval = (C_mem V_ref + E_0 sum t_i) / (n E_0)          (9)

The synapses are those of `circuits.blocks.latency.synapse`.

`spike` rises where the membrane passes the reference, and stays until `reset`, the ping, which discharges the
membrane: one spike a ping. After the spike the currents flow on into a membrane that ends at the supply.

Source: Wen & Horiuchi 2022, section 3, equation (9), step of 20 ms; circuit and all numbers are ours: 8 ms
from one input to the spike, and parasitics of about a hundredth of the capacitors, which are large for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from circuits.blocks.block import Block, Stimulus, Values
from circuits.blocks.latency.synapse import comparator, event_sources, step_synapse
from circuits.blocks.mos import mos
from circuits.blocks.rest import started_at_rest
from circuits.checks import require_positive
from circuits.circuit import Bias, Circuit, Instance, Port
from circuits.count import whole_number
from circuits.devices import Capacitor, Source
from circuits.devices.source import Constant
from circuits.event import falling_crossing, pulse, rising_crossing
from circuits.lowering.supply import half_supply
from circuits.silicon.process import AMI_1500
from circuits.solver.power import supply_power
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

INPUTS = 3  # of the block as it is simulated by itself
REFERENCE = 2.0  # V


@dataclass(frozen=True, slots=True)
class Params:
    """Capacitors in farad, number of synapses; ours. Raises `ParameterError` for what cannot be built."""

    membrane_capacitance: float = quantity(10e-12, "F")
    timer_capacitance: float = quantity(5e-12, "F")
    synapses: int = quantity(INPUTS, "")

    def __post_init__(self) -> None:
        require_positive(self, "membrane_capacitance", "timer_capacitance")
        whole_number("synapses", self.synapses)


BIASES = (
    Bias("i_exc", "v_exc", "gate", 2.5e-9, "synapse0.me"),  # E_0; ours: 8 ms
    Bias("i_step", "v_step", "gate", 0.5e-9, "synapse0.mt"),  # ours: 20 ms
    Bias("i_cmp", "v_cmp", "gate", 50e-9, "threshold.mc0"),
    Bias("v_ref", "v_ref", "voltage", REFERENCE),
)


def build(params: Params = Params()) -> Circuit:
    """Ports event[n] (in), reset (event in), spike (event out), biases and the supply."""
    part, threshold = step_synapse(params.timer_capacitance), comparator()
    count = int(params.synapses)
    ports = (
        Port("vdd", "supply"),
        Port("event", "event", "in", (count,)),
        Port("reset", "event"),
        Port("spike", "event", "out"),
        *(Port(b.port, "bias") for b in BIASES),
    )
    devices = (
        Capacitor("cm", "v_mem", "0", params.membrane_capacitance),
        mos("mz", "n", "v_mem", "reset", "0", 6, 1.5),
    )
    synapses = [Instance(f"synapse{k}", part, part.wired(event=f"event[{k}]")) for k in range(count)]
    plus = threshold.wired(plus="v_mem", above="spike")
    return Circuit(
        "latency_neuron", ports, devices, (*synapses, Instance("threshold", threshold, plus)), biases=BIASES
    )


PING = 20e-6  # s, ours: the testbench's reset
STOP = 30e-3  # s


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """Reset at 20 us, and an event at each of the first three synapses, `first` to `third` after it."""
    times = (stimuli["first"], stimuli["second"], stimuli["third"])
    count = circuit.port("event").shape[0]
    sources = (
        Source("vdd", "vdd", Constant(v_dd)),
        Source("reset", "reset", pulse((PING,), v_dd)),
        *event_sources("event", times, count, PING, v_dd),
    )
    bench = Testbench("latency neuron", circuit, sources, stimuli["duration"] or STOP, watch=("spike",))
    return started_at_rest(bench, AMI_1500)


def latencies(result: Result) -> Iterator[float]:
    """Times of the spike's rises after the ping, s."""
    yield from (float(t) - PING for t in result.spikes["spike"])


def measures(result: Result) -> dict[str, float | None]:
    """`latency_s` of the spike after the ping, `step_s` of the first synapse, `supply_power_W`.

    step: from the first synapse's switch closing to its opening; None where either is not in the run.
    """
    half = half_supply(result.machine)
    off = result["synapse0.off"]
    closes, opens = falling_crossing(result.time, off, half), rising_crossing(result.time, off, half)
    return {
        "latency_s": next(latencies(result), None),
        "step_s": None if closes is None or opens is None or opens <= closes else opens - closes,
        "supply_power_W": supply_power(result),
    }


def outcome(result: Result) -> str:
    """`spike`, or `none`."""
    return "spike" if result.spikes["spike"].size else "none"


BLOCK = Block(
    name="latency-neuron",
    summary="integrate-and-fire neuron with 20 ms step-current synapses: latencies in, one latency out",
    params=Params,
    build=build,
    stimuli=(
        Stimulus("first", "s", 3e-3, "first event after the ping", can_be_off=True),
        Stimulus("second", "s", 6e-3, "second event", can_be_off=True),
        Stimulus("third", "s", None, "third event", can_be_off=True),
        Stimulus("duration", "s", None, "length of the run", can_be_off=True),
    ),
    testbench=testbench,
    measures=measures,
    outcome=outcome,
    plotted=("event[0]", "synapse0.timer", "synapse0.off", "v_mem", "spike"),
)
