"""Whole numbers within limits."""

import math
from dataclasses import dataclass

import pytest

from circuits.count import PARTS, PULSES, Sizes, pulse_count, whole_number
from circuits.errors import ParameterError
from circuits.units import quantity


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


@dataclass(frozen=True)
class _Own(Sizes):
    capacitance: float = quantity(1e-12, "F")
    ratio: float = quantity(2.0, "")
    cells: int = quantity(3, "")


def test_sizes_are_above_zero_and_counts_can_be_built() -> None:
    assert _Own().cells == 3
    with pytest.raises(ParameterError, match=r"^capacitance: 0 F, must be > 0"):
        _Own(capacitance=0.0, cells=0)
    with pytest.raises(ParameterError, match=r"^ratio: nan, must be > 0"):
        _Own(ratio=float("nan"))
    with pytest.raises(ParameterError, match=r"^cells: 65, must be a whole number from 1 to 64"):
        _Own(cells=65)
