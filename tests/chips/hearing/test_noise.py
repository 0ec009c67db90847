"""Noise of the hearing's thresholds: their deviation, the latencies that follow, draws."""

import math
from functools import cache

import numpy as np
import pytest

from chips.hearing.model import HearingModel, HearingState, hear, hearing_on
from chips.hearing.noise import ONSET, RATIOS, REST, chain_machine, threshold_factors, threshold_spread
from chips.measured.interpolation import table_at
from chips.noise import SiliconNoise
from circuits.devices.noise import WHITE_ONLY
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.event_jitter import event_jitter

SILICON = Silicon(AMI_1500_IDEAL)
SHARP, DEAF = Silicon(AMI_1500_IDEAL, die=Die("A", 1)), Silicon(AMI_1500_IDEAL, die=Die("A", 8))


@cache
def noisy() -> HearingModel:
    return hearing_on(SILICON, noise=SiliconNoise(1, flicker=WHITE_ONLY))


@cache
def quiet() -> HearingModel:
    return hearing_on(SILICON)


def spikes(model, peak, count, name="onset"):
    found = [hear(model, HearingState(heard=k), [(0.0, peak)]).due for k in range(count)]
    return np.array([time for due in found for time, who in due if who == name])


def test_latencies_scatter_as_the_spike_of_the_chain_does():
    """Within 10 %: 600 draws know 3 %, and the table's slope is 6 % above the circuit's there."""
    peak = 2.0 * noisy().onset.threshold
    jitter = event_jitter(chain_machine("onset", peak, SILICON), "spike", WHITE_ONLY, rest=REST)
    assert spikes(noisy(), peak, 600).std() / jitter.deviation == pytest.approx(1.0, abs=0.1)
    assert jitter.time - ONSET == pytest.approx(spikes(quiet(), peak, 1)[0], abs=4e-6)
    # the detector's resistors make it, and not the followers
    assert sum(v for k, v in jitter.shares().items() if k.startswith("detector.r")) > 0.9


def test_a_die_has_its_own_and_one_that_hears_nothing_at_rest_the_nominal_dies():
    threshold = noisy().onset.threshold
    knots, own = threshold_spread("high_threshold", noisy().high_threshold.threshold, SHARP, WHITE_ONLY)
    assert knots == pytest.approx(np.log(RATIOS["high_threshold"]))
    assert abs(own[1] / noisy().noise.high[1] - 1.0) > 0.1  # its comparator carries another current
    deaf = threshold_spread("onset", threshold, DEAF, WHITE_ONLY)
    assert np.array_equal(deaf, (noisy().noise.onset_knots, noisy().noise.onset))
    with pytest.raises(ParameterError, match=r"hearing\.onset\.threshold: 1e-06 V, must be one that makes"):
        threshold_spread("onset", 1e-6, SILICON, WHITE_ONLY)


def test_latencies_scatter_by_the_threshold_over_the_tables_slope():
    peak = 2.0 * noisy().onset.threshold
    at = math.log(2.0)
    spread = table_at(noisy().noise.onset_knots, noisy().noise.onset, at)
    h = 0.02
    table = [table_at(noisy().onset.knots, noisy().onset.latency, at + x) for x in (-h, h)]
    expected = spread * (table[0] - table[1]) / (2.0 * h)
    assert spikes(noisy(), peak, 600).std() == pytest.approx(expected, rel=0.15)


def test_a_sound_at_the_threshold_is_heard_half_of_the_time():
    heard = spikes(noisy(), noisy().onset.threshold, 400).size
    assert 140 < heard < 260  # six deviations of a fair coin
    assert spikes(noisy(), 0.9 * noisy().onset.threshold, 50).size == 0
    assert spikes(quiet(), noisy().onset.threshold, 1).size == 1


def test_draws_are_of_seed_and_sound_and_none_without_noise():
    assert threshold_factors(quiet().noise, 3, 2.0, 1.0) == (1.0, 1.0)
    one = threshold_factors(noisy().noise, 3, 2.0, 2.0)
    threshold_factors(noisy().noise, 4, 2.0, 2.0)
    assert threshold_factors(noisy().noise, 3, 2.0, 2.0) == one
    other = hearing_on(SILICON, noise=SiliconNoise(2, flicker=WHITE_ONLY))
    assert threshold_factors(other.noise, 3, 2.0, 2.0) != one
