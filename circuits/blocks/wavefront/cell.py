"""Wavefront cell: it fires once, at the first of eight arrivals, and remembers which one that was.

Inputs 0 to 7 are steps from the axons of the neighbours in the north, northeast, and so on round to the
northwest. Every input has a latch:

    held_k falls where arrive_k is high while `quiet` is high;  first_k = not held_k, latched
    quiet falls with any first_k, or with `start`;              fired = quiet low, and the cell not blocked

So the first arrival sets its own bit, the bit fires the cell, and `quiet`, which stays low until the plan's
reset, closes the branches of all others. `start` fires the cell without a bit, since the start of a wave
points nowhere. `fired` drives the cell's own axon, and `request` asks for the address-event bus until
`acknowledge` answers. A blocked cell (v_blocked is high) latches inside, but neither fires nor requests.

When arrivals are nearly simultaneous, the branches close as soon as `quiet` falls through the threshold of an
nFET. A second arrival within 1.0 ns of the first (at 27 degC, nominal, with edges of 5 ns) sets its bit too,
and a later one does not; at the very edge the latch settles in either state. Readers take the lowest bit that
is set.

The reset charges all latches while `reset` is high. Its pFETs are stronger than the branches, so that
arrivals that are still there lose. It must outlast the recovery of the axons (2 us), as an event of 10 us
does. The circuit has several rest states until its first reset, so that a run begins in one.

Source: one spike for each cell and plan, whose causes are read back, Hwu et al. 2018, section II. The circuit
and numbers are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import Stimulus, Values, catalogued
from circuits.blocks.drive import Wave, elements, powered, step
from circuits.blocks.measure import between, rise
from circuits.blocks.mos import UM, inverter, mos
from circuits.blocks.ports import SUPPLY, analog_out, biased, event_in, event_out
from circuits.blocks.rest import rested
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Device
from circuits.errors import ParameterError
from circuits.lowering.supply import half_supply
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

INPUTS = 8
NAMES = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")  # of the inputs, in their order
BIASES = (Bias("v_blocked", "v_blocked", "voltage", 0.0),)

# Sizes (width, length) in um, all ours.
_P, _N, _STACKED = (6.0, 1.5), (3.0, 1.5), (12.0, 1.5)


@dataclass(frozen=True, slots=True)
class Params:
    """Length of what keeps a latch's state and width of what resets it, m; ours.

    Raises `ParameterError` where the reset would not win: its pFET must be stronger than a branch.
    """

    keeper_length: float = quantity(12e-6, "m")
    precharge_width: float = quantity(12e-6, "m")

    def __post_init__(self) -> None:
        if not self.keeper_length >= 6e-6:
            raise ParameterError(
                f"keeper_length: {self.keeper_length:g} m, must be >= 6e-06, weaker than a branch"
            )
        if not self.precharge_width >= 9e-6:
            raise ParameterError(
                f"precharge_width: {self.precharge_width:g} m, must be >= 9e-06 to win the reset"
            )


def _arrival_latch(params: Params = Params()) -> Circuit:
    """One input: a bit that an arrival sets while `quiet` is high, and that pulls `quiet` down."""
    return Circuit(
        "arrival_latch",
        (SUPPLY, *event_in("arrive"), *analog_out("quiet"), *event_in("reset_n"), *event_out("first")),
        (
            mos("ma", "n", "held", "arrive", "branch", *_N),
            mos("mb", "n", "branch", "quiet", "0", *_N),
            *_latch("mk", "held", "first", params),
            mos("mo", "n", "quiet", "first", "0", *_N),
        ),
    )


def build(params: Params = Params()) -> Circuit:
    """The cell: ports arrive[8], start, reset, acknowledge (events in), fired, first[8], request (out)."""
    latches = _arrival_latch(params).array("input", (INPUTS,))
    ports = (
        SUPPLY,
        Port("arrive", "event", "in", (INPUTS,)),
        *event_in("start", "reset", "acknowledge"),
        *event_out("fired"),
        Port("first", "event", "out", (INPUTS,)),
        *event_out("request"),
    )
    devices = (
        *inverter("mr", "reset", "reset_n", width=3.0, length=1.5),
        mos("ms", "n", "quiet", "start", "0", *_N),
        *_latch("mq", "quiet", "seen", params),
        *_nor("mf", ("quiet", "v_blocked"), "fired"),
        *inverter("mi", "fired", "fired_n", width=3.0, length=1.5),
        mos("mw1", "n", "waiting", "acknowledge", "answer", *_N),
        mos("mw2", "n", "answer", "fired", "0", *_N),
        *_latch("mt", "waiting", "taken", params),
        *_nor("mg", ("fired_n", "taken"), "request"),
    )
    return biased("wavefront_cell", ports, BIASES, devices, (latches,))


def _latch(name: str, a: str, y: str, params: Params) -> tuple[Device, ...]:
    """Node `a`, high after the reset, its inverse `y`, and what keeps `a` where it is."""
    weak = (3.0, params.keeper_length / UM)
    return (
        mos(f"{name}r", "p", a, "reset_n", "vdd", params.precharge_width / UM, 1.5),
        *inverter(name, a, y, width=3.0, length=1.5),
        mos(f"{name}kp", "p", a, y, "vdd", *weak),
        mos(f"{name}kn", "n", a, y, "0", *weak),
    )


def _nor(name: str, inputs: tuple[str, str], y: str) -> tuple[Device, ...]:
    a, b = inputs
    top = f"{name}_top"
    return (
        mos(f"{name}p1", "p", top, b, "vdd", *_STACKED),
        mos(f"{name}p2", "p", y, a, top, *_STACKED),
        mos(f"{name}n1", "n", y, a, "0", *_N),
        mos(f"{name}n2", "n", y, b, "0", *_N),
    )


RESET_END = 10e-6  # s, ours: the testbench begins in the reset, from which every state follows
ARRIVAL = 20e-6  # s, ours: the first arrival, or the start
ANSWER = 30e-6  # s, ours: the bus acknowledges
STOP = 50e-6
EDGE = 5e-9  # s, of an arrival: what an axon's output gives to its eight branches


def _rise(time: float, v_dd: float) -> Wave:
    """A rise through half the supply at `time`, s."""
    return step(time - 0.5 * EDGE, time + 0.5 * EDGE, 0.0, v_dd)


STIMULI = (
    Stimulus("first", "", 2.0, "input of the first arrival, 0 to 7", can_be_off=True),
    Stimulus("second", "", 5.0, "input of a second arrival", can_be_off=True),
    Stimulus("lag", "s", 1e-6, "second arrival after the first"),
    Stimulus("start", "", None, "the plan's start, at the time of the first arrival", can_be_off=True),
)
PLOTTED = ("arrive[2]", "quiet", "fired", "first[2]", "first[5]", "request")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A reset until 10 us, an arrival at 20 us, another `lag` (s) later, and the bus's answer at 30 us."""
    lag = stimuli["lag"] or 0.0
    arrivals: dict[int, Wave] = {}
    for name, time in (("second", ARRIVAL + lag), ("first", ARRIVAL)):
        number = stimuli[name]
        if number is None:
            continue
        if number != int(number) or not 0 <= number < INPUTS:
            raise ParameterError(f"{name}: {number:g}, must be an input from 0 to {INPUTS - 1}, or off")
        arrivals[int(number)] = _rise(time, v_dd)
    waves: dict[str, Wave] = {
        "reset": step(RESET_END, RESET_END + 1e-7, v_dd, 0.0),
        "start": 0.0 if stimuli["start"] is None else _rise(ARRIVAL, v_dd),
        "acknowledge": step(ANSWER, ANSWER + 1e-7, 0.0, v_dd),
    }
    sources = powered(v_dd, waves | elements(circuit.port("arrive"), arrivals))
    watch = ("fired", "request", *(f"first[{k}]" for k in range(INPUTS)))
    return rested("wavefront cell", circuit, sources, STOP, watch=watch)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `delay_s` from the arrival to `fired`, and `bits`, which is first[8] as a number."""
    half = half_supply(result.machine)
    bits = sum(1 << k for k in range(INPUTS) if result[f"first[{k}]"][-1] > half)
    return {
        "delay_s": between(ARRIVAL, rise(result, "fired")),
        "bits": float(bits),
    }


def outcome(result: Result) -> str:
    """Neighbours whose arrival is remembered, such as `E` or `E+SW`; `start` or `none` without any."""
    half = half_supply(result.machine)
    names = [NAMES[k] for k in range(INPUTS) if result[f"first[{k}]"][-1] > half]
    fired = result["fired"][-1] > half
    return "+".join(names) or ("start" if fired else "none")


BLOCK = catalogued("wavefront-cell", build, STIMULI, testbench, measures, outcome, PLOTTED)
