"""Blame of robots: rows of each by their rules, the null, and a campaign that goes on."""

from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.figure import Figure

from system.papers.checks import blame_robots
from system.papers.checks.blame import Outcome
from system.study.campaign import Numbered
from tests.system.papers.campaigns import goes_on


def outcome(key: Numbered) -> Outcome:
    """Of the bat every second die is not to blame; of the others one to three devices are named."""
    if key.condition == "spiking-bat" and key.number % 2:
        return Outcome(failing=True, trials=24)
    named = ("chip.m1.v_t0", "chip.m2.v_t0", "chip.m3.v_t0")[: 1 + key.number % 3]
    named = (*named, "chip.m1.beta")  # of a device that is named already
    return Outcome(True, True, named, key.condition != "pushbot", 250, 0, 5)


def test_rows_of_each_robot_and_the_null_mends_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blame_robots, "run_one", outcome)
    report = blame_robots.reproduce(lambda _: None, forest=5, bat=3, pushbot=2)
    rows = {row.name: row for row in report.rows}
    assert rows["forest_mended"].shown == "5 of 5 (48 to 100 %)"
    assert rows["forest_devices_for_80"].ours == 3.0  # of 5 dies the fourth in order: 1, 2, 2, 3, 3
    assert rows["pushbot_mended"].agrees is False
    assert rows["spiking_bat_most_trials"].agrees
    null = {row.name: row.agrees for row in report.nulls[0].rows}
    assert null["forest_mended"] is False
    report.draw(Figure())


def test_campaign_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blame_robots, "run_one", outcome)
    report = goes_on(
        lambda execution: blame_robots.reproduce(lambda _: None, execution, forest=1, bat=1, pushbot=0),
        lambda execution: blame_robots.reproduce(lambda _: None, execution, forest=2, bat=2, pushbot=0),
        tmp_path,
    )
    assert len(report.notes) == 4
