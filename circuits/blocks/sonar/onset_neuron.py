"""Onset neuron: it spikes once at the beginning of a sound.

It is "triggered by a positive derivative on a signal of sufficient magnitude". An amplifier of fixed gain G,
cut off at its rails, lets weak echoes be seen and leaves no trace of loud calls. A high-pass follows, whose
resistor's current is balanced by a source follower `mh`. An equal branch without the capacitor, whose
follower `mt` has a slightly higher gate, makes the threshold:

    C_h d(v_h - v_amp)/dt = I_S e^((kappa (v_base - V_T0) - v_h) / U_T) - v_h / R_h
    v_threshold - v_h = kappa (v_level - v_base)   at rest

v_h follows a fast rise of the envelope and falls back at the slope `s_h = v_h / (R_h C_h)`. It cannot fall
far below its rest, because the current of the follower grows e-fold in U_T: the neuron is ready again soon
after the loudest call. Under a steady rise v_h keeps on rising only if `G d envelope/dt > s_h`; a slower one,
`G d envelope/dt = s`, moves it by `-U_T ln(1 - s / s_h)`. The spikes come from the circuit of
`circuits.blocks.sonar.spike_generator`.

Source: Cheely & Horiuchi 2003, section 4, Echoes. The circuit and every number here are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.ports import SUPPLY, analog_in, biased, event_out
from circuits.blocks.sonar import spike_generator
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor, OperationalAmplifier, Resistor, Transistor
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params:
    """Resistors (Ohm), capacitors (F) and size of the followers (m); ours."""

    ground_resistance: float = quantity(100e3, "Ohm")  # with the next: G = 10
    feedback_resistance: float = quantity(900e3, "Ohm")
    # with the line above 18 us: takes the 40 kHz ripple down
    feedback_capacitance: float = quantity(20e-12, "F")
    amplifier_gain: float = quantity(1e4, "")  # V/V
    amplifier_resistance: float = quantity(100.0, "Ohm")
    stray_capacitance: float = quantity(5e-12, "F")  # of a board's node to ground
    onset_capacitance: float = quantity(4.7e-9, "F")  # C_h
    onset_resistance: float = quantity(1.8e6, "Ohm")  # R_h; 150 mV/ms with C_h, 15 mV/ms at the envelope
    follower_width: float = quantity(300e-6, "m")
    follower_length: float = quantity(1.5e-6, "m")
    refractory_capacitance: float = quantity(470e-12, "F")
    refractory_resistance: float = quantity(1.5e6, "Ohm")  # 0.4 ms


BIASES = (
    Bias("v_base", "v_base", "voltage", 2.5),  # ours: v_h rests at 1.42 V
    Bias("v_level", "v_level", "voltage", 2.56),  # ours: the threshold is 42 mV, 4.2 mV at the envelope
    *spike_generator.BIASES,
)


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports envelope (in), spike (event out), biases and the supply."""
    width, length = params.follower_width, params.follower_length
    refractory = params.refractory_capacitance, params.refractory_resistance
    devices = (
        OperationalAmplifier(
            "op", "envelope", "v_n", "v_amp", "vdd",
            gain=params.amplifier_gain, output_resistance=params.amplifier_resistance,
        ),
        Resistor("rg", "v_n", "0", params.ground_resistance),
        Resistor("rf", "v_amp", "v_n", params.feedback_resistance),
        Capacitor("cf", "v_amp", "v_n", params.feedback_capacitance),
        Capacitor("cn", "v_n", "0", params.stray_capacitance),
        Capacitor("ca", "v_amp", "0", params.stray_capacitance),
        Capacitor("ch", "v_amp", "v_h", params.onset_capacitance),
        Resistor("rh", "v_h", "0", params.onset_resistance),
        Transistor("mh", "n", "vdd", "v_base", "v_h", "0", width, length),
        Resistor("rt", "v_threshold", "0", params.onset_resistance),
        Transistor("mt", "n", "vdd", "v_level", "v_threshold", "0", width, length),
        Capacitor("ct", "v_threshold", "0", params.stray_capacitance),
    )  # fmt: skip
    ports = (SUPPLY, *analog_in("envelope"), *event_out("spike"))
    return biased("onset_neuron", ports, BIASES, devices, (spike_generator.generator(*refractory, "v_h"),))


BLOCK = spike_generator.listening_block(
    name="onset-neuron",
    build=build,
    amplitude=0.03,
    plotted=("envelope", "v_amp", "v_h", "spike"),
    signal="v_h",
)
