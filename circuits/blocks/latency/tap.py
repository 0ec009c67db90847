"""Tap of a delay line: an event comes in, and one goes out a fixed time later.

The event discharges the capacitor of a timer, and the starved source `mt` charges it again. Where it passes
the reference, the comparator of `circuits.blocks.latency.synapse` makes the next event, which lasts until a
starved inverter has followed:

    T_tap = T_in + C_t V_ref / I_tap,    T_out = C_d (V_dd - V_i) / I_cmp

T_in is the width of the event, which holds the capacitor at ground, and V_i the threshold of an inverter. Two
inverters make the edge of the comparator steep, so that at the event the gate closes before `late` has risen.
Taps in a row are a delay line. A second event that comes before the first has left starts the tap again, and
the first is lost.

Source: Wen & Horiuchi 2022, section 3, "Evaluation Memory": neurons in series, each of which makes the next
one fire with a fixed delay. The circuit and all numbers are ours, 3 ms as in the network.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import DURATION, Values, catalogued
from circuits.blocks.drive import powered
from circuits.blocks.latency.synapse import comparator_biases, compared, timer
from circuits.blocks.measure import between, high_time
from circuits.blocks.mos import inverter, mos, nand
from circuits.blocks.ports import SUPPLY, bias_in, biased, event_in, event_out
from circuits.blocks.rest import rested
from circuits.blocks.sizes import Sizes
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor
from circuits.devices.device import Device
from circuits.event import pulse
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

PULSE_CAPACITANCE = 0.2e-12  # F; ours: events of some 10 us


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitor of a timer (F) and number of taps in a row; ours."""

    timer_capacitance: float = quantity(5e-12, "F")
    taps: int = quantity(2, "")


BIASES = (
    Bias("i_tap", "v_tap", "gate", 3.34e-9, "tap.mt"),  # ours: 3 ms
    *comparator_biases("tap.timer.mc0"),
)


def edge_event(level: str) -> tuple[Device, ...]:
    """Devices that make an event at node `out` where node `level` rises; its length is set at `v_cmp`."""
    return (
        *inverter("mp", level, "going", width=3.0, length=1.5),
        *inverter("mg", "going", "gone", width=3.0, length=1.5),
        *starved_inverter("gone"),
        *nand("ma", ("gone", "late"), "none", width=3.0, length=1.5),
        *inverter("mo", "none", "out", width=3.0, length=1.5),
    )


def starved_inverter(gate: str) -> tuple[Device, ...]:
    """An inverter from `gate` to the node `late`, whose fall is slowed by the current set at `v_cmp`."""
    return (
        mos("mdp", "p", "late", gate, "vdd", 3, 6),
        mos("mdn", "n", "late", gate, "starved", 3, 1.5),
        mos("mds", "n", "starved", "v_cmp", "0", 6, 6),
        Capacitor("cd", "late", "0", PULSE_CAPACITANCE),
    )


def delay_tap(timer_capacitance: float) -> Circuit:
    """One tap: ports event (in), out (event out), biases. timer_capacitance: F."""
    biases = bias_in("v_tap", "v_cmp", "v_ref")
    ports = (SUPPLY, *event_in("event"), *event_out("out"), *biases)
    devices = (*timer("event", "v_tap", timer_capacitance), *edge_event("passed"))
    return Circuit("delay_tap", ports, devices, (compared("timer", "timer", "passed"),))


def build(params: Params = Params()) -> Circuit:
    """A delay line: ports event (in), out[taps] (events out), biases and the supply."""
    part, count = delay_tap(params.timer_capacitance), int(params.taps)
    ports = (SUPPLY, *event_in("event"), Port("out", "event", "out", (count,)))
    first = part.instance("tap", out="out[0]")
    later = (part.instance(f"tap{k}", event=f"out[{k - 1}]", out=f"out[{k}]") for k in range(1, count))
    return biased("delay_line", ports, BIASES, (), (first, *later))


START = 20e-6  # s, ours: the testbench's event
STOP = 8e-3  # s


STIMULI = (DURATION,)
PLOTTED = ("event", "tap.timer", "out[0]", "out[1]")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """One event at 20 us."""
    sources = powered(v_dd, {"event": pulse((START,), v_dd)})
    return rested("delay line", circuit, sources, stimuli["duration"] or STOP, watch=("out",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `delay_s` of the first tap, `hop_s` from it to the second, `pulse_s` of the first.

    None where what is asked for is not in the run.
    """
    first, second = (next(map(float, result.spikes.get(f"out[{k}]", ())), None) for k in range(2))
    return {
        "delay_s": None if first is None else first - START,
        "hop_s": between(first, second),
        "pulse_s": high_time(result, "out[0]"),
    }


def outcome(result: Result) -> str:
    """How many taps gave an event, such as `2 taps`, or `none`."""
    count = sum(1 for times in result.spikes.values() if times.size)
    return f"{count} taps" if count else "none"


BLOCK = catalogued("delay-tap", build, STIMULI, testbench, measures, outcome, PLOTTED)
