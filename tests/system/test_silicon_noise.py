"""Noise of a system's chips: off unless asked for, chosen by the seed."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from chips.rolls_chip_layout import ZETA
from circuits.errors import ParameterError
from system import pushbot
from system.arena_file import load_scene
from system.command_line import main
from system.pushbot_drive import begin_run
from system.pushbot_loop import open_loop
from system.rolls import SYSTEM, Scenario, run

RUN = ["run", "approach", "--level", "behavioural", "--duration", "1s", "--json"]


@pytest.fixture
def spikes(capsys: pytest.CaptureFixture[str]) -> Callable[..., list[Any]]:
    def run(*options: str) -> list[Any]:
        assert main([*RUN, *options]) == 0
        return [s["time_s"] for s in json.loads(capsys.readouterr().out)["spikes"]]

    return run


def test_another_seed_is_another_run_of_the_same_die(spikes: Callable[..., list[Any]]) -> None:
    plain = spikes("--die", "1001", "--seed", "1")
    assert spikes("--die", "1001", "--seed", "2", "--silicon-noise", "off") == plain
    noisy = spikes("--die", "1001", "--seed", "1", "--silicon-noise", "all")
    assert spikes("--die", "1001", "--seed", "1", "--silicon-noise", "all") == noisy
    others = [
        spikes("--die", "1001", "--seed", "2", "--silicon-noise", "all"),
        spikes("--die", "1001", "--seed", "1", "--silicon-noise", "white"),
        plain,
    ]
    assert all(other != noisy for other in others)
    # before the first call that differs by more than jitter, spikes move by tens of microseconds
    assert noisy[0] == pytest.approx(plain[0], abs=100e-6)


def test_a_rover_plans_anew_every_trip(capsys: pytest.CaptureFixture[str]) -> None:
    route = ["run", "rover", "--cells", "chip", "--die", "1003", "--trips", "6", "--json"]
    found = {}
    for noise in ("off", "all"):
        assert main([*route, "--silicon-noise", noise, "--seed", "5"]) == 0
        document = json.loads(capsys.readouterr().out)
        assert document["silicon_noise"] == noise
        found[noise] = [trip["planned_path"] for trip in document["trips"]]
    assert all(path == found["off"][0] for path in found["off"])
    # jitter of microseconds decides only where two ways are as close: the cost of the way stays
    assert all(path[0] == found["off"][0][0] for path in found["all"])


def test_a_pushbots_chip_has_noise_of_its_own() -> None:
    def spikes(**fields: Any) -> list[float]:
        brain = pushbot.make_brain(pushbot.Scenario(scene="pair", **fields))
        loop = open_loop(brain, begin_run(load_scene("pair", seed=3), seed=3), pushbot.Scenario().read())
        return [*loop.state.values[ZETA]]

    plain, noisy = spikes(), spikes(silicon_noise="all", noise_seed=1)
    assert spikes(silicon_noise="off", noise_seed=1) == plain
    assert spikes(silicon_noise="all", seed=1) == noisy
    assert plain != noisy != spikes(silicon_noise="all", noise_seed=2)


def test_rolls_rates_differ_with_the_seed_of_its_noise() -> None:
    quiet = Scenario(duration=0.2)
    found = [run(replace(quiet, silicon_noise=noise)).spikes.times for noise in ("off", "white", "all")]
    assert found[0].size != found[1].size or (found[0] != found[1]).any()
    assert found[1].size != found[2].size or (found[1] != found[2]).any()
    assert SYSTEM.study_options("behavioural", None, {"silicon_noise": "all"})["silicon_noise"] == "all"
    with pytest.raises(ParameterError, match="--silicon-noise: loud, must be off or white or all"):
        replace(quiet, silicon_noise="loud")


def test_ideal_cells_have_no_noise(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "rover", "--silicon-noise", "all"]) == 2
    assert "--silicon-noise: ideal cells have no silicon" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--level", "transistor", "--silicon-noise", "all"], "approach.silicon_noise: all, must be off"),
        (["--silicon-noise", "loud"], "--silicon-noise: loud, must be off or white or all"),
    ],
)
def test_what_has_no_noise_refuses_it(
    options: list[str], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*RUN, *options]) == 2
    assert text in capsys.readouterr().err
