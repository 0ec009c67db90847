"""A ripple of the supply in a run: what is asked for, what says so, and where it is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from circuits.errors import ParameterError
from circuits.generator.ripple import Ripple
from system.cli.command_line import main
from system.head.run import run as follow
from system.head.scenario import Scenario
from system.options.noise import check_ripple, read_ripple, silicon_noise
from system.registry import load_system

RUN = ["run", "head", "--duration", "0.5s", "--json"]


@pytest.fixture
def document(capsys: pytest.CaptureFixture[str]) -> Callable[..., Any]:
    def run(*options: str) -> Any:
        assert main([*RUN, *options]) == 0
        return json.loads(capsys.readouterr().out)

    return run


def test_a_run_says_its_ripple(document: Callable[..., Any]) -> None:
    found = document("--ripple", "10mV@50Hz")
    assert found["ripple"] == found["summary"]["ran_on"]["ripple"] == "10 mV at 50 Hz"
    assert document()["ripple"] is None


def test_a_text_is_volts_and_hertz() -> None:
    assert read_ripple("10mV@50Hz", "ripple") == Ripple(10e-3, 50.0)
    for text in ("10mV", "10@50", "50Hz@10mV", "-1mV@50Hz", "1mV@0Hz"):
        with pytest.raises(ParameterError, match="ripple"):
            read_ripple(text, "ripple")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--bias-kind", "gate"), "biases of kind gate have no supply; take bias_kind generator"),
        (("--bias-kind", "ideal"), "biases of kind ideal have no supply"),
        (("--silicon-noise", "off"), "comes with the chip's noise, which is off"),
    ],
)
def test_a_ripple_that_nothing_has_is_refused(
    options: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "head", "--ripple", "10mV@50Hz", *options]) == 2
    assert words in capsys.readouterr().err
    assert silicon_noise("all", 3, Ripple(1e-2, 50.0)) is not None
    check_ripple(None, "gate", "off")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            ("approach",),
            "the ranging chip is at transistor level, where the supply stands; give --level behav",
        ),
        (
            ("approach", "--level", "behavioural", "--transistors", "chip"),
            "the ranging chip is at transistor",
        ),
        (
            ("forest", "--ranges", "exact", "--selection", "chip"),
            "moves both sides of what the selection compares alike; give --ran",
        ),
    ],
)
def test_a_ripple_of_which_nothing_in_the_run_follows_is_refused(
    options: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", *options, "--ripple", "10mV@50Hz"]) == 2
    assert words in capsys.readouterr().err


def test_a_study_has_a_ripple_as_a_text(capsys: pytest.CaptureFixture[str]) -> None:
    system, asked = load_system("head"), "10.1mV@50.3Hz"
    for given in (asked, Ripple(10.1e-3, 50.3)):
        options = system.study_options("behavioural", None, {"ripple": given})
        assert isinstance(options["ripple"], str)
        assert system.scenario(**options).ripple == Ripple(10.1e-3, 50.3)
    study = ["montecarlo", "head", "-n", "1", "--param", "duration=0.3s", "--param", f"ripple={asked}"]
    assert main([*study, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["failed"] == []
    assert found["options"] == ["duration=0.3", "ripple=0.0101V@50.3Hz"]
    assert main([*study, "--param", "ripple=10mV@50Hzz"]) == 2


def test_python_takes_the_text_of_a_ripple() -> None:
    assert load_system("head").scenario(ripple="10mV@50Hz").ripple == Ripple(10e-3, 50.0)
    with pytest.raises(ParameterError, match='ripple: "10mV", must be VOLTS@HERTZ'):
        load_system("head").scenario(ripple="10mV")
    with pytest.raises(ParameterError, match=r"head.scenario.ripple: 3, must be a Ripple"):
        load_system("head").scenario(ripple=3)


def test_a_ripple_moves_the_heads_spikes() -> None:
    still = Scenario(duration=1.0, seed=2)
    moved = replace(still, ripple=Ripple(50e-3, 300.0))
    one, again, other = (follow(s).log.spikes for s in (moved, moved, still))
    times = [[t for ping in found for t in ping] for found in (one, again, other)]
    assert times[0] == times[1]
    assert times[0] != times[2]
