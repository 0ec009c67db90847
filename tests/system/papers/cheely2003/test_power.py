"""Power of the array with its bias chain: the two fitted figures, and what is predicted from them."""

from __future__ import annotations

import pytest

from chips.ranging import circuit as ranging_chip
from circuits.solver.operating_point import OperatingPoint
from system.papers.cheely2003.power import ONE_CASE, REST_CASE, Case, at_rest, interval_power


@pytest.fixture(scope="module")
def chip() -> OperatingPoint:
    return at_rest(ranging_chip.build_with_chain())


def test_rest_is_the_comparators_current(chip: OperatingPoint) -> None:
    found = interval_power(chip, REST_CASE)
    # 13 comparators of I_cmp from 5 V; the chains and the membranes take a few nA
    assert found.total == pytest.approx(13 * 500e-9 * 5.0, rel=0.01)
    assert abs(found.from_rest) < 1e-3 * found.total


def test_intervals_are_the_same_after_three_calls(
    monkeypatch: pytest.MonkeyPatch, chip: OperatingPoint
) -> None:
    case = Case("100 Hz, one echo", 100.0, ONE_CASE.echoes)
    third = interval_power(chip, case).total
    for calls, within in ((1, 0.01), (5, 1e-3)):  # one call is enough for the small form of the experiment
        monkeypatch.setattr("system.papers.cheely2003.power.SETTLING", calls)
        assert interval_power(chip, case).total == pytest.approx(third, rel=within)
