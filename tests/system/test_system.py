"""The contract of a system, over the registry: every one of them says how a run went in the same words."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import Any

import pytest
from matplotlib.figure import Figure

from circuits.silicon.die import Die
from system.cli import run as cli_run
from system.cli.command_line import main
from system.forest.scenario import Scenario
from system.openspace.senses import Sensing
from system.papers.conditions import FIXED_GATES
from system.registry import SYSTEMS, load_system
from system.system import ENTRIES, METRICS, Account, headline, summary_of

# options of a short run of each
SHORT: dict[str, dict[str, Any]] = {
    "approach": {"level": "behavioural", "duration": 1.2},
    "rover": {"goal": (4, 10)},
    "forest": {"pings": 60},
    "spiking-bat": {"pings": 2},
    "car": {"pings": 20},
    "head": {"duration": 2.0},
    "bug": {"map": "bug-open", "duration": 4.0},
    "pushbot": {"duration": 0.4},
    "rolls": {"duration": 0.2},
}


@cache
def traced(name: str) -> Any:
    system = load_system(name)
    return system.run(system.scenario(**SHORT[name]))


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_summary_begins_with_the_runs_account(name: str) -> None:
    system = load_system(name)
    found = system.summarise(traced(name))
    assert tuple(found)[: len(ENTRIES)] == tuple(ENTRIES)
    assert isinstance(found["succeeded"], bool)
    assert found["reason"]
    assert "\n" not in found["reason"]
    for entry in ("emergency_share", "standing_share"):
        assert found[entry] is None or 0.0 <= found[entry] <= 1.0
    assert found["ran_on"]
    assert system.success


@pytest.mark.parametrize("name", SYSTEMS)
def test_what_a_study_can_ask_for_is_a_number_of_the_summary(name: str) -> None:
    system = load_system(name)
    assert set(METRICS) <= set(system.metrics)
    assert set(system.study_metrics) <= set(system.metrics)
    found = system.summarise(traced(name))
    for metric in system.metrics:
        assert found[metric] is None or float(found[metric]) == found[metric]
    assert "succeeded" in system.yes_no
    assert set(system.yes_no) <= set(system.metrics)
    assert {found[metric] for metric in system.yes_no} <= {0.0, 1.0}


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_picture_has_the_reason(name: str) -> None:
    system, figure = load_system(name), Figure()
    system.draw(traced(name), figure)
    titles = [ax.get_title() for ax in figure.axes] + [figure.get_suptitle()]
    assert any(system.account(traced(name)).headline in title for title in titles)


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_system_has_a_command_of_its_own(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", name, "--help"]) == 0
    assert f"run {name} " in capsys.readouterr().out


def test_an_account_in_a_line() -> None:
    account = Account(succeeded=False, reason="collided with a pipe", ran_on={"ranges": "exact"})
    assert account.headline == "failed: collided with a pipe"
    assert summary_of(account, {"pings": 3.0})["pings"] == 3.0


def test_turning_round_again_and_again_is_no_success() -> None:
    system = load_system("forest")
    sensing = Sensing(ranges="chip", selection="chip")
    scenario = Scenario(sensing=sensing, die=Die(number=1003), pings=500, escape=0, **FIXED_GATES)
    found = system.summarise(system.run(scenario))
    assert (found["succeeded"], found["emergency_share"], found["collided"]) == (False, 1.0, 0.0)
    assert found["distance_m"] == pytest.approx(200.0)  # 100 s at 2 m/s, to and fro
    assert found["progress_m"] == pytest.approx(0.0, abs=1.0)
    assert found["reason"] == "all 500 pings flown"
    assert (found["ran_on"]["ranges"], found["ran_on"]["die"]) == ("chip", 1003)


def test_a_robot_that_stands_touches_nothing_and_fails() -> None:
    system = load_system("pushbot")
    found = system.summarise(
        system.run(system.scenario(scene="clutter", speed_factor=0.02, duration=2.0, silicon_noise="off"))
    )
    assert (found["collided"], found["succeeded"]) == (0.0, False)
    assert found["standing_share"] > 0.5
    assert found["reason"] == "time of 2 s over"


@pytest.mark.usefixtures("unmeasured_power")
@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("forest", ("--pings", "40")),
        ("spiking-bat", ("--pings", "3")),
        ("car", ("--pings", "9", "--ranges", "exact")),
        ("bug", ("--map", "bug-open", "--duration", "2s", "--codes", "default", "--neurons", "500")),
        ("rover", ("--goal", "4,10")),
        ("head", ("--duration", "1s")),
        ("pushbot", ("--duration", "200ms")),
        ("approach", ("--level", "behavioural", "--duration", "300ms")),
        ("rolls", ("--duration", "150ms", "--die", "1003", "--codes", "default")),
    ],
)
def test_text_and_document_give_the_same_reason(
    name: str,
    options: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    system, made = load_system(name), []

    def once(*given: Any) -> Any:
        if not made:
            made.append(system.run(*given))
        return made[0]

    monkeypatch.setattr(cli_run, "load_system", lambda _: replace(system, run=once))
    assert main(["run", name, *options]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert main(["run", name, *options, "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)["summary"]
    assert headline(succeeded=summary["succeeded"], reason=summary["reason"]) in lines
    assert sum(line.startswith(("succeeded: ", "failed: ")) for line in lines) == 1
