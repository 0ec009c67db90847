"""The vocalization controller's model beside its circuit, and its laws."""

from __future__ import annotations

import numpy as np
import pytest

from chips.boards.vocalization.measure import circuit_calls, model_calls, random_ramp
from chips.boards.vocalization.model import VocalizationModel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

CASES = (
    (Silicon(AMI_1500_IDEAL), 5e-3),
    (Silicon(AMI_1500_IDEAL, temperature_c=55.0), 5e-3),
    (Silicon(AMI_1500_IDEAL, die=Die("A", 1003)), 0.026),
)


@pytest.mark.parametrize(("silicon", "tolerance"), CASES, ids=["nominal", "hot", "die"])
def test_calls_come_as_the_circuits_on_ramps(silicon: Silicon, tolerance: float) -> None:
    ramp = random_ramp(np.random.default_rng(11))
    one, other = circuit_calls(silicon, ramp), model_calls(silicon, ramp)
    assert len(one) == len(other) > 5
    intervals = np.diff(other[:, 0], prepend=0.0) / np.diff(one[:, 0], prepend=0.0)
    # on other dies than those that it was built on the record's largest error is 2.6 %
    assert np.abs(intervals - 1.0).max() < tolerance
    # the amplitude itself is exact to 0.3 mV; a ramp of 20 V/s moves on by the calls' error
    assert np.abs(other[:, 1] - one[:, 1]).max() < 4.0 * tolerance


def test_calls_stop_the_advance_and_the_phase_goes_on() -> None:
    model = VocalizationModel(Silicon(AMI_1500_IDEAL))
    line = {"proximity": (np.zeros(1), np.array([3.0]))}
    state, first, _ = model.advance(model.begin(), 1.0, (), line)
    cut = model.begin()
    for until in np.linspace(0.0, first, 8)[1:-1]:
        cut, _, _ = model.advance(cut, float(until), (), line)
    cut, again, output = model.advance(cut, 1.0)
    assert again == pytest.approx(first, abs=1e-12)
    assert output.events == (("call", again),)
    _, second, _ = model.advance(state, 1.0)
    assert 1.0 / (second - first) == pytest.approx(30.0, rel=0.01)
