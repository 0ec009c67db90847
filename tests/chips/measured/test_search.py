"""Bounds close in on where something begins to hold."""

import pytest

from chips.measured.search import narrowed, narrowed_by_share


def test_bounds_are_as_near_to_each_other_as_is_asked_for() -> None:
    low, high = narrowed(lambda x: x >= 0.3, -1.0, 1.0, 1e-6)
    assert low < 0.3 <= high
    assert 0.0 < high - low <= 1e-6


def test_bounds_of_a_ratio_are_asked_for_the_middle_of_their_logarithms() -> None:
    asked: list[float] = []

    def holds(x: float) -> bool:
        asked.append(x)
        return x >= 3.0

    low, high = narrowed_by_share(holds, 1.0, 100.0, 1e-3)
    assert low < 3.0 <= high <= 1.001 * low
    assert asked[:2] == pytest.approx([10.0, 10.0**0.5])


def test_bounds_that_are_near_enough_stay() -> None:
    assert narrowed(lambda _: True, 1.0, 1.5, 0.5) == (1.0, 1.5)
    assert narrowed_by_share(lambda _: True, 1.0, 1.5, 0.5) == (1.0, 1.5)
