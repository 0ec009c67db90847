"""The hearing's model beside envelope detector, onset neuron and high-threshold neuron."""

from __future__ import annotations

import numpy as np
import pytest

from chips.hearing.measure import Ears, model_spikes, paired, random_sounds
from chips.hearing.model import NEURONS, HearingState, hear, hearing_on
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

CASES = (
    (Silicon(AMI_1500_IDEAL), 10e-6),
    (Silicon(AMI_1500_IDEAL, temperature_c=60.0, die=Die("A", 1003)), 40e-6),
)


@pytest.mark.parametrize(("silicon", "tolerance"), CASES, ids=["nominal", "die"])
def test_spikes_come_as_the_circuits_for_calls_and_echoes(silicon: Silicon, tolerance: float) -> None:
    sounds = random_sounds(np.random.default_rng(3))
    one, (other, _) = Ears(silicon).spikes(sounds), model_spikes(silicon, sounds)
    assert len(other["high_threshold"]) == 5
    for name in NEURONS:
        pairs, alone = paired(one[name], other[name])
        assert alone == 0
        assert max(abs(a - b) for a, b in pairs) < tolerance


def test_what_is_softer_than_the_threshold_is_not_heard() -> None:
    model = hearing_on(Silicon(AMI_1500_IDEAL))
    soft = hear(model, HearingState(), [(1e-3, 0.9 * model.onset.threshold)])
    assert soft.due == ()
    assert soft.undecided == 0
    near = hear(model, HearingState(), [(1e-3, 1.01 * model.onset.threshold)])
    assert [name for _, name in near.due] == ["onset"]
    assert near.undecided == 1


def test_louder_is_sooner_and_the_second_of_two_close_sounds_is_lost() -> None:
    model = hearing_on(Silicon(AMI_1500_IDEAL))
    times = [hear(model, HearingState(), [(0.0, peak)]).due[0][0] for peak in (0.05, 0.2, 1.0, 8.0)]
    assert times == sorted(times, reverse=True)
    close = hear(model, HearingState(), [(0.0, 1.0), (1.1e-3, 0.2)])
    apart = hear(model, HearingState(), [(0.0, 1.0), (3e-3, 0.2)])
    assert len(close.due) == 1
    assert len(apart.due) == 2
