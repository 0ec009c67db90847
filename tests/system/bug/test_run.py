"""Bug robots with a brain on the chip: from the command line, on dies, and in studies."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from pathlib import Path

import pytest

from chips.nef.chip import NefChip
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.bug.run import SYSTEM, built_network, built_on, run, summarise
from system.bug.scenario import Scenario
from system.cli.command_line import main

OPEN = ("--map", "bug-open", "--duration", "3s")


def test_bug_0_on_a_die_reaches_an_open_goal() -> None:
    trace = run(Scenario("bug0", "chip", map="bug-open", duration=30.0, die=Die(number=900)))
    assert trace.reached
    assert trace.chip is not None
    assert trace.chip["spikes"] > 1000
    assert trace.chip["dropped"] == 0
    assert summarise(trace)["path_ratio"] == pytest.approx(1.0, abs=0.1)


def test_a_die_is_the_same_again_and_another_is_not() -> None:
    def on(number: int) -> Scenario:
        return Scenario("bug0", "chip", map="bug-cup", duration=0.5, die=Die(number=number))

    kept = built_network(on(900))
    assert built_network(on(900)) is kept, "networks are built once"
    parts = kept.net, kept.chip, kept.noise, kept.drive, kept.bends
    before, path = pickle.dumps(parts), run(on(900)).path.tobytes()
    assert pickle.dumps(parts) == before, "a run changes nothing of them"
    assert path == run(on(900)).path.tobytes()
    assert path != run(on(1000)).path.tobytes()
    built_on.cache_clear()
    assert path == run(on(900)).path.tobytes(), "built anew it is the same"


def test_a_healed_die_runs_at_the_codes_of_the_die() -> None:
    die = Die(number=900)
    own = Scenario("bug0", "chip", map="bug-open", duration=0.02, die=die)
    healed = replace(own, die=die.healed("*"), coded_on=die)
    before, after = (built_network(each).where for each in (own, healed))
    assert before is not None
    assert after is not None
    assert after.chip.die == die.healed("*")
    assert after.biases == before.biases


def test_the_command_tells_what_the_chip_did(capsys: pytest.CaptureFixture[str]) -> None:
    options = ("--agent", "bug0", "--brain", "chip", "--die", "903", "--bias-kind", "ideal", "--json")
    assert main(["run", "bug", *OPEN, *options, "--temperature", "30", "--calibrated-at", "30"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["chip"]["spikes"] > 0
    assert (found["temperature_C"], found["calibrated_at_C"], found["bias_kind"]) == (30.0, 30.0, "ideal")
    assert found["neurons"] == 2050


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--temperature", "30"),
        ("--calibrated-at", "30"),
        ("--codes", "default"),
        ("--solved", "30"),
        ("--area", "2"),
        ("--die", "3"),
        ("--bias-kind", "ideal"),
    ],
)
def test_what_only_a_chip_has_is_refused_without_one(
    option: str, value: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "bug", "--brain", "ideal", *OPEN, option, value]) != 0
    assert f"{option}:" in capsys.readouterr().err


def test_a_study_runs_on_the_chip_and_resumes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    what = ("--param", "agent=bug0", "--param", "map=bug-open", "--duration", "1s")
    study = ("montecarlo", "bug", "--metric", "reached", "--first-die", "900", *what)
    where = ("-o", str(tmp_path / "study"), "--json")
    assert main([*study, "-n", "2", *where]) == 0
    first = json.loads(capsys.readouterr().out)
    assert main([*study, "-n", "2", *where, "--resume"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert first["metrics"] == again["metrics"]


def test_a_study_refuses_what_a_robot_has_not() -> None:
    with pytest.raises(ParameterError, match=r"obstacles: not an option of bug"):
        SYSTEM.study_options("behavioural", None, {"obstacles": "3"})
    with pytest.raises(ParameterError, match=r"level: transistor"):
        SYSTEM.study_options("transistor", None, {})


def test_on_the_chip_bug_2_has_the_design_whose_memories_hold_unless_told_otherwise() -> None:
    assert SYSTEM.on_silicon().design == "improved"
    assert SYSTEM.on_silicon(design="published").design == "published"
    for given in ({"brain": "ideal"}, {"brain": "reference"}, {"agent": "bug0"}, {"agent": "bug1"}):
        assert SYSTEM.on_silicon(**given).design == "published"
    assert SYSTEM.on_silicon(ideal=True).design == "published"


def test_a_run_of_the_published_bug_2_on_the_chip_says_what_drifts() -> None:
    ideal = run(Scenario("bug2", "ideal", neurons=300, map="bug-open", duration=0.02))
    chip = replace(ideal, scenario=Scenario("bug2", "chip", map="bug-open"))
    (said,) = SYSTEM.account(chip).cautions
    assert "drifts" in said
    better = replace(chip, scenario=replace(chip.scenario, design="improved"))
    assert SYSTEM.account(ideal).cautions == SYSTEM.account(better).cautions == ()


def test_more_neurons_than_the_chip_has_are_refused_before_it_is_calibrated(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def never(*_: object) -> None:
        raise AssertionError("calibrated")

    monkeypatch.setattr(NefChip, "at", never)
    with pytest.raises(
        ParameterError, match=r"neurons up to number \d+, the chip has 8192; take fewer neurons$"
    ):
        built_network(Scenario("bug2", "chip", neurons=20000))
    with pytest.raises(AssertionError, match="calibrated"):
        built_network(Scenario("bug2", "chip"))
