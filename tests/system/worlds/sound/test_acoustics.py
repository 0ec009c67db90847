"""Laws of sound in air, and the noise about a carrier."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circuits.errors import ParameterError
from system.worlds.sound.acoustics import (
    CARRIER_BLOCK,
    NOISE_BLOCK,
    Air,
    Call,
    baseband_noise,
    carrier,
    echo_delay,
    echo_pressure,
    interpolate_noise,
    speed_of_sound,
    tone_envelope,
    two_way_delay,
)
from system.worlds.sound.targets import MAX_SPEED, Approach, ConstantVelocity, Waypoints, range_at
from tests.refusals import refusals

SPEED = 343.0  # m/s

ranges = st.floats(0.05, 30.0)
times = st.floats(0.0, 1e3)


def test_speed_of_sound_at_textbook_points() -> None:
    # Textbook figures for dry air: 331.3 m/s at 0 C, 343.2 m/s at 20 C, to the digits given.
    assert speed_of_sound(273.15) == 331.3
    assert speed_of_sound(293.15) == pytest.approx(343.2, abs=0.05)


@pytest.mark.parametrize("temperature", [27.0, 0.0, 400.0, float("nan")])
def test_temperature_outside_the_law_is_refused(temperature: float) -> None:
    with pytest.raises(ParameterError, match="give kelvin"):
        Air(temperature)


@given(ranges)
def test_resting_target_echoes_after_the_way_out_and_back(distance: float) -> None:
    delay = echo_delay(ConstantVelocity(distance), 1.0, SPEED)
    assert delay == pytest.approx(float(two_way_delay(distance, SPEED)), abs=1e-9)
    assert delay == pytest.approx(2.0 * distance / SPEED, abs=1e-9)


@given(ranges, st.floats(-MAX_SPEED, MAX_SPEED), times)
def test_delay_of_moving_target_is_the_closed_form_to_a_nanosecond(
    distance: float, velocity: float, emission: float
) -> None:
    here = distance + velocity * emission
    if here < 0.05:
        emission, here = 0.0, distance
    delay = echo_delay(ConstantVelocity(distance, velocity), emission, SPEED)
    assert delay == pytest.approx(2.0 * here / (SPEED - velocity), abs=1e-9)


@given(times, st.floats(0.5, 20.0), st.floats(0.5, 20.0), st.floats(0.5, MAX_SPEED))
def test_sound_meets_the_target_where_it_is_by_then(
    emission: float, start: float, end: float, speed: float
) -> None:
    late = Waypoints((0.0, emission + 0.01, emission + 1.0), (start, start, start + 0.1 * end))
    for trajectory in (Approach(start, end, speed), late):
        delay = echo_delay(trajectory, emission, SPEED)
        # 1 ns at the speed of sound.
        assert range_at(trajectory, emission + delay / 2.0) == pytest.approx(
            SPEED * delay / 2.0, abs=SPEED * 1e-9
        )


def test_delay_takes_arrays() -> None:
    emission = np.array([[0.0, 1.0], [2.0, 9.0]])
    delay = echo_delay(Approach(4.0, 0.5, 1.0), emission, SPEED)
    assert delay.shape == emission.shape
    assert delay[1, 1] == pytest.approx(1.0 / SPEED, abs=1e-9)


@given(ranges, ranges)
def test_the_pressure_of_an_echo_falls_with_the_square_of_range(one: float, other: float) -> None:
    assert echo_pressure(one) / echo_pressure(other) == pytest.approx((other / one) ** 2, rel=1e-12)


@given(ranges, st.floats(0.0, 3.0))
def test_absorption_acts_out_and_back_beyond_one_metre(distance: float, absorption: float) -> None:
    decibels = 20.0 * math.log10(echo_pressure(distance, absorption) / echo_pressure(distance))
    assert decibels == pytest.approx(-2.0 * absorption * (distance - 1.0), abs=1e-9)


@pytest.mark.parametrize("absorption", [-1.0, float("nan"), float("inf")])
def test_bad_absorption_is_refused(absorption: float) -> None:
    with pytest.raises(ParameterError, match=r"air\.absorption"):
        Air(absorption=absorption)


test_bad_calls_are_refused = refusals(
    ParameterError,
    lambda values: Call(**values),
    [
        ({"start": -1.0}, "call.start: -1 s"),
        ({"start": 0.0, "duration": 0.0}, "call.duration: 0 s"),
        ({"start": 0.0, "amplitude": float("nan")}, "call.amplitude: nan V"),
        ({"start": 0.0, "carrier_frequency": -1.0}, "call.carrier_frequency: -1 Hz"),
    ],
)


def test_tone_rises_holds_and_falls() -> None:
    got = tone_envelope([-0.1, 0.0, 0.05, 0.1, 0.2, 0.5, 0.9, 1.0, 1.1], 1.0, 0.2)
    quarter = 0.5 - 0.5 * math.cos(math.pi / 4.0)
    np.testing.assert_allclose(got, [0.0, 0.0, quarter, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0], atol=1e-15)


@given(st.floats(0.0, 1e-3), st.floats(4e-4, 1e-3))
def test_tone_is_its_own_mirror_image(time: float, duration: float) -> None:
    # 1e-9: mirroring rounds the time.
    assert tone_envelope(time, duration, 2e-4) == pytest.approx(
        float(tone_envelope(duration - time, duration, 2e-4)), abs=1e-9
    )


@given(st.integers(0, 10**9), st.integers(1, 3 * CARRIER_BLOCK))
def test_carrier_is_the_cosine_and_does_not_depend_on_the_segment(first: int, length: int) -> None:
    cosine, sine = carrier(40e3, first, first + length, 1e6)
    index = np.arange(first, first + length)
    angle = 2.0 * np.pi * (index % 25) / 25.0  # 25 samples a cycle
    # 1e-6: 1e9 samples are 4e7 cycles, which doubles hold to 1e-8.
    np.testing.assert_allclose(cosine, np.cos(angle), atol=1e-6)
    np.testing.assert_allclose(sine, np.sin(angle), atol=1e-6)
    tail = carrier(40e3, first + length // 2, first + length, 1e6)
    np.testing.assert_array_equal(tail[0], cosine[length // 2 :])
    np.testing.assert_array_equal(tail[1], sine[length // 2 :])


@given(st.integers(0, 10**12), st.integers(1, 2 * NOISE_BLOCK), st.data())
@settings(deadline=None)  # the first draw loads the generator
def test_noise_samples_are_the_same_in_any_stretch(first: int, length: int, data: st.DataObject) -> None:
    whole = baseband_noise(7, 1, first, first + length)
    begin = data.draw(st.integers(0, length - 1))
    end = data.draw(st.integers(begin + 1, length))
    np.testing.assert_array_equal(baseband_noise(7, 1, first + begin, first + end), whole[:, begin:end])


def test_noise_samples_are_standard_normal_and_independent() -> None:
    count = 200_000
    samples = baseband_noise(1000, 0, 0, count)
    # Five standard errors, of a mean, a variance and a correlation.
    error = 5.0 / math.sqrt(count)
    np.testing.assert_allclose(samples.mean(axis=1), 0.0, atol=error)
    np.testing.assert_allclose(samples.var(axis=1), 1.0, atol=error * math.sqrt(2.0))
    others = [baseband_noise(1001, 0, 0, count)[0], baseband_noise(1000, 1, 0, count)[0], samples[1]]
    neighbours = [np.roll(samples[0], 1), np.roll(samples[0], NOISE_BLOCK)]
    for other in others + neighbours:
        assert abs(np.mean(samples[0] * other)) < error


@given(st.floats(0.0, 0.999))
def test_interpolated_noise_has_the_same_variance_everywhere(fraction: float) -> None:
    # The weights of two independent samples of variance 1: their squares must add up to 1.
    first, _ = interpolate_noise(np.array([[1.0, 0.0], [0.0, 0.0]]), 5, np.array([5.0 + fraction]))
    second, _ = interpolate_noise(np.array([[0.0, 1.0], [0.0, 0.0]]), 5, np.array([5.0 + fraction]))
    assert first[0] ** 2 + second[0] ** 2 == pytest.approx(1.0, abs=1e-14)
