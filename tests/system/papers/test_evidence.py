"""Campaign files that are kept: of the present numbers, and what is flown again is what they say."""

import json
import shutil
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from circuits.errors import ParameterError
from system.papers.checks import blame, latency_forests, mission_yield, random_circuits, ranging_law
from system.papers.checks.beside import Condition
from system.papers.conditions import IDEAL_CURRENTS
from system.papers.milde2017 import table1 as milde2017_table1
from system.pushbot import campaign as pushbot_campaign
from system.pushbot.campaign import Drive, drive_again, trials
from system.pushbot.run import summarise
from system.pushbot.scenario import Scenario
from system.registry import load_experiment
from system.study.campaign import Execution, Numbered

EVIDENCE = Path(__file__).parents[3] / "evidence"
FORESTS = EVIDENCE / "latency-forests.jsonl"


def kept() -> dict[Numbered, Any]:
    _, *lines = FORESTS.read_text().splitlines()
    rows = [json.loads(line) for line in lines]
    return {(str(row["key"][0]), int(row["key"][1])): row["found"] for row in rows}


@pytest.mark.parametrize("key", [("analog", 1006), ("chip", 1006)])
def test_a_flight_flown_again_is_the_one_that_is_kept(key: Numbered) -> None:
    assert asdict(latency_forests.fly_one(key)) == kept()[key]


def test_the_flights_that_are_kept_are_of_the_present_numbers_and_reported(tmp_path: Path) -> None:
    # a file of other numbers would be refused, and a flight that is missing would be flown and added
    copy = tmp_path / FORESTS.name
    shutil.copy(FORESTS, copy)
    network = sum(model == "network" for model, _ in kept())
    assert network == latency_forests.FORESTS
    report = latency_forests.reproduce(
        lambda _: None, Execution(file=copy, resume=True), forests=latency_forests.FORESTS, network=network
    )
    assert copy.read_bytes() == FORESTS.read_bytes()
    assert [row.name for row in report.rows][:2] == [
        "network_four_crossings_share", "chip_four_crossings_share",
    ]  # fmt: skip
    assert f"network: {network} flights" in report.notes[4]


def test_the_yield_that_is_kept_is_of_the_present_robots_and_reported(tmp_path: Path) -> None:
    kept_file = EVIDENCE / "mission-yield.jsonl"
    copy = tmp_path / kept_file.name
    shutil.copy(kept_file, copy)
    report = mission_yield.reproduce(lambda _: None, Execution(file=copy, resume=True))
    assert copy.read_bytes() == kept_file.read_bytes()
    assert tuple(null.name for null in report.nulls) == load_experiment("mission-yield").nulls
    key = Numbered("rover, 37 degC", mission_yield.FIRST)
    found = [json.loads(line) for line in kept_file.read_text().splitlines()[1:]]
    again = asdict(mission_yield.run_one(key))
    assert [each["found"] for each in found if tuple(each["key"]) == key] == [again]


def test_the_dies_that_were_blamed_are_of_the_present_options_and_reported(tmp_path: Path) -> None:
    kept_file = EVIDENCE / "blame.jsonl"
    copy = tmp_path / kept_file.name
    shutil.copy(kept_file, copy)
    report = blame.reproduce(lambda _: None, Execution(file=copy, resume=True))
    assert copy.read_bytes() == kept_file.read_bytes()
    assert {*report.disagreeing} == {"mended_by_1", "mended_by_7", "mended_by_10"}
    key = Numbered(blame.DIE, 1015)  # on which the sonar succeeds
    found = [json.loads(line) for line in kept_file.read_text().splitlines()[1:]]
    again = asdict(blame.run_one(key))
    assert [each["found"] | {"named": ()} for each in found if tuple(each["key"]) == key] == [again]


def test_the_drives_that_are_kept_are_of_the_present_codes_and_reported(tmp_path: Path) -> None:
    copy = tmp_path / "milde2017-table1.jsonl"
    shutil.copy(EVIDENCE / copy.name, copy)
    table = load_experiment("milde2017-table1")
    report = table.run(lambda _: None, Execution(file=copy, resume=True))
    assert len(report.disagreeing) == 5  # all are fitted rows
    assert tuple(null.name for null in report.nulls) == table.nulls
    assert [score.beaten for score in report.scores if score.p is not None] == [True, True, False]
    assert "show nothing above" in report.said[0]
    assert copy.read_bytes() == (EVIDENCE / copy.name).read_bytes()


@pytest.mark.parametrize(
    "number",
    [
        "CODES", "MODIFIED", "EVENTS", "RATES", "TURN_EVENTS", "TURN_RATE", "MODIFIED_LEVELS",
        "MODIFIED_EVENTS", "MODIFIED_RATES", "GYRO_ANGLE", "COLOURS",
    ],
)  # fmt: skip
def test_drives_with_other_codes_or_colours_are_refused(
    number: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = tmp_path / "milde2017-table1.jsonl"
    shutil.copy(EVIDENCE / copy.name, copy)
    monkeypatch.setattr(pushbot_campaign, number, {})
    with pytest.raises(ParameterError, match="other numbers"):
        load_experiment("milde2017-table1").run(lambda _: None, Execution(file=copy, resume=True))


def test_the_random_circuits_that_are_kept_are_of_the_present_solver_and_agree(tmp_path: Path) -> None:
    copy = tmp_path / "random-circuits.jsonl"
    shutil.copy(EVIDENCE / copy.name, copy)
    report = load_experiment("random-circuits").run(lambda _: None, Execution(file=copy, resume=True))
    assert copy.read_bytes() == (EVIDENCE / copy.name).read_bytes()
    assert report.agrees
    kept = json.loads(copy.read_text().splitlines()[1])["found"]
    again = asdict(random_circuits.beside(Numbered("circuit", kept["number"])))
    assert again["devices"] == kept["devices"]
    # far below what is allowed, and far above what another machine's rounding does
    assert again["point"] == pytest.approx(kept["point"], abs=1e-6)
    assert again["edge"] == pytest.approx(kept["edge"], abs=1e-5)


def test_cases_beside_transistors_that_are_kept_are_of_the_present_records(tmp_path: Path) -> None:
    for name in ("ranging-law", "latency-law", "choice-law"):
        kept_file = EVIDENCE / f"{name}.jsonl"
        copy = tmp_path / kept_file.name
        shutil.copy(kept_file, copy)
        report = load_experiment(name).run(lambda _: None, Execution(file=copy, resume=True), dies=84)
        assert copy.read_bytes() == kept_file.read_bytes()
        assert report.rows[0].ours == 6.0 * 84
    kept = json.loads((EVIDENCE / "ranging-law.jsonl").read_text().splitlines()[1])
    again = ranging_law.beside(Condition(*kept["key"]))
    assert (again.circuit, again.model) == (kept["found"]["circuit"], kept["found"]["model"])
    assert again.t_inh == pytest.approx(kept["found"]["t_inh"], rel=1e-6)


def test_a_drive_driven_again_is_the_one_that_is_kept() -> None:
    _, *lines = (EVIDENCE / "milde2017-table1.jsonl").read_text().splitlines()
    # the fastest cell, whose drives are the shortest; a die has two drives in each
    speed, turn = milde2017_table1.CELLS[-1]
    scenario, *_ = trials(
        Scenario(colour="blue", speed_factor=speed, turn_factor=turn, silicon_noise="off", **IDEAL_CURRENTS),
        1,
    )
    row = json.loads(lines[2 * (len(milde2017_table1.CELLS) - 1)])
    assert row["key"][0] == f"die {scenario.die.number}"
    assert summarise(drive_again(Drive(scenario))) == row["found"]["summary"]
