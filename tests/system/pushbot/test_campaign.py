"""Campaigns of the Pushbot: chips made once, files that go on, and what is kept."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.papers.conditions import IDEAL_CURRENTS
from system.pushbot import campaign as pushbot_campaign
from system.pushbot.campaign import (
    EVERY,
    Drive,
    Drives,
    Kept,
    Summary,
    _key,
    drive_cells,
    drive_each,
    mean_sd,
    summaries_of,
    trials,
)
from system.pushbot.run import Trace
from system.pushbot.scenario import Scenario, scene_of
from system.study.campaign import ALONE, Execution
from system.study.campaign_file import CutLine
from tests.documents import ROOT

QUIET = Scenario(silicon_noise="off")  # noise is of a seed, so that each run has a chip of its own
PLAN = trials(QUIET, 4, 2) + [replace(s, modified=True) for s in trials(QUIET, 2, 2)]


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
    cells, planned = ({"all": [Drive(s, kept) for s in each]} for each in (plan, PLAN))
    make = pushbot_campaign.make_brain
    return summaries_of(drive_cells(execution, "ours", cells, planned, lambda _: None, make))["all"]


def test_every_run_is_in_its_place_and_a_chip_is_made_once(made: list[Scenario]) -> None:
    found = driven()
    assert [s["seed"] for s in found] == [s.seed for s in PLAN]
    assert [s["chip"] for s in found] == [100 * s.modified + (s.die.number or 0) for s in PLAN]
    assert len(made) == 4
    assert drive_each(PLAN, kept, make=pushbot_campaign.make_brain) == found


def test_each_process_has_its_chip(made: list[Scenario]) -> None:
    driven(plan=[QUIET, replace(QUIET, process="coach-180"), replace(QUIET, seed=1)])
    assert [s.process for s in made] == ["coach-180", "rolls-180"]


def test_runs_are_put_into_their_cells() -> None:
    plan = {"few": [Drive(PLAN[3]), Drive(PLAN[0])], "none": [], "again": [Drive(PLAN[0])]}
    found = drive_cells(_Seeds(), "ours", plan, plan, lambda _: None)  # type: ignore[arg-type]
    assert {name: [d.summary["seed"] for d in each] for name, each in found.items()} == {
        "few": [PLAN[3].seed, PLAN[0].seed], "none": [], "again": [PLAN[0].seed],
    }  # fmt: skip


class _Seeds:
    """Answers with the seeds of the runs, without driving; each is asked for once."""

    def results(self, campaign: Any, keys: Any) -> Any:
        assert len(set(keys)) == len(keys)
        return (Kept({"seed": float(campaign.one.drives[key.drive][0].scenario.seed)}) for key in keys)


def test_an_interrupted_campaign_goes_on_at_the_run(made: list[Scenario], tmp_path: Path) -> None:
    whole, part = tmp_path / "whole.jsonl", tmp_path / "part.jsonl"
    expected = driven(Execution(whole))
    lines = whole.read_bytes().splitlines(keepends=True)
    assert len(lines) == 1 + len(PLAN)
    part.write_bytes(b"".join(lines[:3]) + lines[3][:20])  # killed while it wrote
    made.clear()
    with pytest.warns(CutLine, match="20 bytes"):
        assert driven(Execution(part, resume=True)) == expected
    assert part.read_bytes() == whole.read_bytes()
    assert len(made) == 3


def test_more_runs_lengthen_a_kept_file(made: list[Scenario], tmp_path: Path) -> None:
    file = tmp_path / "a.jsonl"
    driven(Execution(file), PLAN[:2])
    longer = [*PLAN, *trials(QUIET, 9, 3)[6:]]
    made.clear()
    assert driven(Execution(file, resume=True), longer) == driven(plan=longer)
    lines = file.read_text().splitlines()
    assert len(lines) == 1 + len(longer)
    assert driven(Execution(file, resume=True)) == driven()
    assert file.read_text().splitlines() == lines


@pytest.mark.usefixtures("made")
def test_a_campaign_that_was_planned_otherwise_is_another(tmp_path: Path) -> None:
    file = tmp_path / "a.jsonl"
    driven(Execution(file))
    other = {"all": [Drive(replace(s, dropped=0.5), kept) for s in PLAN]}
    with pytest.raises(ParameterError, match="not of this campaign, or has other numbers"):
        drive_cells(Execution(file, resume=True), "ours", other, other, lambda _: None)


@pytest.mark.usefixtures("made")
def test_paths_are_kept_where_they_are_asked_for(tmp_path: Path) -> None:
    cells = {"one": [Drive(PLAN[0], kept, with_path=True), Drive(PLAN[1], kept)]}
    make = pushbot_campaign.make_brain
    for execution in (Execution(tmp_path / "a.jsonl"), Execution(tmp_path / "a.jsonl", resume=True)):
        first, second = drive_cells(execution, "ours", cells, cells, lambda _: None, make)["one"]
        assert np.array_equal(first.path, [[0.0, 0.0], [1.2346, 0.0], [2.4691, 0.0]])
        assert second.path.shape == (0, 2)


@pytest.mark.usefixtures("made")
def test_progress_counts_runs() -> None:
    seen: list[float] = []
    cells = {"all": [Drive(s, kept) for s in PLAN]}
    drive_cells(ALONE, "ours", cells, cells, seen.append, pushbot_campaign.make_brain)
    assert seen == pytest.approx([k / 6 for k in range(1, 7)])


def test_other_processes_get_the_same_drive() -> None:
    drive = Drive(PLAN[0], kept, scene_of)
    copy = pickle.loads(pickle.dumps(Drives({"0": (drive, PLAN[0])})))
    assert repr(copy.drives["0"][0]) == repr(drive)
    assert "['kept', 'scene_of']" in repr(drive)


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


def test_a_kept_file_has_the_runs_that_its_experiment_asks_for() -> None:
    lines = (ROOT / "evidence" / "milde2017-table1.jsonl").read_text().splitlines()[1:]
    keys = {tuple(json.loads(line)["key"]) for line in lines}
    base = Scenario(colour="yellow", speed_factor=3.0, turn_factor=1.0, silicon_noise="off", **IDEAL_CURRENTS)
    asked = {_key(Drive(scenario)) for scenario in trials(base, 20, 10)}
    assert asked <= keys
    # what is asked for besides is another run
    assert _key(Drive(replace(trials(base, 1, 1)[0], course=((0.0, 27.0), (1.0, 30.0))))) not in keys
