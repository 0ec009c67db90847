"""Numbers of the head: what follows from them, and what is refused by name."""

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.head.numbers import Motion, SonarHead
from tests.refusals import refusals


def test_thresholds_are_decibels_apart() -> None:
    found = np.array(SonarHead().thresholds)
    assert 20.0 * np.log10(found[1:] / found[:-1]) == pytest.approx(np.full(9, 3.0))
    assert SonarHead().period == pytest.approx(0.1)


test_numbers_that_cannot_be_are_refused = refusals(
    ParameterError,
    lambda numbers: SonarHead(**numbers),
    [
        ({"ping_rate": 0.0}, r"head\.ping_rate: 0, must be > 0"),
        ({"gain": -0.1}, r"head\.gain: -0.1, must be >= 0"),
        ({"decision": 1.5}, r"head\.decision: 1.5, must be at most 1"),
        ({"rise": 0.9e-3}, r"head\.rise: 0.0009 s, must be at most half of the call"),
        ({"neck_speed": float("inf")}, r"head\.neck_speed: inf, must be > 0 and finite"),
    ],
)


def test_a_target_behind_the_head_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"target\.azimuth: 90 deg, must be below 90 deg"):
        Motion(azimuth=np.pi / 2.0)
