"""Tap of a delay line: an event in, an event out a fixed time later.

The event discharges the timer's capacitor, the starved source `mt` charges it again, and where it passes the
reference the comparator of `circuits.blocks.latency.synapse` makes the next event, which lasts until the
starved inverter `md` has followed:

    T_tap = T_in + C_t V_ref / I_tap,    T_out = C_d (V_dd - V_i) / I_cmp

T_in being the width of the event, which holds the capacitor at ground, and V_i the threshold of an inverter.
Two inverters make the comparator's edge steep, so that at the event the gate closes before `late` has risen.
Taps in a row are a delay line. A second event before the first has left starts the tap anew: the first is
lost.

Source: Wen & Horiuchi 2022, section 3, "Evaluation Memory": neurons in series, each of which makes the next
one fire with a fixed delay; circuit and all numbers are ours, 3 ms as in the network.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import Block, Stimulus, Values
from circuits.blocks.latency.synapse import comparator, timer
from circuits.blocks.mos import inverter, mos, nand
from circuits.blocks.rest import started_at_rest
from circuits.checks import require_positive
from circuits.circuit import Bias, Circuit, Instance, Port
from circuits.count import whole_number
from circuits.devices import Capacitor, Source
from circuits.devices.device import Device
from circuits.devices.source import Constant
from circuits.event import falling_crossing, pulse, rising_crossing
from circuits.lowering.supply import half_supply
from circuits.silicon.process import AMI_1500
from circuits.solver.power import supply_power
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

REFERENCE = 2.0  # V
PULSE_CAPACITANCE = 0.2e-12  # F; ours: events of some 10 us


@dataclass(frozen=True, slots=True)
class Params:
    """Timer capacitance in farad, taps in a row; ours. Raises `ParameterError` for what cannot be built."""

    timer_capacitance: float = quantity(5e-12, "F")
    taps: int = quantity(2, "")

    def __post_init__(self) -> None:
        require_positive(self, "timer_capacitance")
        whole_number("taps", self.taps)


BIASES = (
    Bias("i_tap", "v_tap", "gate", 3.34e-9, "tap.mt"),  # ours: 3 ms
    Bias("i_cmp", "v_cmp", "gate", 50e-9, "tap.timer.mc0"),
    Bias("v_ref", "v_ref", "voltage", REFERENCE),
)


def edge_event(level: str) -> tuple[Device, ...]:
    """An event at node `out` where node `level` rises, which the starved inverter at `v_cmp` ends."""
    return (
        *inverter("mp", level, "going", width=3.0, length=1.5),
        *inverter("mg", "going", "gone", width=3.0, length=1.5),
        mos("mdp", "p", "late", "gone", "vdd", 3, 6),
        mos("mdn", "n", "late", "gone", "starved", 3, 1.5),
        mos("mds", "n", "starved", "v_cmp", "0", 6, 6),
        Capacitor("cd", "late", "0", PULSE_CAPACITANCE),
        *nand("ma", ("gone", "late"), "none", width=3.0, length=1.5),
        *inverter("mo", "none", "out", width=3.0, length=1.5),
    )


def delay_tap(timer_capacitance: float) -> Circuit:
    """One tap (F): ports event (in), out (event out), biases."""
    part = comparator()
    ports = (
        Port("vdd", "supply"),
        Port("event", "event"),
        Port("out", "event", "out"),
        *(Port(name, "bias") for name in ("v_tap", "v_cmp", "v_ref")),
    )
    devices = (
        *timer("event", "v_tap", timer_capacitance),
        *edge_event("passed"),
    )
    connections = part.wired(plus="timer", above="passed")
    return Circuit("delay_tap", ports, devices, (Instance("timer", part, connections),))


def build(params: Params = Params()) -> Circuit:
    """Ports event (in), out (event out), biases and the supply; between taps the nodes `wire[k]`."""
    part, count = delay_tap(params.timer_capacitance), int(params.taps)
    ports = (
        Port("vdd", "supply"),
        Port("event", "event"),
        Port("out", "event", "out", (count,)),
        *(Port(b.port, "bias") for b in BIASES),
    )
    own = part.wired()
    first = Instance("tap", part, own | {"out": "out[0]"})
    later = [
        Instance(f"tap{k}", part, own | {"event": f"out[{k - 1}]", "out": f"out[{k}]"})
        for k in range(1, count)
    ]
    return Circuit("delay_line", ports, (), (first, *later), biases=BIASES)


START = 20e-6  # s, ours: the testbench's event
STOP = 8e-3  # s


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """One event at 20 us."""
    sources = (
        Source("vdd", "vdd", Constant(v_dd)),
        Source("event", "event", pulse((START,), v_dd)),
    )
    bench = Testbench("delay line", circuit, sources, stimuli["duration"] or STOP, watch=("out",))
    return started_at_rest(bench, AMI_1500)


def measures(result: Result) -> dict[str, float | None]:
    """`delay_s` of the first tap, `hop_s` from it to the second, `pulse_s` of the first, `supply_power_W`."""
    half = half_supply(result.machine)
    first, second = (next(map(float, result.spikes.get(f"out[{k}]", ())), None) for k in range(2))
    rises = rising_crossing(result.time, result["out[0]"], half)
    falls = falling_crossing(result.time, result["out[0]"], half)
    return {
        "delay_s": None if first is None else first - START,
        "hop_s": None if first is None or second is None else second - first,
        "pulse_s": None if rises is None or falls is None or falls <= rises else falls - rises,
        "supply_power_W": supply_power(result),
    }


def outcome(result: Result) -> str:
    """How many taps made an event, in a word."""
    count = sum(1 for times in result.spikes.values() if times.size)
    return f"{count} taps" if count else "none"


BLOCK = Block(
    name="delay-tap",
    summary="delay line of spikes: each tap passes an event on after 3 ms",
    params=Params,
    build=build,
    stimuli=(Stimulus("duration", "s", None, "length of the run", can_be_off=True),),
    testbench=testbench,
    measures=measures,
    outcome=outcome,
    plotted=("event", "tap.timer", "out[0]", "out[1]"),
)
