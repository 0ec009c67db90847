"""Ear and hearing of a running sonar at behavioural level: calls in, spikes of both neurons out.

Stands for the ear, the envelope detector, the onset neuron and the high-threshold neuron: the onsets and
peaks of the direct call and of its echoes go to `chips.hearing.model`, without any waveform.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from chips.hearing.model import HearingModel, HearingState, hear
from chips.part import Analog, Event, Output
from circuits.errors import ParameterError
from system.worlds.sound import microphone as mic
from system.worlds.sound.ear import calls_among
from system.worlds.sound.targets import Target


@dataclass(frozen=True, slots=True)
class HearingTime:
    """Time reached (s), what was heard, and how many sounds the amplifier clips."""

    time: float
    heard: HearingState
    clipped: int = 0


@dataclass(frozen=True, slots=True)
class Hearing:
    """Speaker, microphone and both neurons among `targets`; events `call` in, `onset`, `high_threshold` out.

    Raises `ParameterError` for a microphone with noise, which the model does not hear.

    parameters : of transducers and amplifier.
    analog : names of the ports that it drives: none.
    """

    parameters: mic.Microphone
    targets: tuple[Target, ...]
    model: HearingModel
    analog: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse noise."""
        if self.parameters.noise_rms > 0.0:
            raise ParameterError(
                f"hearing.noise_rms: {self.parameters.noise_rms:g} V, must be 0 at behavioural level; "
                "use the transistor level"
            )

    def begin(self, time: float = 0.0) -> HearingTime:
        """Return the state of silence at `time` s."""
        return HearingTime(time, HearingState())

    def next_time(self, state: HearingTime) -> float:
        """Time of the next spike, s."""
        return state.heard.due[0][0] if state.heard.due else math.inf

    def advance(
        self, state: HearingTime, until: float, events: Sequence[Event] = (), analog: Analog = None
    ) -> tuple[HearingTime, float, Output]:
        """Emit the calls among `events`, then go on to `until` (s) or to the next spike."""
        heard, clipped = state.heard, state.clipped
        for call in calls_among(events, analog):
            sound = mic.hear(self.parameters, mic.MicrophoneState(time=call.start), call, self.targets)
            heard = hear(self.model, heard, [(path.onset, path.amplitude) for path in sound.paths])
            clipped += sum(path.amplitude > mic.headroom(self.parameters) for path in sound.paths)
        found: tuple[Event, ...] = ()
        reached = until
        if heard.due and heard.due[0][0] <= until:
            reached, name = heard.due[0]
            found = ((name, reached),)
            heard = replace(heard, due=heard.due[1:])
        output = Output(found, np.array([reached]), np.zeros((1, 0)))
        return HearingTime(reached, heard, clipped), reached, output
