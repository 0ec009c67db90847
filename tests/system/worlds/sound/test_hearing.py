"""Ear and hearing as a part of the loop."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chips.hearing.model import hearing_on
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.worlds.sound.hearing import Hearing
from system.worlds.sound.microphone import Microphone
from system.worlds.sound.targets import Approach, Target

TARGETS = (Target("wall", Approach(1.5, 1.0, 0.5)),)


def test_a_call_is_heard_by_both_neurons_and_its_echo_by_one() -> None:
    part = Hearing(Microphone(noise_rms=0.0), TARGETS, hearing_on(Silicon(AMI_1500_IDEAL)))
    state = part.begin()
    assert math.isinf(part.next_time(state))
    found = []
    events = [("call", 0.0)]
    while state.time < 20e-3:
        expected = part.next_time(state)
        state, reached, output = part.advance(
            state, 20e-3, events, {"amplitude": (np.array([0.0, 1.0]), np.full(2, 4.0))}
        )
        if events == []:
            assert reached == min(expected, 20e-3)
        found += list(output.events)
        events = []
    assert [port for port, _ in found] == ["onset", "high_threshold", "onset"]
    # 1.5 m and back is 8.7 ms at 20 degC; latencies are below 0.3 ms
    assert found[2][1] == pytest.approx(8.8e-3, abs=0.2e-3)


def test_noise_is_refused() -> None:
    with pytest.raises(ParameterError, match="transistor level"):
        Hearing(Microphone(noise_rms=5e-3), TARGETS, hearing_on(Silicon(AMI_1500_IDEAL)))
