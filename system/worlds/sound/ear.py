"""The ear of a running sonar: calls in, the microphone's 40 kHz waveform out.

Silence is one straight line; while anything sounds, or with noise on, the line has one vertex a sample.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from chips.part import Analog, Event, Unforeseen
from circuits.arrays import F64
from circuits.devices.source import Polyline
from system.worlds.sound import microphone as mic
from system.worlds.sound.acoustics import Call
from system.worlds.sound.targets import Target
from system.worlds.sound.waveform import clipped_samples, waveform

SAMPLE_RATE = 1e6  # Hz, ours: 25 samples a cycle of 40 kHz, 0.3 % amplitude error of the straight lines


def calls_among(events: Sequence[Event], analog: Analog) -> Iterator[Call]:
    """Give the call of each event, with the `amplitude` (V) that an analog port has at its time."""
    for _, moment in events:
        yield Call(start=moment, amplitude=float(np.interp(moment, *(analog or {})["amplitude"])))


@dataclass(frozen=True, slots=True)
class Heard:
    """The waveform of one round; no events.

    time : of the samples, float64[n], s.
    voltage : at the amplifier's output, float64[n, 1], V.
    """

    time: F64
    voltage: F64
    events: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class EarState:
    """The microphone's state and the calls emitted so far: (time s, amplitude V)."""

    microphone: mic.MicrophoneState
    calls: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Ear(Unforeseen):
    """Speaker and microphone among `targets`: a `call` event sounds with the voltage at `amplitude`.

    parameters : of transducers and amplifier.
    analog : names of the ports that it drives.
    """

    parameters: mic.Microphone
    targets: tuple[Target, ...]
    analog: tuple[str, ...] = ("microphone",)

    def begin(self, time: float = 0.0) -> EarState:
        """Return the state of silence at `time` s."""
        return EarState(mic.MicrophoneState(time=time))

    def advance(
        self, state: EarState, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[EarState, float, Heard]:
        """Emit the calls among `events`, then listen to `until` (s)."""
        sound, calls = state.microphone, state.calls
        for call in calls_among(events, analog):
            sound = mic.hear(self.parameters, sound, call, self.targets)
            calls = (*calls, (call.start, call.amplitude))
        time, voltage = self._listen(sound, until)
        inside = voltage[(time >= sound.time) & (time < until)]
        clipped = sound.clipped + clipped_samples(self.parameters, inside)
        sound = mic.prune(replace(sound, clipped=clipped), until)
        return EarState(sound, calls), until, Heard(time, voltage[:, None])

    def _listen(self, sound: mic.MicrophoneState, until: float) -> Polyline:
        """Vertices that cover the state's time to `until`: every sample of a sound, the ends of silence."""
        start = sound.time
        noisy = self.parameters.noise_rms > 0.0
        loud = [(start, until)] if noisy else mic.sound_segments(sound, start, until)
        rest = self.parameters.mid_supply
        pieces: list[Polyline] = []
        for begin, end in loud:
            first = max(math.floor(begin * SAMPLE_RATE - 1e-6), 0) / SAMPLE_RATE  # noise is there from 0 on
            last = (math.ceil(end * SAMPLE_RATE + 1e-6) + 0.5) / SAMPLE_RATE
            pieces.append(waveform(self.parameters, sound, first, last, SAMPLE_RATE))
        # where a sound covers an end, its samples around that end take the place of the end itself
        before = [start] if not pieces or pieces[0][0][0] > start else []
        after = [until] if not pieces or pieces[-1][0][-1] < until else []
        time = np.concatenate([before, *(t for t, _ in pieces), after])
        value = np.concatenate([[rest] * len(before), *(v for _, v in pieces), [rest] * len(after)])
        rising, first_of = np.unique(time, return_index=True)
        return np.asarray(rising), value[first_of]
