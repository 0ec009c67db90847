"""Power of the array with its bias chain: the two fitted figures, and what is predicted from them."""

from __future__ import annotations

from pathlib import Path

import pytest

from chips.ranging import circuit as ranging_chip
from circuits.solver.operating_point import OperatingPoint
from system.experiment import Report
from system.papers.cheely2003.power import (
    CASES,
    ONE_CASE,
    REST_CASE,
    Case,
    at_rest,
    interval_power,
    run_cases,
)
from system.plot import save_picture
from system.registry import load_experiment


@pytest.fixture(scope="module")
def outcome() -> tuple[Report, list[float]]:
    # without 100 Hz and three echoes, for time
    fractions: list[float] = []
    cases = tuple(c for c in CASES if c.rate < 100.0 and len(c.echoes) < 3)
    return run_cases(fractions.append, cases), fractions


@pytest.fixture(scope="module")
def chip() -> OperatingPoint:
    return at_rest(ranging_chip.build_with_chain())


def test_every_row_agrees(outcome: tuple[Report, list[float]]) -> None:
    rows = {row.name: row for row in outcome[0].rows}
    assert [name for name, row in rows.items() if not row.agrees] == []
    assert {name for name, row in rows.items() if row.fitted} == {
        "quiescent_power_W",
        "power_50_Hz_one_echo_W",
    }
    assert set(rows) > {"power_10_Hz_one_echo_W", "power_50_Hz_no_echo_W", "separate_over_coupled"}


def test_what_was_fitted_is_declared(outcome: tuple[Report, list[float]]) -> None:
    assert any(n.startswith("Fitted: I_cmp 500 nA and I_lim 6.3 uA") for n in outcome[0].notes)


def test_progress_rises_to_one(outcome: tuple[Report, list[float]]) -> None:
    fractions = outcome[1]
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1.0)


def test_it_draws(outcome: tuple[Report, list[float]], tmp_path: Path) -> None:
    picture = tmp_path / "figure.png"
    save_picture(str(picture), outcome[0].draw)
    assert picture.stat().st_size > 10_000  # an empty figure has 3 kB


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
    monkeypatch.setattr("system.papers.cheely2003.power.SETTLING", 5)
    assert interval_power(chip, case).total == pytest.approx(third, rel=1e-3)


def test_the_registry_knows_it() -> None:
    assert load_experiment("cheely2003-power").name == "cheely2003-power"
