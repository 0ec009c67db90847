"""What components of variation move: the dies of each extent, their spreads, and rows that tell them."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from circuits.silicon.die import Die
from system.papers.checks import variation
from system.study.campaign import Numbered
from tests.system.papers.conftest import Draw


def outcome(key: Numbered) -> variation.Outcome:
    """Numbers by the condition: those of full dies spread half as much, and the second die fails."""
    times = math.exp((1.0 if key.condition.endswith("plain") else 0.5) * (-1) ** key.number)
    return variation.Outcome((times, 1.0), succeeded=key.number != variation.FIRST, error=0.1)


def test_an_extent_has_its_dies() -> None:
    assert variation.die_of("plain", 1003) == Die(number=1003)
    assert variation.die_of("full", 1003) == Die(number=1003, variation="full")
    assert variation.die_of("full, lots", 1003) == Die("A1003", 1003, variation="full")


def test_rows_tell_what_moved(monkeypatch: pytest.MonkeyPatch, drawn: Callable[[Draw], int]) -> None:
    monkeypatch.setattr(variation, "run_one", outcome)
    report = variation.reproduce(lambda _: None, dies=2)
    rows = {row.name: row for row in report.rows}
    assert len(rows) == 16
    moved = rows["gate_full_inhibition_spread"]
    assert moved.paper == pytest.approx(math.sqrt(2.0))
    assert moved.ours == pytest.approx(math.sqrt(0.5))
    assert (rows["generator_full_lots_approach_succeed"].ours, moved.agrees) == (0.5, None)
    assert any(note.startswith("gate biases, full, lots: succeed 1 of 2") for note in report.notes)
    assert drawn(report.draw) > 10_000


def test_a_die_that_fails_to_be_calibrated_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(**_: object) -> None:
        raise variation.CircuitError("no code")

    system = variation.load_system("approach")
    monkeypatch.setattr(type(system), "on_silicon", lambda *_, **given: refuse(**given))
    found = variation.flown("gate", Die(number=1003, variation="full"), 1003)
    assert (found.succeeded, found.error, found.failed) == (False, None, "no code")
    plain = variation.flown("gate", Die(number=1003), 1003)
    assert plain.inhibition[0] != found.inhibition[0]
