"""Latency memory unit: it stores that a spike came when a tap of the delay line did, and repeats it.

The tap's event is the input A of a coincidence detector CD. It is also the input B, unless the tonic neuron
INH has spiked within the last 20 ms, for which a timer and a gate stand (`gate`). The third input is the
spike of the integrating neuron:

    the integrating neuron's within 3 ms of A:  CD spikes, and silences INH for 177 ms
    INH silent:                                 A and B make CD spike at the tap, which silences INH anew
    a reset:                                    INH spikes again after its period, and B is blocked

So what was stored comes again at every ping, until a reset or a ping that comes too late. CD's spike lasts as
long as its currents overlap, and INH's silence counts from its end.

Source: Wen & Horiuchi 2022, section 3, "Evaluation Memory", Figure 7A. The circuit and all numbers are ours.
"""

from __future__ import annotations

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import powered
from circuits.blocks.latency import coincidence as latency_coincidence
from circuits.blocks.latency import tonic as latency_tonic
from circuits.blocks.latency.synapse import comparator_biases, compared, timer
from circuits.blocks.latency.tonic import Params
from circuits.blocks.measure import latency, spiked
from circuits.blocks.mos import inverter, nand
from circuits.blocks.ports import SUPPLY, bias_in, biased, event_in, event_out
from circuits.blocks.rest import rested
from circuits.circuit import Bias, Circuit, Node
from circuits.devices.source import Pulse
from circuits.errors import ParameterError
from circuits.event import WIDTH, pulse
from circuits.solver.transient import Result
from circuits.testbench import Testbench

BIASES = (
    Bias("i_exc", "v_exc", "gate", 25e-9, "cd.input0.me"),
    Bias("i_window", "v_window", "gate", 3.37e-9, "cd.input0.mt"),
    Bias("i_tonic", "v_tonic", "gate", 1e-9, "inh.cell.mp"),
    Bias("i_hold", "v_hold", "gate", 57e-12, "inh.hold.mt"),
    Bias("i_block", "v_block", "gate", 0.5e-9, "gate.mt"),  # ours: 20 ms, two periods of INH
    *comparator_biases("gate.timer.mc0"),
)


def _inhibited_gate(timer_capacitance: float) -> Circuit:
    """A gate that a timer blocks: ports block, event (events in), out (event out), biases.

    timer_capacitance: F.
    """
    biases = bias_in("v_block", "v_cmp", "v_ref")
    ports = (SUPPLY, *event_in("block", "event"), *event_out("out"), *biases)
    devices = (
        *timer("block", "v_block", timer_capacitance),
        *nand("ma", ("free", "event"), "none", width=3.0, length=1.5),
        *inverter("mo", "none", "out", width=3.0, length=1.5),
    )
    return Circuit("inhibited_gate", ports, devices, (compared("timer", "timer", "free"),))


def build(params: Params = Params()) -> Circuit:  # noqa: B008 - it is frozen
    """The unit: ports tap, integrating, reset (events in), spike (event out), biases and the supply."""
    cd = latency_coincidence.build(latency_coincidence.Params(timer_capacitance=params.timer_capacitance))
    inh, gate = latency_tonic.build(params), _inhibited_gate(params.timer_capacitance)
    inputs = event_in("tap", "integrating", "reset")
    ports = (SUPPLY, *inputs, *event_out("spike"))
    relays = [
        part
        for k, name in ((0, "tap"), (2, "integrating"))
        for part in (
            *inverter(f"mr{k}", name, f"not_{name}", width=3.0, length=1.5),
            *inverter(f"ms{k}", f"not_{name}", f"seen[{k}]", width=3.0, length=1.5),
        )
    ]
    instances = (
        gate.instance("gate", block="inh_spike", event="tap", out="seen[1]"),
        cd.instance("cd", event="seen"),
        inh.instance("inh", event="spike", end="reset", spike="inh_spike"),
    )
    seen = Node("seen", (len(latency_coincidence.INPUTS),))
    return biased("latency_unit", ports, BIASES, tuple(relays), instances, (seen,))


START = latency_tonic.START
FIRST, PERIOD, PINGS = 25e-3, 100e-3, 3  # s, ours: the first tap's event, INH having settled
STOP = 0.36  # s

STIMULI = (
    Stimulus("first", "s", FIRST, "the first tap's event"),
    Stimulus("integrating", "s", 1e-3, "integrating neuron's spike, after the tap's event", can_be_off=True),
    Stimulus("reset", "s", 160e-3, "reset, after the first tap's event", can_be_off=True),
    DURATION,
)
PLOTTED = ("tap", "inh_spike", "gate.timer", "seen[1]", "cd.sum", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A reset until 30 us, three events of the tap, the integrating neuron's about the first, and a reset.

    `integrating` (s) counts from the first event of the tap and may be below zero, or off; so does `reset`,
    which is above zero or off. Raises `ParameterError` for times that do not fit.
    """
    first = stimuli["first"] or 0.0
    if first <= START + WIDTH:
        raise ParameterError(f"first: {first:g} s, must be after the start's reset, {START + WIDTH:g} s")
    taps = tuple(first + k * PERIOD for k in range(PINGS))
    given, again = stimuli["integrating"], stimuli["reset"]
    if given is not None and first + given <= START + WIDTH:
        raise ParameterError(f"integrating: {given:g} s, must be above {START + WIDTH - first:g} s, or off")
    if again is not None and again <= 0.0:
        raise ParameterError(f"reset: {again:g} s, must be > 0 s after the first tap's event, or off")
    sources = powered(
        v_dd,
        {
            "tap": pulse(taps, v_dd),
            "integrating": pulse(() if given is None else (first + given,), v_dd),
            "reset": latency_tonic.reset_wave(None if again is None else first + again, v_dd),
        },
    )
    return rested("latency unit", circuit, sources, stimuli["duration"] or STOP, watch=("spike",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `latency_s`, and `recalls`.

    latency: of the first spike after the first event of the tap, None without a spike. recalls: how many
    later events of the tap have a spike within 1 ms.
    """
    spikes = result.spikes["spike"]
    first, *later = _taps(result)
    near = [t for t in later if ((spikes >= t) & (spikes < t + 1e-3)).any()]
    return {
        "latency_s": latency(result, first),
        "recalls": float(len(near)),
    }


def _taps(result: Result) -> tuple[float, ...]:
    """Times of the tap's events in a run of the testbench, s."""
    (wave,) = (s.waveform for s in result.machine.testbench.sources if s.name == "tap")
    return wave.starts if isinstance(wave, Pulse) else (FIRST,)


def outcome(result: Result) -> str:
    """`remembered` where later pings recall the spike, `seen` where only the first did, or `none`."""
    if not spiked(result):
        return "none"
    return "remembered" if measures(result)["recalls"] else "seen"


BLOCK = catalogued("latency-unit", build, STIMULI, testbench, measures, outcome, PLOTTED)
