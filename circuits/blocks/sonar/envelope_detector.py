"""Envelope detector: it turns the 40 kHz signal of a microphone into its envelope.

A source follower `mf` charges C_e on the peaks of the microphone and R_e discharges it. An equal follower
`mr`, with its gate at the rest voltage of the microphone, makes the same node without sound, and a difference
amplifier subtracts, amplifies and smooths:

    C_e dv_e/dt = I_S e^((kappa (v_mic - V_T0) - v_e) / U_T) - (v_e - v_return) / R_e - (v_e - v_q) / R_1
    envelope = v_pedestal + (R_2 / R_1) (v_e - v_r) / (1 + s R_2 C_2)

For a tone of peak A, if C_e averaged perfectly over its cycle, weak inversion would give `v_e - v_r = U_T ln
I_0(kappa A / U_T)`, I_0 being the modified Bessel function: `(kappa A)^2 / (4 U_T)` for a weak sound, and a
straight line of slope kappa above about 0.3 V. Ripple and moderate inversion take some 10 % of a loud sound
and 20 % of a weak one. Noise of a few mV is squared and so disappears. Matched followers cancel the drift of
the threshold voltage. C_e falls back in finite time, since R_e pulls it towards `v_return`, far below its
rest: the tail after a loud sound is short.

Source: Cheely & Horiuchi 2003, section 4, says only that sound "is converted into an envelope signal"; the
circuit and every number here are ours. A follower is used and not an operational amplifier with a diode in
its loop, because no node of it has to move through volts at 40 kHz: some 25 to 45 solver steps a cycle do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import powered
from circuits.blocks.measure import between
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, biased
from circuits.circuit import Bias, Circuit
from circuits.count import SAMPLES, whole_number
from circuits.devices import Capacitor, OperationalAmplifier, Resistor, Transistor
from circuits.devices.source import Sampled
from circuits.errors import ParameterError
from circuits.event import rising_crossing
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params:
    """Resistors (Ohm), capacitors (F), size of the followers (m), and gain (V/V); ours."""

    # C_e; averages weak sounds over U_T C_e / (1.8 uA at rest) = 14 us
    hold_capacitance: float = quantity(1e-9, "F")
    replica_capacitance: float = quantity(100e-12, "F")
    leak_resistance: float = quantity(250e3, "Ohm")  # R_e
    input_resistance: float = quantity(2e6, "Ohm")  # R_1
    # R_2; 1.6 makes the slope about 1 V/V for loud sounds
    feedback_resistance: float = quantity(3.2e6, "Ohm")
    smoothing_capacitance: float = quantity(20e-12, "F")  # C_2: 64 us with R_2
    stray_capacitance: float = quantity(5e-12, "F")  # of a board's node to ground
    follower_width: float = quantity(300e-6, "m")
    follower_length: float = quantity(1.5e-6, "m")
    amplifier_gain: float = quantity(1e4, "")
    amplifier_resistance: float = quantity(100.0, "Ohm")


BIASES = (
    Bias("v_mid", "v_mid", "voltage", 2.5),  # ours: the microphone's output in silence
    Bias("v_return", "v_return", "voltage", 1.0),  # ours: 0.39 V below the followers' rest
    Bias("v_pedestal", "v_pedestal", "voltage", 0.15),  # ours: keeps the amplifier off its rail in silence
)


def build(params: Params = Params()) -> Circuit:
    """The detector: ports microphone (in), envelope (out), biases and the supply."""
    width, length = params.follower_width, params.follower_length
    r_1, r_2, stray = params.input_resistance, params.feedback_resistance, params.stray_capacitance
    devices = (
        Transistor("mf", "n", "vdd", "microphone", "v_e", "0", width, length),
        Resistor("re", "v_e", "v_return", params.leak_resistance),
        Capacitor("ce", "v_e", "0", params.hold_capacitance),
        Transistor("mr", "n", "vdd", "v_mid", "v_r", "0", width, length),
        Resistor("rr", "v_r", "v_return", params.leak_resistance),
        Capacitor("cr", "v_r", "0", params.replica_capacitance),
        Resistor("r1p", "v_e", "v_q", r_1),
        Resistor("r2p", "v_q", "v_pedestal", r_2),
        Capacitor("c2p", "v_q", "0", params.smoothing_capacitance),
        Resistor("r1n", "v_r", "v_n", r_1),
        Resistor("r2n", "v_n", "envelope", r_2),
        Capacitor("c2n", "v_n", "envelope", params.smoothing_capacitance),
        Capacitor("cn", "v_n", "0", stray),
        Capacitor("co", "envelope", "0", stray),
        OperationalAmplifier(
            "op", "v_q", "v_n", "envelope", "vdd",
            gain=params.amplifier_gain, output_resistance=params.amplifier_resistance,
        ),
    )  # fmt: skip
    ports = (SUPPLY, *analog_in("microphone"), *analog_out("envelope"))
    return biased("envelope_detector", ports, BIASES, devices)


CARRIER = 40e3  # Hz, the paper's speaker
SAMPLE_RATE = 1e6  # Hz, ours
RISE_TIME = 0.2e-3  # s, ours: raised-cosine edges of a burst
SOUND_TIME = 0.5e-3  # s, ours: when the testbench's first burst begins
AFTER_SOUND = 1e-3  # s, ours: how long the testbench goes on after the last burst
HEARD = 5e-3  # V, ours: an envelope that rises by less counts as silence


def tone_bursts(
    bursts: tuple[tuple[float, float, float], ...], stop: float, middle: float, v_dd: float
) -> Sampled:
    """Microphone signal of tone bursts about `middle` (V), cut off at the rails.

    bursts: the start (s), duration (s) and peak (V) of each. The samples run from 0 to `stop` (s) at
    `SAMPLE_RATE`. Raises `ParameterError` for a burst that is too short for its two edges, and for too many
    samples.
    """
    count = whole_number("samples", float(np.ceil(stop * SAMPLE_RATE)) + 1.0, 1, SAMPLES)
    time = np.arange(count) / SAMPLE_RATE
    envelope = np.zeros(time.size)
    for start, duration, peak in bursts:
        if duration < 2.0 * RISE_TIME:
            raise ParameterError(f"duration: {duration:g} s, must be >= {2.0 * RISE_TIME:g} s for both edges")
        since = time - start
        progress = np.clip(np.minimum(since, duration - since) / RISE_TIME, 0.0, 1.0)
        envelope += peak * (0.5 - 0.5 * np.cos(np.pi * progress))
    tone = envelope * np.cos(2.0 * np.pi * CARRIER * time)
    return Sampled(0.0, SAMPLE_RATE, np.clip(middle + tone, 0.0, v_dd))


STIMULI = (
    Stimulus("amplitude", "V", 2.4, "peak of the first burst at the microphone"),
    Stimulus("second_amplitude", "V", None, "peak of a second burst", can_be_off=True),
    Stimulus("delay", "s", 2e-3, "second burst after the first"),
    lasting(1e-3, "length of each burst"),
)
PLOTTED = ("microphone", "v_e", "envelope")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A burst of peak `amplitude` (V) at 0.5 ms, and one of `second_amplitude` after `delay` unless off."""
    duration, delay = stimuli["duration"] or 0.0, stimuli["delay"] or 0.0
    bursts = [(SOUND_TIME, duration, stimuli["amplitude"] or 0.0)]
    second = stimuli["second_amplitude"]
    if second is not None:
        bursts.append((SOUND_TIME + delay, duration, second))
    stop = max(start for start, _, _ in bursts) + duration + AFTER_SOUND
    sound = tone_bursts(tuple(bursts), stop, 0.5 * v_dd, v_dd)
    return Testbench("envelope detector", circuit, powered(v_dd, {"microphone": sound}), stop)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `pedestal_V`, `envelope_peak_V`, `latency_s` and `fall_time_s`.

    pedestal: the envelope at the start. envelope_peak: its largest rise above that. latency: from the start
    of the first burst to the envelope's rise through half its peak. fall_time: from its last fall through
    half the peak to its last fall through 5 % of it. The times are None in silence.
    """
    time, envelope = result.time, result["envelope"]
    rise = envelope - envelope[0]
    peak = float(rise.max())
    heard = peak >= HEARD
    half = rising_crossing(time, rise, 0.5 * peak) if heard else None
    falls = (_last_fall(time, rise, share * peak) if heard else None for share in (0.5, 0.05))
    return {
        "pedestal_V": float(envelope[0]),
        "envelope_peak_V": peak,
        "latency_s": between(SOUND_TIME, half),
        "fall_time_s": between(*falls),
    }


def outcome(result: Result) -> str:
    """`sound` where the envelope rises by 5 mV or more, else `silence`."""
    envelope = result["envelope"]
    return "sound" if float(envelope.max() - envelope[0]) >= HEARD else "silence"


def _last_fall(time: np.ndarray, v: np.ndarray, level: float) -> float | None:
    crossing = rising_crossing(-time[::-1], v[::-1], level)
    return None if crossing is None else -crossing


BLOCK = catalogued("envelope-detector", build, STIMULI, testbench, measures, outcome, PLOTTED)
