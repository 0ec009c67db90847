"""`noctule run spiking-bat`: one JSON document, a table, and one line for whatever is wrong."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from system.cli.command_line import main

CHIP = ("--brain", "chip")
SPIKES = ("--brain", "network")
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    def call(*arguments: str) -> tuple[int, str, str]:
        status = main(("run", "spiking-bat", *arguments))
        return status, *capsys.readouterr()

    return call


def test_the_document_of_a_flight_by_spikes(run: Run, tmp_path: Path) -> None:
    picture = tmp_path / "path.png"
    options = ("--brain", "network", "--seed", "1003", "--pings", "3", "--start", "25m,25m", "--map")
    path = tmp_path / "wood.csv"
    path.write_text("x_m,y_m\n10,10\n")
    status, out, err = run(*options, str(path), "--plot", str(picture), "--json")
    assert (status, err) == (0, "")
    found = json.loads(out, parse_constant=pytest.fail)
    assert (found["brain"], found["ping_rate_Hz"], found["paths"], found["taps"]) == (
        "network", 10.0, 33, 15,
    )  # fmt: skip
    assert (found["summary"]["pings"], found["ended"]) == (3.0, "all 3 pings flown")
    # nothing is in the way to the goal: straight left at 2 m/s for 0.3 s; arcs beside the middle one win with
    # it, whose speed is up to 5 % less, 0.03 m
    assert found["path_m"][-1] == pytest.approx([24.4, 25.0], abs=0.03)
    assert len(found["path_m"]) == len(found["time_s"]) + 1
    assert picture.stat().st_size > 5_000


def test_the_document_of_a_chips_flight(run: Run) -> None:
    options = ("--brain", "chip", "--die", "1003", "--bias-kind", "generator", "--unit", "16,5")
    status, out, err = run(*options, "--pings", "3", "--temperature", "30", "--json")
    assert (status, err) == (0, "")
    found = json.loads(out, parse_constant=pytest.fail)
    assert (found["die"], found["temperature_C"], found["bias_kind"], found["codes"]) == (
        1003, 30.0, "generator", "usual",
    )  # fmt: skip
    assert found["transistor_units"] == [[16, 5]]
    assert found["summary"]["overflowed"] == 0.0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((*SPIKES, "--paths", "15"), "--paths: 15 memories, must be 33"),
        (
            (*SPIKES, "--taps", "13"),
            "--taps: 13, a delay line of 39 ms, must reach the longest",
        ),
        ((*SPIKES, "--taps", "0"), "--taps: 0, must be a whole number from 1 to 64"),
        ((*SPIKES, "--ping-rate", "40Hz"), "a period of 25 ms is shorter than the longest echo, 29.2 ms"),
        ((*SPIKES, "--ping-rate", "15Hz"), "the emergency neuron takes 68 ms"),
        ((*SPIKES, "--ping-rate", "5Hz"), "a period of 200 ms is longer than a memory lasts"),
        ((*SPIKES, "--ranges", "chip"), "No such option: --ranges"),
        ((*SPIKES, "--die", "3"), "--die: die A/3, no chip is in the loop; add --brain chip"),
        ((*SPIKES, "--codes", "usual"), "--codes: no chip is in the loop; add --brain chip"),
        ((*CHIP, "--unit", "33,0"), "latency_chip.memory[33].unit[0]: not on a chip of 33 memories"),
        ((*CHIP, "--unit", "x"), '--unit: "x", must be MEMORY,UNIT'),
        ((*CHIP, "--paths", "15"), "--paths: 15 memories, must be 33"),
        ((*CHIP, "--ping-rate", "40Hz"), "a period of 25 ms is shorter than the longest echo"),
        ((*CHIP, "--temperature", "90"), "latency_chip.temperature: 90 degC, must be -10 to 65"),
        ((*CHIP, "--area", "0"), "latency_chip.area: 0 times"),
        ((*SPIKES, "--animate", "way.gif"), "No such option: --animate"),
    ],
)
def test_what_is_wrong_is_one_line(run: Run, arguments: tuple[str, ...], says: str) -> None:
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert says in err
    assert err.count("\n") == 1


def test_a_study_flies_a_forest_a_die(capsys: pytest.CaptureFixture[str]) -> None:
    study = ("montecarlo", "spiking-bat", "-n", "2", "--param", "pings=2", "--metric", "pings", "--json")
    assert main(study) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["failed"] == []
