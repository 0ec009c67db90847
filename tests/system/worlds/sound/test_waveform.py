"""Samples of the microphone: superposition, segments, noise, clipping."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import welch

from circuits.errors import ParameterError
from system.worlds.sound.acoustics import FULL_SCALE_AMPLITUDE, Call
from system.worlds.sound.microphone import (
    Microphone,
    MicrophoneState,
    SoundPath,
    sound_segments,
)
from system.worlds.sound.waveform import clipped_samples, waveform
from tests.system.worlds.sound.envelope import envelope
from tests.system.worlds.sound.test_microphone import EAR, LINEAR, QUIET, RATE, heard


def test_quietest_direct_call_reaches_its_peak_in_the_waveform() -> None:
    state = heard(QUIET, Call(0.0, amplitude=0.2 * FULL_SCALE_AMPLITUDE))
    _, voltage = waveform(QUIET, state, 0.0, 2e-3, RATE)
    # 25 samples a cycle: a crest is missed by at most 1 - cos(pi / 25), 0.8 %.
    assert 2.2 < voltage.max() - 2.5 < 2.4 + 1e-12
    assert clipped_samples(QUIET, voltage) == 0


def test_waveform_is_the_gated_delayed_carrier() -> None:
    path = SoundPath("moth", 10.05e-3, 11.05e-3, 10.05e-3, 0.3)
    time, voltage = waveform(QUIET, MicrophoneState((path,)), 0.0, 12e-3, RATE)
    since = time - path.onset
    rise = np.clip(np.minimum(since, 1e-3 - since) / QUIET.rise_time, 0.0, 1.0)
    expected = 2.5 + 0.3 * np.sin(0.5 * np.pi * rise) ** 2 * np.cos(2.0 * np.pi * 40e3 * since)
    # 1e-9 V: roundings of phases of a few hundred cycles.
    np.testing.assert_allclose(voltage, expected, atol=1e-9)
    assert np.abs(voltage - 2.5).max() > 0.29


amplitudes = st.floats(0.0, 3.0)
onsets = st.floats(0.0, 3e-3)


@given(onsets, onsets, amplitudes, amplitudes)
@settings(max_examples=30, deadline=None)
def test_paths_superpose(first: float, second: float, loud: float, soft: float) -> None:
    one = SoundPath("one", first, first + 1e-3, first, loud)
    two = SoundPath("two", second, second + 1e-3, second, soft)
    _, alone = waveform(LINEAR, MicrophoneState((one,)), 0.0, 5e-3, RATE)
    _, other = waveform(LINEAR, MicrophoneState((two,)), 0.0, 5e-3, RATE)
    _, both = waveform(LINEAR, MicrophoneState((one, two)), 0.0, 5e-3, RATE)
    mid = LINEAR.mid_supply
    # 1e-11 V: roundings at the 500 V that keeps the rails away.
    np.testing.assert_allclose(both - mid, (alone - mid) + (other - mid), atol=1e-11)


def test_opposite_phases_cancel_and_equal_phases_add() -> None:
    period = 1.0 / 40e3
    path = SoundPath("one", 0.0, 1e-3, 0.0, 1.0)
    state = MicrophoneState((path, replace(path, delay=period / 2.0)))
    assert envelope(LINEAR, state, 0.5e-3) == pytest.approx(0.0, abs=1e-12)
    _, voltage = waveform(LINEAR, state, 0.0, 1e-3, RATE)
    np.testing.assert_allclose(voltage, LINEAR.mid_supply, atol=1e-11)
    state = MicrophoneState((path, replace(path, delay=period)))
    assert envelope(LINEAR, state, 0.5e-3) == pytest.approx(2.0, rel=1e-12)


@given(onsets, onsets)
@settings(max_examples=30, deadline=None)
def test_envelope_bounds_the_waveform_and_is_reached(first: float, second: float) -> None:
    paths = tuple(
        SoundPath(name, onset, onset + 1e-3, onset, size)
        for name, onset, size in (("a", first, 0.5), ("b", second, 0.3))
    )
    time, voltage = waveform(LINEAR, MicrophoneState(paths), 0.0, 5e-3, RATE)
    bound = envelope(LINEAR, MicrophoneState(paths), time)
    swing = np.abs(voltage - LINEAR.mid_supply)
    assert np.all(swing <= bound + 1e-11)
    # Within half a cycle the envelope moves by less than 8 V/ms (raised cosine over 0.2 ms), so 0.1 V.
    assert swing.max() > bound.max() - 0.1


cuts = st.lists(st.integers(1, 39_999), max_size=6, unique=True).map(sorted)


@given(cuts, st.sampled_from([EAR, QUIET]), st.sampled_from([1e6, 0.44e6, 1.234567e6]))
@settings(max_examples=40, deadline=None)
def test_samples_do_not_depend_on_the_segments(cut: list[int], ear: Microphone, rate: float) -> None:
    state = heard(ear, Call(0.0), Call(5e-3, duration=20e-3), Call(26e-3))
    edges = [0.0, *(index * 1e-6 for index in cut), 40e-3]
    time, voltage = waveform(ear, state, 0.0, 40e-3, rate)
    parts = [waveform(ear, state, start, stop, rate) for start, stop in pairwise(edges)]
    np.testing.assert_array_equal(np.concatenate([part[0] for part in parts]), time)
    np.testing.assert_array_equal(np.concatenate([part[1] for part in parts]), voltage)


def test_samples_lie_on_the_grid() -> None:
    time, voltage = waveform(QUIET, MicrophoneState(), 0.3, 0.3 + 5e-6, RATE)
    np.testing.assert_array_equal(time, np.arange(300_000, 300_005) / RATE)
    np.testing.assert_array_equal(voltage, 2.5)
    time, _ = waveform(QUIET, MicrophoneState(), 0.5e-6, 2.5e-6, RATE)
    np.testing.assert_array_equal(time, [1e-6, 2e-6])
    assert waveform(EAR, MicrophoneState(), 0.3, 0.3, RATE)[0].size == 0


def test_output_clips_at_the_rails_and_is_counted() -> None:
    state = heard(QUIET, Call(0.0))
    _, voltage = waveform(QUIET, state, 0.0, 2e-3, RATE)
    assert (voltage.min(), voltage.max()) == (0.0, 5.0)
    clipped = clipped_samples(QUIET, voltage)
    assert clipped == np.count_nonzero((voltage == 0.0) | (voltage == 5.0))
    # 12 V onto 2.5 V: over the 0.6 ms at full height all but 2/pi asin(2.5/12), 13 %, of the samples clip.
    assert clipped > 0.85 * 600


def test_noise_has_the_rms_and_the_band_asked_for() -> None:
    ear = Microphone(noise_rms=0.1, seed=1000)
    _, voltage = waveform(ear, MicrophoneState(), 0.0, 4.0, 2e5)
    noise = voltage - ear.mid_supply
    # About 4 s x 5 kHz independent values: a standard error of the rms of 0.5 %; four of them.
    assert math.sqrt(np.mean(noise**2)) == pytest.approx(0.1, rel=0.02)
    assert abs(noise.mean()) < 1e-3
    frequency, power = welch(noise, 2e5, nperseg=2000)
    offset = np.abs(frequency - ear.carrier_frequency)
    total = power.sum()
    # The kernel's own spectrum has 96.1 % of its power within +-rate/2 and 99.5 % within +-3 rate/4.
    assert power[offset <= 4e3].sum() / total == pytest.approx(0.961, abs=0.01)
    assert power[offset <= 6e3].sum() / total == pytest.approx(0.995, abs=0.004)
    level = power[offset <= 1e3].mean()
    assert power[(offset > 1.8e3) & (offset < 2.2e3)].mean() > 0.5 * level
    assert power[(offset > 2.8e3) & (offset < 3.2e3)].mean() < 0.5 * level


def test_noise_depends_on_seed_and_channel_alone() -> None:
    def draw(ear: Microphone) -> list[float]:
        values: list[float] = waveform(ear, MicrophoneState(), 1.0, 1.001, RATE)[1].tolist()
        return values

    assert draw(Microphone(seed=5)) == draw(Microphone(seed=5))
    drawn = [draw(ear) for ear in (Microphone(seed=5), Microphone(seed=6), Microphone(seed=5, channel=1))]
    assert drawn[0] != drawn[1]
    assert drawn[0] != drawn[2]


@given(st.integers(0, 30_000), st.integers(0, 10_000))
@settings(max_examples=30, deadline=None)
def test_outside_the_sound_segments_all_is_silent(start: int, length: int) -> None:
    state = heard(QUIET, Call(0.0), Call(3e-3), Call(3.5e-3))
    begin, end = start * 1e-6, (start + length) * 1e-6
    segments = sound_segments(state, begin, end)
    assert all(begin <= a < b <= end for a, b in segments)
    assert all(before[1] < after[0] for before, after in pairwise(segments))
    time, voltage = waveform(QUIET, state, begin, end, RATE)
    sounding = np.zeros(time.shape, dtype=bool)
    for a, b in segments:
        sounding |= (time >= a) & (time <= b)
    np.testing.assert_array_equal(voltage[~sounding], 2.5)


@pytest.mark.parametrize(
    ("start", "stop", "rate", "text"),
    [
        (1.0, 0.5, RATE, "segment: 1 to 0.5 s"),
        (-1.0, 0.5, RATE, "segment: -1 to 0.5 s"),
        (0.0, 0.5, 8e4, "must be > 80000 Hz"),
    ],
)
def test_a_segment_that_makes_no_sense_is_refused(start: float, stop: float, rate: float, text: str) -> None:
    with pytest.raises(ParameterError, match=text):
        waveform(EAR, MicrophoneState(), start, stop, rate)
