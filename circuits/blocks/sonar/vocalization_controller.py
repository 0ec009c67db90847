"""Vocalization controller: with the proximity voltage calls become faster and softer, both linearly.

Cheely & Horiuchi 2003, section 4 and Figure 10, give the two linear laws and no schematic: the topology and
all values are ours. The parts are those of a board, on the supply of the process.

From voltage to current: a network of resistors mixes proximity and supply, and an amplifier puts the mix on
R: `v_x = (v_prox G_in + V_dd G_off) / (G_in + G_off + G_gnd)`, `I = v_x / R`.

Oscillator: I charges C up to the upper threshold of a comparator, where the call rises and a transistor
empties C through R_d down to the lower threshold; the call lasts as long as that. `1/f = C (V_hi - V_lo) / I
+ t_call`, `t_call = R_d C ln[(V_hi - I R_d) / (V_lo - I R_d)]`, with `V_lo = V_dd G_top / G`, `V_hi = V_dd
(G_top + G_fb) / G` and `G = G_top + G_bottom + G_fb`. While `enable` is low C is held empty, so that the
first call comes one interval after it rises.

Amplitude: an inverting amplifier about a fraction of the supply, `a = V_dd r_b / (r_t + r_b) (1 + R_f / R_i)
- v_control R_f / R_i`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import powered
from circuits.blocks.measure import last_rate, latency, rise, spiking
from circuits.blocks.mos import current_mirror, mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, event_out
from circuits.blocks.sonar.board import GAIN, LENGTH, amplifier, inverter, strays
from circuits.circuit import Circuit
from circuits.devices import Capacitor, Device, OperationalAmplifier, Resistor
from circuits.devices.source import PiecewiseLinear
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

COMPARATOR_RESISTANCE = 100.0  # ohm; ours
COMPARATOR_CAPACITANCE = 1e-9  # F; ours


@dataclass(frozen=True, slots=True)
class Params:
    """Resistances (Ohm) and capacitance (F); ours: 5 Hz at 0 V, 30 Hz at 3 V, 4.5 V falling to 0.9 V.

    The shortest interval in use, 33 ms at 3 V, stays above the longest best delay of the array, 28 ms.
    """

    mix_input_resistance: float = quantity(100e3, "Ohm")
    mix_offset_resistance: float = quantity(846e3, "Ohm")
    mix_ground_resistance: float = quantity(89.4e3, "Ohm")
    current_resistance: float = quantity(211e3, "Ohm")
    ramp_capacitance: float = quantity(100e-9, "F")
    discharge_resistance: float = quantity(1.5e3, "Ohm")
    threshold_top_resistance: float = quantity(750e3, "Ohm")
    threshold_bottom_resistance: float = quantity(31.26e3, "Ohm")
    threshold_feedback_resistance: float = quantity(30e3, "Ohm")
    amplitude_input_resistance: float = quantity(100e3, "Ohm")
    amplitude_feedback_resistance: float = quantity(120e3, "Ohm")
    amplitude_top_resistance: float = quantity(144.4e3, "Ohm")
    amplitude_bottom_resistance: float = quantity(100e3, "Ohm")


def build(params: Params = Params()) -> Circuit:
    """The board: ports proximity, amplitude_control, enable (in), call, amplitude (out) and the supply."""
    inputs = analog_in("proximity", "amplitude_control", "enable")
    ports = (SUPPLY, *inputs, *event_out("call"), *analog_out("amplitude"))
    devices = (*_current(params), *_oscillator(params), *_amplitude(params))
    return Circuit("vocalization_controller", ports, devices)


def _current(params: Params) -> tuple[Device, ...]:
    """Proximity voltage to a current out of the supply into node ramp."""
    return (
        Resistor("r_in", "proximity", "mix", params.mix_input_resistance),
        Resistor("r_off", "vdd", "mix", params.mix_offset_resistance),
        Resistor("r_gnd", "mix", "0", params.mix_ground_resistance),
        *amplifier("converter", "mix", "sense", "drive"),
        mos("m_drive", "n", "mirror", "drive", "sense", 30, LENGTH),
        Resistor("r_current", "sense", "0", params.current_resistance),
        *current_mirror("m_in", "m_out", "p", "mirror", "ramp", (60, 6)),
        *strays("mix", "sense", "mirror"),
    )


def _oscillator(params: Params) -> tuple[Device, ...]:
    """The ramp, the comparator with hysteresis (its output is low during a call), reset and hold."""
    return (
        Capacitor("c_ramp", "ramp", "0", params.ramp_capacitance),
        OperationalAmplifier(
            "comparator", "threshold", "ramp", "idle", "vdd", "0", GAIN, COMPARATOR_RESISTANCE
        ),
        Capacitor("c_comparator", "idle", "0", COMPARATOR_CAPACITANCE),
        Resistor("r_top", "vdd", "threshold", params.threshold_top_resistance),
        Resistor("r_bottom", "threshold", "0", params.threshold_bottom_resistance),
        Resistor("r_fb", "idle", "threshold", params.threshold_feedback_resistance),
        *inverter("i_call", "idle", "call"),
        mos("m_reset", "n", "ramp", "call", "foot", 600, LENGTH),
        Resistor("r_discharge", "foot", "0", params.discharge_resistance),
        *inverter("i_hold", "enable", "hold"),
        mos("m_hold", "n", "ramp", "hold", "0", 60, LENGTH),
        *strays("threshold", "call", "foot", "hold"),
    )


def _amplitude(params: Params) -> tuple[Device, ...]:
    return (
        Resistor("r_reference_top", "vdd", "reference", params.amplitude_top_resistance),
        Resistor("r_reference_bottom", "reference", "0", params.amplitude_bottom_resistance),
        Resistor("r_control", "amplitude_control", "summing", params.amplitude_input_resistance),
        Resistor("r_amplitude", "summing", "amplitude", params.amplitude_feedback_resistance),
        *amplifier("inverting", "reference", "summing", "amplitude"),
        *strays("reference", "summing"),
    )


def thresholds(params: Params, v_dd: float) -> tuple[float, float]:
    """Ramp voltages V_lo and V_hi at which a call ends and begins, V; v_dd: supply, V."""
    top = 1.0 / params.threshold_top_resistance
    feedback = 1.0 / (params.threshold_feedback_resistance + COMPARATOR_RESISTANCE)
    total = top + feedback + 1.0 / params.threshold_bottom_resistance
    return v_dd * top / total, v_dd * (top + feedback) / total


def _ramp_current(params: Params, proximity: float, v_dd: float) -> float:
    """Current that charges the ramp at a proximity voltage (V), A; v_dd: supply, V."""
    inward, offset = 1.0 / params.mix_input_resistance, 1.0 / params.mix_offset_resistance
    total = inward + offset + 1.0 / params.mix_ground_resistance
    return (proximity * inward + v_dd * offset) / total / params.current_resistance


def call_width(params: Params, proximity: float, v_dd: float) -> float:
    """Length of a call's pulse at a proximity voltage (V), s; v_dd: supply, V."""
    low, high = thresholds(params, v_dd)
    rest = _ramp_current(params, proximity, v_dd) * params.discharge_resistance
    return params.discharge_resistance * params.ramp_capacitance * math.log((high - rest) / (low - rest))


def call_rate(params: Params, proximity: float, v_dd: float) -> float:
    """Rate of the calls at a constant proximity voltage (V), Hz; v_dd: supply, V."""
    low, high = thresholds(params, v_dd)
    charging = params.ramp_capacitance * (high - low) / _ramp_current(params, proximity, v_dd)
    return 1.0 / (charging + call_width(params, proximity, v_dd))


def amplitude_law(params: Params, v_dd: float) -> tuple[float, float]:
    """Intercept (V) and slope (V/V, below zero) of the amplitude against its control voltage."""
    ratio = params.amplitude_feedback_resistance / params.amplitude_input_resistance
    bottom = params.amplitude_bottom_resistance
    return v_dd * bottom / (params.amplitude_top_resistance + bottom) * (1.0 + ratio), -ratio


ENABLE_TIME = 0.1e-3  # s, when the testbench lets the oscillator go; ours
EDGE = 1e-6  # s; ours
INTERVALS = 2.5  # call intervals in a run of default length; ours

STIMULI = (
    Stimulus("proximity", "V", 1.5, "proximity voltage"),
    Stimulus(
        "amplitude_control",
        "V",
        None,
        "control of the amplitude, off for the proximity voltage",
        can_be_off=True,
    ),
    DURATION,
)
PLOTTED = ("proximity", "ramp", "call", "amplitude")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A constant `proximity` (V), which is also the control of the amplitude unless that is given.

    A run lasts 2.5 intervals between calls unless `duration` (s) is given.
    """
    proximity, control = stimuli["proximity"] or 0.0, stimuli["amplitude_control"]
    stop = stimuli["duration"] or ENABLE_TIME + INTERVALS / call_rate(Params(), max(proximity, 0.0), v_dd)
    sources = powered(
        v_dd,
        {
            "proximity": proximity,
            "amplitude_control": proximity if control is None else control,
            "enable": PiecewiseLinear((ENABLE_TIME, ENABLE_TIME + EDGE), (0.0, v_dd)),
        },
    )
    return Testbench("vocalization controller", circuit, sources, stop, watch=("call",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `first_call_s`, `call_rate_Hz`, and `amplitude_V` at the end.

    The first call counts from the enabling, and the rate is that of the last interval; None without one.
    """
    return {
        "first_call_s": latency(result, rise(result, "enable") or 0.0, "call"),
        "call_rate_Hz": last_rate(result.spikes["call"]),
        "amplitude_V": float(result["amplitude"][-1]),
    }


outcome = spiking("calling", "silent", "call")

BLOCK = catalogued("vocalization-controller", build, STIMULI, testbench, measures, outcome, PLOTTED)
