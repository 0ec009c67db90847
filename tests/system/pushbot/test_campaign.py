"""Campaigns of the Pushbot: chips made once, files that go on, and what is kept."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.pushbot import campaign as pushbot_campaign
from system.pushbot.campaign import EVERY, Chips, Drive, Summary, drive_all, drive_each, mean_sd, trials
from system.pushbot.run import Scenario, Trace, scene_of
from system.study.campaign import ALONE, Execution
from system.study.campaign_file import CutLine

PLAN = trials(Scenario(), 4, 2) + [replace(s, modified=True) for s in trials(Scenario(), 2, 2)]


def kept(trace: Trace) -> Summary:
    return {"seed": float(trace.scenario.seed), "chip": float(trace.brain.synapses), "none": None}


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[Scenario]:
    """Scenarios whose chip was made, by numbers that stand for the chips; runs that go nowhere."""
    asked: list[Scenario] = []

    def make(scenario: Scenario) -> Any:
        asked.append(scenario)
        return SimpleNamespace(synapses=100 * int(scenario.modified) + (scenario.die.number or 0))

    def run(brain: Any, scenario: Scenario, *_: object) -> Any:
        path = [(5e-3 * k, 0.123456 * k, 0.0, 0.0) for k in range(2 * EVERY + 1)]
        return SimpleNamespace(scenario=scenario, brain=brain, drive=SimpleNamespace(path=path))

    monkeypatch.setattr(pushbot_campaign, "make_brain", make)
    monkeypatch.setattr(pushbot_campaign, "run_with", run)
    return asked


def driven(execution: Execution = ALONE, plan: list[Scenario] = PLAN) -> list[Summary]:
    drives = [Drive(s, kept) for s in plan]
    return [d.summary for d in drive_all(execution, "ours", drives, make=pushbot_campaign.make_brain)]


def test_every_run_is_in_its_place_and_a_chip_is_made_once(made: list[Scenario]) -> None:
    found = driven()
    assert [s["seed"] for s in found] == [s.seed for s in PLAN]
    assert [s["chip"] for s in found] == [100 * s.modified + (s.die.number or 0) for s in PLAN]
    assert len(made) == 4
    assert drive_each(PLAN, kept, make=pushbot_campaign.make_brain) == found


def test_an_interrupted_campaign_goes_on_at_the_chip(made: list[Scenario], tmp_path: Path) -> None:
    whole, part = tmp_path / "whole.jsonl", tmp_path / "part.jsonl"
    expected = driven(Execution(whole))
    lines = whole.read_bytes().splitlines(keepends=True)
    assert len(lines) == 1 + 4
    part.write_bytes(b"".join(lines[:3]) + lines[3][:20])  # killed while it wrote the third chip
    made.clear()
    with pytest.warns(CutLine, match="20 bytes"):
        assert driven(Execution(part, resume=True)) == expected
    assert part.read_bytes() == whole.read_bytes()
    assert len(made) == 2


@pytest.mark.usefixtures("made")
def test_another_plan_is_another_campaign(tmp_path: Path) -> None:
    file = tmp_path / "a.jsonl"
    driven(Execution(file))
    for plan in (PLAN[:-1], [replace(s, dropped=0.5) for s in PLAN]):
        with pytest.raises(ParameterError, match="not of this campaign, or has other numbers"):
            driven(Execution(file, resume=True), plan)


@pytest.mark.usefixtures("made")
def test_paths_are_kept_where_they_are_asked_for(tmp_path: Path) -> None:
    drives = [Drive(PLAN[0], kept, with_path=True), Drive(PLAN[1], kept)]
    for execution in (Execution(tmp_path / "a.jsonl"), Execution(tmp_path / "a.jsonl", resume=True)):
        first, second = drive_all(execution, "ours", drives, make=pushbot_campaign.make_brain)
        assert np.array_equal(first.path, [[0.0, 0.0], [1.2346, 0.0], [2.4691, 0.0]])
        assert second.path.shape == (0, 2)


def test_progress_counts_runs(made: list[Scenario]) -> None:
    seen: list[float] = []
    drive_all(ALONE, "ours", [Drive(s, kept) for s in PLAN], seen.append, pushbot_campaign.make_brain)
    assert seen == pytest.approx([2 / 6, 3 / 6, 5 / 6, 1.0])
    assert len(made) == len(seen)


def test_other_processes_get_the_same_drive() -> None:
    chips = Chips(((Drive(PLAN[0], kept, scene_of),),))
    copy = pickle.loads(pickle.dumps(chips))
    assert repr(copy.drives) == repr(chips.drives)
    assert "['kept', 'scene_of']" in repr(copy.drives)


def test_no_run_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"^campaign: 0 runs on 2 dies"):
        trials(Scenario(), 0, 2)


def test_dies_come_again_and_seeds_do_not() -> None:
    plan = trials(Scenario(), 5, 2, first=900)
    assert [s.seed for s in plan] == [900, 901, 902, 903, 904]
    assert {s.die for s in plan} == {Die(number=900), Die(number=901)}


def test_what_is_not_defined_is_in_no_mean() -> None:
    found: list[Summary] = [{"a": 1.0}, {"a": None}, {"a": 3.0}]
    mean, deviation, count = mean_sd(found, "a")
    assert (mean, deviation, count) == (2.0, pytest.approx(2.0**0.5), 2)
    assert np.isnan(mean_sd([], "a")[0])
