"""The ear: silence is a line, sound is samples, and the segmentation does not matter."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from system.worlds.sound.acoustics import CALL_DURATION, speed_of_sound, two_way_delay
from system.worlds.sound.ear import Ear
from system.worlds.sound.microphone import Microphone
from system.worlds.sound.targets import ConstantVelocity, Target
from tests.system.worlds.sound.envelope import envelope

AMPLITUDE = (np.array([0.0, 1.0]), np.array([4.0, 4.0]))


@pytest.fixture
def ear() -> Ear:
    return Ear(Microphone(noise_rms=0.0), (Target("t", ConstantVelocity(1.0)),))


def test_silence_is_a_straight_line(ear: Ear) -> None:
    _, _, heard = ear.advance(ear.begin(), 5e-3)
    assert heard.time.tolist() == [0.0, 5e-3]
    assert heard.voltage[:, 0].tolist() == [2.5, 2.5]


def test_noise_is_heard_from_the_first_moment_on() -> None:
    ear = Ear(Microphone(noise_rms=5e-3, seed=3), ())
    state, _, heard = ear.advance(ear.begin(), 4e-3)
    assert heard.time[0] == 0.0
    assert heard.time[-1] >= 4e-3
    # 8 kHz of noise for 4 ms are some 30 independent values
    assert heard.voltage.std() == pytest.approx(5e-3, rel=0.5)
    _, _, whole = ear.advance(ear.begin(), 8e-3)
    _, _, later = ear.advance(state, 8e-3)
    both = np.intersect1d(whole.time, later.time)
    assert both.size > 4000
    at = np.interp(both, whole.time, whole.voltage[:, 0]), np.interp(both, later.time, later.voltage[:, 0])
    assert np.abs(at[0] - at[1]).max() < 1e-12


def test_call_and_echo_are_heard_at_their_time(ear: Ear) -> None:
    state, _, _ = ear.advance(ear.begin(), 1e-3)
    state, _, heard = ear.advance(state, 11e-3, [("call", 1e-3)], {"amplitude": AMPLITUDE})
    loud = heard.time[np.abs(heard.voltage[:, 0] - 2.5) > 0.02]
    first_echo = loud[loud > 1e-3 + CALL_DURATION + 1e-3][0]
    delay = two_way_delay(1.0, speed_of_sound(ear.parameters.air.temperature))
    # the echo rises over 0.2 ms from its onset
    assert 0.0 < first_echo - (1e-3 + delay) < 0.2e-3
    assert state.calls == ((1e-3, 4.0),)


def test_segments_join_without_a_jump(ear: Ear) -> None:
    state, _, _ = ear.advance(ear.begin(), 1e-3)
    whole = ear.advance(state, 9e-3, [("call", 1e-3)], {"amplitude": AMPLITUDE})[2]
    half, _, first = ear.advance(state, 1.7003e-3, [("call", 1e-3)], {"amplitude": AMPLITUDE})
    second = ear.advance(half, 9e-3)[2]
    probe = np.linspace(1e-3, 9e-3, 5001)
    joined = np.where(
        probe <= 1.7003e-3,
        np.interp(probe, first.time, first.voltage[:, 0]),
        np.interp(probe, second.time, second.voltage[:, 0]),
    )
    assert np.abs(joined - np.interp(probe, whole.time, whole.voltage[:, 0])).max() < 1e-12
    assert (
        np.abs(whole.voltage[:, 0] - 2.5).max()
        <= envelope(ear.parameters, half.microphone, whole.time).max() + 2.5
    )


def test_a_clipped_sample_is_counted_once(ear: Ear) -> None:
    calls = [("call", 0.0), ("call", 5e-3)]
    whole, _, _ = ear.advance(ear.begin(), 20e-3, calls, {"amplitude": AMPLITUDE})
    # 12 V onto 2.5 V for a full-scale call, 9.6 V here: of 0.6 ms at full height five sixths of the samples
    assert whole.microphone.clipped > 2 * 0.8 * 600
    state, begun = ear.begin(), 0.0
    for stop in (0.31e-3, 0.7003e-3, 5.2e-3, 5.6e-3, 20e-3):
        events = [call for call in calls if begun <= call[1] < stop]
        state, _, _ = ear.advance(pickle.loads(pickle.dumps(state)), stop, events, {"amplitude": AMPLITUDE})
        begun = stop
    assert state.microphone == whole.microphone
