"""Noise of the hearing's thresholds: weights, laws and draws."""

import math

import numpy as np
import pytest

from chips.board_kernel import table_at
from chips.hearing_model import HearingState, hear, hearing_on
from chips.hearing_noise import BAND, exponent, rest_noise, seen, steps_of, threshold_factors
from chips.rebound_jitter import SiliconNoise
from circuits.noise import WHITE_ONLY
from circuits.process import BOLTZMANN, kelvin
from circuits.silicon import Silicon
from circuits.solver.noise_analysis import integrate_power

SILICON = Silicon()
MODEL = hearing_on(SILICON, noise=SiliconNoise(1, flicker=WHITE_ONLY))
QUIET = hearing_on(SILICON)


def spikes(model, peak, count, name="onset"):
    found = [hear(model, HearingState(heard=k), [(0.0, peak)]).due for k in range(count)]
    return np.array([time for due in found for time, who in due if who == name])


def test_a_mean_over_a_time_passes_half_its_inverse():
    """White noise S, mean over T with equal weights: `S / 2 T`."""
    flat = np.full(BAND[2], 1e-12)
    assert seen(flat, 1.0, 40e-6) == pytest.approx(math.sqrt(1e-12 / 80e-6), rel=0.03)
    # weights that end sooner than the time take a shorter mean
    assert seen(flat, 1e5, 1e-4) == pytest.approx(math.sqrt(1e-12 * 1e5 / 3.0), rel=0.05)


def test_the_envelope_has_the_noise_of_its_four_resistors():
    """Each branch: 4 k T (R_1 (R_2 / R_1)^2 + R_2), over pi / 2 times the band 1 / (2 pi R_2 C_2)."""
    _, envelope = rest_noise(SILICON, WHITE_ONLY)
    gain, branch = 3.2 / 2.0, 4.0 * BOLTZMANN * kelvin(27.0)
    density = 2.0 * branch * (2e6 * gain**2 + 3.2e6)
    variance = density / (4.0 * 3.2e6 * 20e-12)
    found = integrate_power(np.geomspace(*BAND), envelope)
    # the branch at the microphone's side has both resistors in parallel at its capacitor
    assert 0.8 < found / variance < 1.1


def test_weak_sounds_are_squared_and_loud_ones_are_not():
    assert exponent(1e-3, SILICON) == pytest.approx(2.0, rel=1e-3)
    assert exponent(5.0, SILICON) == pytest.approx(1.0, abs=0.05)
    assert steps_of(SILICON) == pytest.approx((0.042, 1.35))


def test_latencies_scatter_by_the_threshold_over_the_tables_slope():
    peak = 2.0 * MODEL.onset.threshold
    at = math.log(2.0)
    spread = table_at(MODEL.noise.onset_knots, MODEL.noise.onset, at)
    h = 0.02
    table = [table_at(MODEL.onset.knots, MODEL.onset.latency, at + x) for x in (-h, h)]
    expected = spread * (table[0] - table[1]) / (2.0 * h)
    assert spikes(MODEL, peak, 600).std() == pytest.approx(expected, rel=0.15)


def test_a_sound_at_the_threshold_is_heard_half_of_the_time():
    heard = spikes(MODEL, MODEL.onset.threshold, 400).size
    assert 140 < heard < 260  # six deviations of a fair coin
    assert spikes(MODEL, 0.9 * MODEL.onset.threshold, 50).size == 0
    assert spikes(QUIET, MODEL.onset.threshold, 1).size == 1


def test_draws_are_of_seed_and_sound_and_none_without_noise():
    assert threshold_factors(QUIET.noise, 3, 2.0, 1.0) == (1.0, 1.0)
    one = threshold_factors(MODEL.noise, 3, 2.0, 2.0)
    threshold_factors(MODEL.noise, 4, 2.0, 2.0)
    assert threshold_factors(MODEL.noise, 3, 2.0, 2.0) == one
    other = hearing_on(SILICON, noise=SiliconNoise(2, flicker=WHITE_ONLY))
    assert threshold_factors(other.noise, 3, 2.0, 2.0) != one
