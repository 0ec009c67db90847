"""Centroid board: it turns the spikes of the ranging chip's neurons into a voltage for proximity.

Each spike pulls a common node towards the look-up voltage of its neuron, and the low-passed common node is
the proximity voltage. Cheely & Horiuchi 2003, section 4 and Figure 9, describe the board in words; all values
are ours. While the spikes of a set S of neurons are high, their transmission gates are on, and the common
node tends to `V = sum_S(V_k / R) / (|S| / R + 1 / R_leak)` with the time constant `C_hold / (|S| / R + 1 /
R_leak)`. So spikes of length t move it by the share `1 - exp(-|S| t / (R C_hold))` of the way, but for the
resistance of the gates (up to 10 % of R) and strays (3 % of C_hold). Without spikes it falls to ground, which
stands for far, with `R_leak C_hold`, but for the off current of the gates through R_leak: 8 mV at 27 degC, 67
mV at 85 degC. A follower, a low-pass of R_lp and C_lp and a second follower give the proximity voltage, which
rises as the target nears.

The look-up voltages can make the amplitude of the call fall with the fourth power of range. An amplitude `a =
a_0 + s V` of a control voltage V follows `a_k = a(V_far) (d_k / d_max)^4` where `V_k = (a_k - a_0) / s`, as
far as V_k stays within the board's range.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import elements, powered
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, event_in
from circuits.blocks.sonar.board import amplifier, strays, transmission_gate
from circuits.circuit import Bias, Circuit, Port
from circuits.count import PULSES, whole_number
from circuits.devices import Capacitor, Resistor
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

NEURONS = 13
NEAREST, FARTHEST = 3.0, 0.2  # V, look-up voltages of the first and the last neuron; ours


@dataclass(frozen=True, slots=True)
class Params:
    """Resistances (Ohm) and capacitances (F); ours.

    R C_hold is as long as an event, so that one spike moves the estimate by 63 % and two by 86 %. The leak (2
    s) is slow against intervals of 33 to 200 ms between calls, and the low-pass (50 ms) lags by 0.15 m at 3
    m/s.
    """

    gate_resistance: float = quantity(5e3, "Ohm")
    leak_resistance: float = quantity(1e9, "Ohm")
    hold_capacitance: float = quantity(2e-9, "F")
    filter_resistance: float = quantity(1e6, "Ohm")
    filter_capacitance: float = quantity(50e-9, "F")


@dataclass(frozen=True, slots=True)
class Lookup:
    """Look-up voltages (V) in the order of the neurons, and which of them the board's range has clipped."""

    voltages: tuple[float, ...]
    clipped: tuple[bool, ...]

    @property
    def summary(self) -> str:
        """A line that says how many neurons do not follow the law."""
        return f"{sum(self.clipped)} of {len(self.clipped)} look-up voltages are clipped to the board's range"


def linear_lookup(
    count: int = NEURONS, nearest: float = NEAREST, farthest: float = FARTHEST
) -> tuple[float, ...]:
    """Look-up voltages of `count` neurons in equal steps from `nearest` to `farthest`, V."""
    return tuple(float(v) for v in np.linspace(nearest, farthest, count))


def lookup_at(delays: Sequence[float], nearest_delay: float, farthest_delay: float) -> tuple[float, ...]:
    """Look-up voltages (V) of neurons by their delays (s): on a line through those of two delays.

    They fall from `NEAREST` at `nearest_delay` to `FARTHEST` at `farthest_delay`, and stay within that range.
    """
    return tuple(np.interp(delays, (nearest_delay, farthest_delay), (NEAREST, FARTHEST)).tolist())


def fourth_power_lookup(
    ranges: Sequence[float],
    law: tuple[float, float],
    nearest: float = NEAREST,
    farthest: float = FARTHEST,
) -> Lookup:
    """Look-up voltages by which the amplitude of the call follows the fourth power of range.

    ranges: those of the neurons, m (or their best delays, s: only ratios count). law: intercept (V) and slope
    (V/V) of the amplitude, as `vocalization_controller.amplitude_law` gives them. nearest, farthest: the
    range of the board, V. At the farthest neuron the amplitude is that of the law at `farthest`. Raises
    `ParameterError` unless all ranges are above zero and the slope is below zero.
    """
    d = np.asarray(ranges, dtype=np.float64)
    if d.size == 0 or not (np.isfinite(d).all() and (d > 0.0).all()):
        raise ParameterError(f"ranges: {[float(x) for x in d]} m, must be > 0; give a range for each neuron")
    intercept, slope = law
    if slope >= 0.0:
        raise ParameterError(
            f"law: slope {slope:g} V/V, must be < 0; the amplitude falls as the target nears"
        )
    wanted = (intercept + slope * farthest) * (d / d.max()) ** 4
    exact = (wanted - intercept) / slope
    within = np.clip(exact, farthest, nearest)
    clipped = np.abs(within - exact) > 1e-9 * nearest
    return Lookup(tuple(float(v) for v in within), tuple(bool(c) for c in clipped))


def _lookup_switch(params: Params) -> Circuit:
    """A transmission gate in series with a resistor, from a look-up voltage to the common node."""
    return Circuit(
        "lookup_switch",
        (SUPPLY, *event_in("spike"), *analog_in("entry"), *analog_out("common")),
        (Resistor("r_gate", "end", "common", params.gate_resistance), *strays("end")),
        (transmission_gate().instance("gate", control="spike", a="entry", b="end"),),
    )


def build(params: Params = Params()) -> Circuit:
    """The board: ports spike[13] (events in), lookup[13] (biases), proximity (out) and the supply."""
    ports = (
        SUPPLY,
        Port("spike", "event", shape=(NEURONS,)),
        Port("lookup", "bias", shape=(NEURONS,)),
        *analog_out("proximity"),
    )
    devices = (
        Resistor("r_leak", "common", "0", params.leak_resistance),
        Capacitor("c_hold", "common", "0", params.hold_capacitance),
        *amplifier("hold_follower", "common", "held", "held"),
        Resistor("r_filter", "held", "filtered", params.filter_resistance),
        Capacitor("c_filter", "filtered", "0", params.filter_capacitance),
        *amplifier("output_follower", "filtered", "proximity", "proximity"),
    )
    gates = _lookup_switch(params).array("switch", (NEURONS,), entry="lookup")
    biases = (Bias("lookup", "lookup", "voltage", linear_lookup()),)
    return Circuit("centroid_board", ports, devices, (gates,), biases=biases)


def neuron_index(name: str, value: float | None) -> int:
    """A knob that chooses a neuron, as an index; raises `ParameterError` unless it is one."""
    if value is None or value != int(value) or not 0 <= value < NEURONS:
        raise ParameterError(
            f"{name}: {value}, must be a whole number from 0 to {NEURONS - 1}; give a neuron's index"
        )
    return int(value)


FIRST_SPIKE = 5e-3  # s, when the testbench's first spikes arrive; ours

STIMULI = (
    Stimulus("neuron", "", 2.0, "index of the neuron that spikes"),
    Stimulus("second", "", None, "index of a neuron that spikes together with it", can_be_off=True),
    Stimulus("rate", "Hz", 20.0, "rate of the spikes", can_be_off=True),
    lasting(0.3),
)
PLOTTED = ("spike[2]", "common", "proximity")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """Spikes of `neuron`, and of `second` at the same times unless off, at `rate` (Hz) from 5 ms on.

    `duration` is the length of the run, s.
    """
    stop, rate = stimuli["duration"] or 0.0, stimuli["rate"]
    chosen = {neuron_index(name, stimuli[name]) for name in ("neuron", "second") if stimuli[name] is not None}
    wanted = 0.0 if rate is None else max(0.0, float(np.ceil((stop - FIRST_SPIKE) * rate - 1e-9)))
    count = whole_number("spikes", wanted, 0, PULSES)
    times = tuple(FIRST_SPIKE + k / (rate or 1.0) for k in range(count))
    spikes = elements(circuit.port("spike"), {k: pulse(times, v_dd) for k in chosen})
    return Testbench("centroid board", circuit, powered(v_dd, spikes), stop)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `centroid_V` and `proximity_V` at the end, and `proximity_peak_V`."""
    return {
        "centroid_V": float(result["common"][-1]),
        "proximity_V": float(result["proximity"][-1]),
        "proximity_peak_V": float(result["proximity"].max()),
    }


def outcome(result: Result) -> str:
    """`target` where the centroid ends above half of the lowest look-up voltage, else `far`."""
    lowest = min(float(result[f"lookup[{k}]"][-1]) for k in range(NEURONS))
    return "target" if float(result["common"][-1]) > 0.5 * lowest else "far"


BLOCK = catalogued("centroid-board", build, STIMULI, testbench, measures, outcome, PLOTTED)
