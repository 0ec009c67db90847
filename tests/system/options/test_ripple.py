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


def test_a_ripple_moves_the_heads_spikes() -> None:
    still = Scenario(duration=1.0, seed=2)
    moved = replace(still, ripple=Ripple(50e-3, 300.0))
    one, again, other = (follow(s).log.spikes for s in (moved, moved, still))
    times = [[t for ping in found for t in ping] for found in (one, again, other)]
    assert times[0] == times[1]
    assert times[0] != times[2]
