"""Noise of the ranging chip in a run of the approach: off unless asked for, chosen by the seed."""

import json
from collections.abc import Callable
from typing import Any

import pytest

from system.command_line import main

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
