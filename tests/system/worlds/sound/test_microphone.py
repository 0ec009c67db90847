"""What reaches the microphone: levels, paths, edges."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.errors import ParameterError
from system.worlds.sound.acoustics import FULL_SCALE_AMPLITUDE, Call, speed_of_sound, two_way_delay
from system.worlds.sound.microphone import (
    DIRECT,
    Microphone,
    MicrophoneState,
    SoundPath,
    direct_amplitude,
    echo_amplitude,
    hear,
    prune,
    sound_segments,
)
from system.worlds.sound.targets import default_scene

RATE = 1e6  # Hz
EAR = Microphone()
QUIET = Microphone(noise_rms=0.0)
LINEAR = Microphone(noise_rms=0.0, supply=1e3, mid_supply=500.0)  # never clips
SCENE = default_scene()
SPEED = speed_of_sound(EAR.air.temperature)


def heard(parameters: Microphone, *calls: Call) -> MicrophoneState:
    state = MicrophoneState()
    for call in calls:
        state = hear(parameters, state, call, SCENE)
    return state


def test_levels_are_as_documented() -> None:
    assert echo_amplitude(EAR, FULL_SCALE_AMPLITUDE, 1.0, 4.8) == pytest.approx(50e-3, rel=1e-12)
    assert direct_amplitude(EAR, 0.2 * FULL_SCALE_AMPLITUDE) == pytest.approx(2.4, rel=1e-12)
    assert direct_amplitude(EAR, FULL_SCALE_AMPLITUDE) > EAR.supply - EAR.mid_supply
    assert float(two_way_delay(4.8, SPEED)) == pytest.approx(28e-3, abs=0.1e-3)


@given(st.floats(0.1, 20.0), st.floats(0.1, 20.0), st.floats(0.01, 10.0), st.floats(0.01, 10.0))
def test_echo_amplitude_scales_as_the_radar_equation(
    one: float, other: float, weak: float, strong: float
) -> None:
    ratio = echo_amplitude(EAR, weak, strong, one) / echo_amplitude(EAR, strong, weak, other)
    assert ratio == pytest.approx((other / one) ** 2, rel=1e-12)


def test_a_call_arrives_directly_and_from_each_target() -> None:
    call = Call(0.5, duration=2e-3)
    state = heard(QUIET, call)
    assert [path.source for path in state.paths] == [DIRECT, "target", "clutter"]
    direct, target, _ = state.paths
    assert direct.delay == QUIET.mouth_ear_delay
    assert direct.amplitude == pytest.approx(12.0, rel=1e-12)
    assert target.onset == call.start + target.delay
    assert target.offset - target.onset == pytest.approx(call.duration, rel=1e-12)
    # The target is 3.5 m away and comes 1 m/s nearer until the sound meets it.
    assert target.delay == pytest.approx(2.0 * 3.5 / (SPEED + 1.0), abs=1e-9)
    assert target.amplitude == pytest.approx(1.152 / (SPEED * target.delay / 2.0) ** 2, rel=1e-12)


def test_a_silent_call_adds_no_path() -> None:
    assert heard(QUIET, Call(0.0, amplitude=0.0)) == MicrophoneState()


def test_sound_segments_merge_what_overlaps() -> None:
    paths = tuple(
        SoundPath("moth", a, b, 0.0, 1.0) for a, b in ((3.0, 4.0), (0.0, 1.0), (0.5, 2.0), (2.0, 2.5))
    )
    assert sound_segments(MicrophoneState(paths), 0.25, 3.5) == ((0.25, 2.5), (3.0, 3.5))
    assert sound_segments(MicrophoneState(paths), 5.0, 6.0) == ()


def test_prune_keeps_what_still_sounds() -> None:
    state = prune(heard(QUIET, Call(0.0)), 24e-3)
    assert [path.source for path in state.paths] == ["target", "clutter"]
    assert state.time == 24e-3


@pytest.mark.parametrize(
    ("attempt", "text"),
    [
        (lambda: heard(EAR, Call(0.0, carrier_frequency=45e3)), "must be the transducers' 40000 Hz"),
        (lambda: heard(EAR, Call(0.0, duration=0.1e-3)), "must be >= 0.0004 s"),
        (lambda: hear(EAR, MicrophoneState(time=1.0), Call(0.5), SCENE), "before listening past it"),
        (lambda: Microphone(gain=0.0), "microphone.gain: 0, must be > 0"),
        (lambda: Microphone(noise_rms=-1.0), "microphone.noise_rms: -1, must be >= 0"),
        (lambda: Microphone(mid_supply=6.0), "microphone.mid_supply: 6 V, must be 0 to 5 V"),
    ],
)
def test_bad_requests_are_refused(attempt: Callable[[], object], text: str) -> None:
    with pytest.raises(ParameterError, match=text) as caught:
        attempt()
    assert "\n" not in str(caught.value)
