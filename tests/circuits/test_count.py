"""Whole numbers within limits."""

import math

import pytest

from circuits.count import PARTS, PULSES, pulse_count, whole_number
from circuits.errors import ParameterError


def test_a_count_comes_back_as_a_whole_number() -> None:
    assert whole_number("taps", 3.0) == 3
    assert whole_number("reach", 0, 0) == 0
    assert whole_number("taps", PARTS) == PARTS
    assert pulse_count("events", 5.0, 200.0) == 5


@pytest.mark.parametrize("value", [0, 1.5, math.nan, math.inf, 42949672964294967296, PARTS + 1])
def test_what_is_no_count(value: float) -> None:
    with pytest.raises(ParameterError) as refused:
        whole_number("taps", value)
    assert str(refused.value) == f"taps: {value:g}, must be a whole number from 1 to {PARTS}"


def test_pulses_have_a_rate_and_a_limit() -> None:
    with pytest.raises(ParameterError, match=r"^rate: 0 Hz, must be > 0$"):
        pulse_count("events", 1.0, 0.0)
    with pytest.raises(ParameterError, match=rf"^events: 1e\+18, must be a whole number from 1 to {PULSES}$"):
        pulse_count("events", 1e18, 1.0)
