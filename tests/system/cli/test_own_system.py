"""A system of a user's own: a package with an entry point is used as the shipped systems are."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.refusals import command_refusals
from tests.system.conftest import Run

CODE = '''
from dataclasses import dataclass

import numpy as np

from system.option import option
from system.options.on_silicon import OnSilicon
from system.system import SUCCEEDED, Account, System, metrics_with


@dataclass(frozen=True, slots=True)
class Scenario(OnSilicon):
    """A walk."""

    pace: float = option(1.0, "Of its walk", unit="m/s", above=0.0, below=3.0, study=True)
    gait: str = option("walk", "How it goes", choices=("walk", "trot"))
    load: bool = option(default=False, about="Whether it carries something")


@dataclass(frozen=True, slots=True)
class Trace:
    """A walk's way, m."""

    scenario: Scenario
    way: float


def run(scenario, progress=None):
    number = 0 if scenario.die.number is None else scenario.die.number
    return Trace(scenario, scenario.pace * (1.0 + np.random.default_rng((number, scenario.seed)).uniform()))


def account(trace):
    return Account(succeeded=trace.way > 0.0, reason="done", ran_on={"gait": trace.scenario.gait})


SYSTEM = System(
    name="walker",
    summary="something that walks",
    success="it gets on",
    kind=Scenario,
    run=run,
    account=account,
    numbers=lambda trace: {"way_m": trace.way},
    draw=lambda trace, figure: figure.suptitle(account(trace).headline),
    metrics=metrics_with(("way_m",)),
    study_metrics=("way_m",),
    title=lambda trace: trace.scenario.gait,
)
'''


@pytest.fixture(autouse=True)
def _installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package with two entry points: `walker`, and one that is no system."""
    (tmp_path / "own_walker.py").write_text(CODE)
    info = tmp_path / "own_walker-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: own-walker\nVersion: 1.0\n")
    points = ("[noctule.systems]", "walker = own_walker:SYSTEM", "stone = own_walker:account")
    (info / "entry_points.txt").write_text("\n".join(points))
    monkeypatch.syspath_prepend(tmp_path)


def test_its_help_has_its_own_options_and_no_others(run: Run) -> None:
    status, out, _ = run("run", "walker", "--help")
    assert status == 0
    assert all(
        word in out for word in ("--pace SPEED", "1m/s", "--gait walk|trot", "--load", "--no-load", "--die")
    )
    assert all(word not in out for word in ("--targets", "--amplitude-law", "--cells"))


def test_the_list_of_systems_has_its_line(run: Run) -> None:
    status, out, err = run("run", "--help")
    assert (status, err) == (0, "")
    assert "walker       Something that walks.\n" in out
    assert "stone        Cannot be loaded: noctule.systems.stone:" in out


def test_it_runs_without_options_and_with_its_own(run: Run, tmp_path: Path) -> None:
    status, out, err = run("run", "walker")
    assert (status, err) == (0, "")
    assert "succeeded: done" in out
    picture = tmp_path / "walk.png"
    options = (
        "--pace",
        "2m/s",
        "--gait",
        "trot",
        "--load",
        "--seed",
        "3",
        "--die",
        "5",
        "--plot",
        str(picture),
    )
    found = json.loads(run("run", "walker", *options, "--json")[1])
    assert (found["system"], found["pace_m_per_s"], found["gait"], found["load"]) == (
        "walker",
        2.0,
        "trot",
        True,
    )
    assert (found["seed"], found["die"], found["temperature_C"]) == (3, 5, 27.0)
    assert 2.0 <= found["summary"]["way_m"] < 4.0
    assert picture.stat().st_size > 1000


test_what_is_wrong_with_its_options_is_one_line = command_refusals(
    "run",
    "walker",
    rows=[
        ("--pace 9m/s", "--pace: 9 m/s, must be > 0 and < 3"),
        ("--pace 2", "--pace: "),
        ("--gait fly", "--gait: fly, must be walk or trot"),
        ("--targets a.csv", "No such option: --targets"),
        ("--seed -1", "--seed: -1, must be >= 0"),
    ],
)


def test_it_is_studied_over_dies(run: Run) -> None:
    study = ("montecarlo", "walker", "-n", "4", "--threads", "1", "--param", "pace=2m/s", "--json")
    status, out, err = run(*study)
    assert (status, err) == (0, "")
    found = json.loads(out)
    assert found["failed"] == []
    assert run("montecarlo", "walker", "-n", "1", "--param", "gait=trot")[0] == 2
    assert "--param pace: 9 m/s, must be" in run("montecarlo", "walker", "-n", "1", "--param", "pace=9m/s")[2]


def test_its_name_is_suggested(run: Run) -> None:
    assert "did you mean walker" in run("run", "walkr")[2]


def test_an_entry_point_that_is_no_system_is_said(run: Run) -> None:
    status, _, err = run("run", "stone")
    assert (status, err.count("\n")) == (2, 1)
    assert "noctule.systems.stone: own_walker:account is of type function" in err
    assert "must be a System" in err


def test_old_names_are_answered_with_the_new_ones(run: Run) -> None:
    for verb in ("run", "montecarlo"):
        status, _, err = run(verb, "robot")
        assert (status, err.count("\n")) == (2, 1)
        assert "robot: is called car" in err
