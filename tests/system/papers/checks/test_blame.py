"""Blame of the approach's dies: rows by their rules, the null, and a campaign that goes on."""

from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.figure import Figure

from circuits.silicon.die import Die
from system.papers.checks import blame
from system.study.campaign import Numbered
from tests.system.papers.campaigns import goes_on


def outcome(key: Numbered) -> blame.Outcome:
    """Every third die does not fail; of the others one or two devices are named."""
    if key.number % 3 == 0:
        return blame.Outcome(failing=False)
    if key.condition == blame.PLANTED:
        return blame.Outcome(True, True, ("chip.m1.v_t0",), True, 60, 0, 0, "chip.m1")
    named = ("chip.m1.v_t0", "chip.m1.beta", "chip.m2.v_t0")[: 1 + key.number % 3]
    return blame.Outcome(True, True, named, True, 100, 0, 5)


def test_rows_count_devices_and_the_null_mends_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blame, "run_one", outcome)
    report = blame.reproduce(lambda _: None, dies=6, faults=4)
    rows = {row.name: row for row in report.rows}
    assert rows["mended_by_1"].shown == "3 of 6 (12 to 88 %)"  # of the others two devices are named
    assert report.agrees
    null = {row.name: row.agrees for row in report.nulls[0].rows}
    assert null["mended_by_10"] is False
    assert null["planted_named_first"] is False
    report.draw(Figure())


def test_campaign_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blame, "run_one", outcome)
    report = goes_on(
        lambda execution: blame.reproduce(lambda _: None, execution, dies=2, faults=1),
        lambda execution: blame.reproduce(lambda _: None, execution, dies=4, faults=3),
        tmp_path,
    )
    assert len(report.notes) == 4


def test_fault_is_on_a_device_of_the_chip() -> None:
    device = blame._device(7)
    assert device == blame._device(7) != blame._device(8)
    assert device.startswith("ranging_chip.neuron[")
    die = blame._with_fault(device, 7)
    assert die.edits[-1] == Die().with_(device, "v_t0", blame.FAULT).edits[0]
    assert die.edits[0].kind == "heal"  # what fails without a fault
    assert die.number == 7


def test_a_part_that_was_not_taken_apart_counts_for_its_devices() -> None:
    whole = blame.Outcome(True, True, ("chip.cell[*].m1",), True, 300, devices=13)
    assert blame.devices_of(whole) == 13
    assert not blame.mended_by(whole, 10)
    assert blame.mended_by(blame.Outcome(True, True, ("chip.m1.v_t0", "chip.m1.beta"), True, 90), 1)
