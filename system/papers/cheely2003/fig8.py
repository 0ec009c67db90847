"""Figure 8 of Cheely & Horiuchi 2003: output of the envelope board and the spikes after a vocalization.

A call of 1 ms among resting targets at 0.8 and 1.8 m is heard by the microphone with its noise; the
transistors of the envelope detector follow the sound, and those of the onset and of the high-threshold neuron
follow the envelope, as in the approach system. Their spikes are compared with the paper's statements, and
their times with the sounds'. The call is as loud as the controller makes it for the near target's distance
(linear look-up): at the amplitude that it has without a target, an echo from 0.8 m reaches the high threshold
(see the notes). The paper shows the traces and gives no numbers. Its statements: the onset neuron fires a
single spike at the beginning of each sound, the vocalization included; the high-threshold neuron fires for
the vocalization only. Rules and times are ours:

- an onset spike comes within the first half of its sound (0.5 ms), the high-threshold spike within the call;
- the delay that the ranging chip sees, from the high-threshold spike to the echo's onset spike, is within
  0.5 ms (8 cm) of the sounds' own, a quarter of the spacing of its neurons' best delays.

The call's loudness and the high threshold were chosen so that the call reaches it and echoes do not: the
high-threshold neuron's counts are fitted, as is the onset neuron's for the call.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chips.polyline import thin
from chips.ranging.circuit import BEST_DELAYS
from circuits.arrays import F64
from circuits.blocks.sonar import (
    centroid_board,
    envelope_detector,
    high_threshold_neuron,
    onset_neuron,
    vocalization_controller,
)
from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, PiecewiseLinear, Sampled, Waveform
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from system.approach.loop import ENVELOPE_TOLERANCE
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS, INK
from system.rule import as_many, below, within
from system.statement import Statement
from system.worlds.sound import microphone as mic
from system.worlds.sound.acoustics import CALL_DURATION, Call, speed_of_sound, two_way_delay
from system.worlds.sound.ear import SAMPLE_RATE
from system.worlds.sound.targets import ConstantVelocity, Target
from system.worlds.sound.waveform import waveform

STOP = 16e-3  # s
CALL_START = 1e-3  # s
RANGES = {"near": 0.8, "far": 1.8}  # m
SOON = 0.5e-3  # s after a sound's onset
DELAY_ERROR = 0.5e-3  # s
DRIVE_RATE = 1e6  # Hz, of the drawn drive


@dataclass(frozen=True, slots=True)
class Recording:
    """The call, its sounds' paths in order of arrival, and the three circuits' runs."""

    call: Call
    paths: tuple[mic.SoundPath, ...]
    envelope: Result
    onset: Result
    high_threshold: Result


def run(progress: Progress) -> Report:
    """Simulate the hearing of a call and two echoes, and compare its spikes with the sounds."""
    recording = _record(progress)
    rows = (*_count_rows(recording), *_latency_rows(recording), *_delay_rows(recording))
    heard = ", ".join(f"{p.source} {1e3 * p.onset:.2f} ms at {p.amplitude:.3g} V" for p in recording.paths)
    loudest, _ = _amplitude_law()
    shout = mic.echo_amplitude(mic.Microphone(), loudest, 1.0, RANGES["near"])
    sounds = (
        f"Sounds at the amplifier's output before clipping, for a call of {recording.call.amplitude:.3g} V:"
        f" {heard}."
    )
    warning = (
        f"A call of {loudest:.3g} V, the controller's at 0 V, would make the near echo {shout:.3g} V: above"
        " the high threshold, so that the chip would take it for a call."
    )
    return Report(rows, lambda figure: _draw(recording, figure), (sounds, warning))


def _amplitude_law() -> tuple[float, float]:
    """(intercept V, slope V/V) of the call's amplitude against the proximity voltage."""
    board = vocalization_controller.Params()
    return vocalization_controller.amplitude_law(board, Silicon(AMI_1500_IDEAL).process.v_dd)


def _call(ear: mic.Microphone) -> Call:
    """The call that the controller makes when the near target's distance is known."""
    delay = float(two_way_delay(RANGES["near"], speed_of_sound(ear.air.temperature))) - ear.mouth_ear_delay
    proximity = float(np.interp(delay, BEST_DELAYS, centroid_board.linear_lookup()))
    intercept, slope = _amplitude_law()
    return Call(start=CALL_START, duration=CALL_DURATION, amplitude=intercept + slope * proximity)


def _record(progress: Progress) -> Recording:
    ear = mic.Microphone()
    call = _call(ear)
    targets = [Target(name, ConstantVelocity(distance)) for name, distance in RANGES.items()]
    sound = mic.hear(ear, mic.MicrophoneState(), call, targets)
    _, voltage = waveform(ear, sound, 0.0, STOP, SAMPLE_RATE)
    detector = _simulate(envelope_detector.build(), "microphone", Sampled(0.0, SAMPLE_RATE, voltage))
    progress(0.6)
    time, envelope = thin(detector.time, detector["envelope"], ENVELOPE_TOLERANCE)
    heard = PiecewiseLinear(tuple(time.tolist()), tuple(envelope.tolist()))
    onset = _simulate(onset_neuron.build(), "envelope", heard, watch=("spike",))
    progress(0.8)
    high_threshold = _simulate(high_threshold_neuron.build(), "envelope", heard, watch=("spike",))
    progress(1.0)
    paths = tuple(sorted(sound.paths, key=lambda p: p.onset))
    return Recording(call, paths, detector, onset, high_threshold)


def _simulate(circuit: Circuit, port: str, waveform: Waveform, watch: tuple[str, ...] = ()) -> Result:
    sources = (
        Source("vdd", "vdd", Constant(Silicon(AMI_1500_IDEAL).process.v_dd)),
        Source(port, port, waveform),
    )
    return simulate(Testbench(circuit.name, circuit, sources, STOP, watch), Silicon(AMI_1500_IDEAL))


def _spikes(result: Result, path: mic.SoundPath) -> F64:
    """Spikes from a sound's onset until the board has had a call's length more than the sound, s."""
    times = result.spikes["spike"]
    return times[(times >= path.onset) & (times < path.offset + CALL_DURATION)]


def _count_rows(recording: Recording) -> tuple[Statement, ...]:
    rows = []
    for path in recording.paths:
        direct = path.source == mic.DIRECT
        for name, result, wanted in (
            ("onset", recording.onset, 1),
            ("high_threshold", recording.high_threshold, int(direct)),
        ):
            count = int(_spikes(result, path).size)
            rows.append(
                _count_row(f"{name}_spikes_{path.source}", wanted, count, fitted=direct or name != "onset")
            )
    for name, result, wanted in (
        ("onset", recording.onset, len(recording.paths)),
        ("high_threshold", recording.high_threshold, 1),
    ):
        rows.append(
            _count_row(
                f"{name}_spikes_in_all", wanted, int(result.spikes["spike"].size), fitted=name != "onset"
            )
        )
    return tuple(rows)


def _count_row(name: str, wanted: int, count: int, *, fitted: bool) -> Statement:
    return Statement(name, wanted, count, as_many(), fitted)


def _latency_rows(recording: Recording) -> tuple[Statement, ...]:
    rows = [_latency_row("onset", recording.onset, path, SOON) for path in recording.paths]
    return (
        *rows,
        _latency_row("high_threshold", recording.high_threshold, recording.paths[0], CALL_DURATION),
    )


def _latency_row(name: str, result: Result, path: mic.SoundPath, limit: float) -> Statement:
    latency = _first(_spikes(result, path), path.onset)
    return Statement(f"{name}_latency_{path.source}_s", None, latency, below(limit, "below {milli:g} ms"))


def _delay_rows(recording: Recording) -> tuple[Statement, ...]:
    direct = recording.paths[0]
    call = _first(_spikes(recording.high_threshold, direct), 0.0)
    rows = []
    for path in recording.paths[1:]:
        true = path.onset - direct.onset
        seen = None if call is None else _first(_spikes(recording.onset, path), call)
        rule = within(DELAY_ERROR, "within {milli:g} ms of the sounds' delay")
        rows.append(Statement(f"delay_{path.source}_s", true, seen, rule))
    return tuple(rows)


def _first(times: F64, origin: float) -> float | None:
    return float(times[0]) - origin if times.size else None


def _drive(call: Call) -> tuple[F64, F64]:
    """Time (s) and the 0 to 5 V signal (V) that drives the speaker while the call lasts."""
    time = np.arange(round(STOP * DRIVE_RATE)) / DRIVE_RATE
    on = (time >= call.start) & (time < call.start + call.duration)
    high = np.fmod(time * call.carrier_frequency, 1.0) < 0.5
    return time, np.where(on & high, Silicon(AMI_1500_IDEAL).process.v_dd, 0.0)


def _draw(recording: Recording, figure: Figure) -> None:
    """Four traces from top to bottom as in the paper."""
    figure.set_size_inches(7.0, 4.8)
    stack = figure.subplots(4, 1, sharex=True, gridspec_kw={"height_ratios": (2.4, 1, 1, 1)})
    detector, onset, high = recording.envelope, recording.onset, recording.high_threshold
    _draw_trace(detector.time, detector["envelope"], "envelope (V)", COLOURS[0], stack[0])
    _draw_trace(*_drive(recording.call), "drive (V)", INK, stack[1])
    _draw_trace(onset.time, onset["spike"], "onset (V)", COLOURS[1], stack[2])
    _draw_trace(high.time, high["spike"], "high-thr. (V)", COLOURS[2], stack[3])
    for ax in stack[1:]:
        ax.set(ylim=(-0.6, 5.8), yticks=(0, 5))
    _name_sounds(recording, stack[0])
    stack[0].set_ylim(0.0, 1.2 * float(detector["envelope"].max()))
    stack[-1].set(xlabel="time (ms)", xlim=(0.0, 1e3 * STOP))
    figure.align_ylabels(stack)


def _draw_trace(time: F64, voltage: F64, label: str, colour: str, ax: Axes) -> None:
    ax.plot(1e3 * time, voltage, color=colour, linewidth=1.0)
    ax.set_ylabel(label)


def _name_sounds(recording: Recording, ax: Axes) -> None:
    envelope = recording.envelope
    for path in recording.paths:
        inside = (envelope.time >= path.onset) & (envelope.time < path.offset + CALL_DURATION)
        top = float(envelope["envelope"][inside].max())
        words = "vocalization" if path.source == mic.DIRECT else f"echo from {RANGES[path.source]:g} m"
        middle = 0.5e3 * (path.onset + path.offset)
        ax.annotate(words, (middle, top), xytext=(0, 5), textcoords="offset points", ha="center", fontsize=8)


EXPERIMENT = Experiment(
    "cheely2003-fig8", "envelope board, onset and high-threshold spikes after a vocalization", run
)
