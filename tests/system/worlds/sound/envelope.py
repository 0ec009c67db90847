"""What an ideal detector of a microphone's envelope would follow: a bound of its samples."""

import math

import numpy as np

from circuits.arrays import F64
from system.worlds.sound.acoustics import tone_envelope
from system.worlds.sound.microphone import Microphone, MicrophoneState


def envelope(parameters: Microphone, state: MicrophoneState, time: F64 | float) -> F64:
    """Envelope in V of the superposed paths at `time` in s: |sum A e exp(-i 2 pi f d)|, not clipped."""
    moment = np.asarray(time, dtype=np.float64)
    phasor = np.zeros(moment.shape, dtype=np.complex128)
    for path in state.paths:
        shape = tone_envelope(moment - path.onset, path.offset - path.onset, parameters.rise_time)
        angle = -math.tau * parameters.carrier_frequency * path.delay
        phasor += path.amplitude * shape * np.exp(1j * angle)
    return np.abs(phasor)
