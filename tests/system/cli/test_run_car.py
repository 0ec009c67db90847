"""`noctule run car`: one JSON document, a table, and one line for whatever is wrong."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from system.cli.command_line import main

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    def call(*arguments: str) -> tuple[int, str, str]:
        status = main(("run", "car", *arguments))
        return status, *capsys.readouterr()

    return call


def test_the_document(run: Run, tmp_path: Path) -> None:
    picture = tmp_path / "way.png"
    options = ("--forest", "open", "--seed", "1003", "--pings", "40", "--vmax", "0.1m/s", "--no-multipath")
    status, out, err = run(*options, "--plot", str(picture), "--json")
    assert (status, err) == (0, "")
    found = json.loads(out, parse_constant=pytest.fail)
    assert (found["forest"], found["ranges"], found["seed"], found["max_speed_m_per_s"]) == (
        "open", "flight", 1003, 0.1,
    )  # fmt: skip
    assert (found["occlusion"], found["multipath"], found["soft_pings"]) == (True, False, True)
    assert (len(found["pipes_m"]), len(found["steering_deg"])) == (21, 15)
    assert len(found["path_m"]) == len(found["time_s"]) + 1 == 41
    assert found["path_m"][0] == found["start_m"]
    assert found["summary"]["pings"] == 40.0
    assert "die" not in found
    assert picture.stat().st_size > 10_000


def test_the_document_with_a_chip(run: Run) -> None:
    options = ("--ranges", "chip", "--die", "1003", "--temperature", "30", "--no-process", "--pings", "5")
    status, out, err = run(*options, "--reader", "calibrated", "--json")
    assert (status, err) == (0, "")
    found = json.loads(out, parse_constant=pytest.fail)
    assert (found["die"], found["temperature_C"], found["reader"]) == (1003, 30.0, "calibrated")
    assert found["unsure_delays"] >= 0


def test_the_table(run: Run) -> None:
    status, out, err = run("--pings", "5", "--ranges", "exact")
    assert (status, err) == (0, "")
    assert "car, corridor, ranges exact" in out
    assert "failed: all 5 pings made" in out


def test_a_forest_of_ones_own(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "own.csv"
    path.write_text("x_m,y_m\n0.3,0.3\n0.3,-0.3\n0.9,0.3\n")
    options = ("--forest", str(path), "--ranges", "exact", "--plot", str(tmp_path / "way.png"))
    found = json.loads(run(*options, "--json")[1])
    assert found["pipes_m"] == [[0.3, 0.3], [0.3, -0.3], [0.9, 0.3]]
    assert found["summary"]["reason"] == "came through the forest"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--forest", "wood"), "--forest: wood, must be corridor, open or dense"),
        (("--start", "0m,0.45m"), "--start: 0,0.45, a pipe's surface is -0.025 m away"),
        (("--forest", "none.csv"), "none.csv: No such file or directory, must be a readable file"),
        (("--start", "here"), '--start: "here", must be X,Y; write as in --start 40m,25m'),
        (("--vmax", "0"), "--vmax: 0 m/s, must be > 0"),
        (("--ping-rate", "-12Hz"), "--ping-rate: -12 Hz, must be > 0"),
        (("--temperature", "60"), "--temperature: 60.0, no chip is in the loop"),
        (("--die", "3"), "--die: die A/3, no chip is in the loop"),
        (("--ranges", "exact", "--occlusion"), "--occlusion: not with --ranges exact"),
        (("--ranges", "sonar"), "--ranges: sonar, must be flight, exact or chip"),
        (("--plot", "way.bmp"), "--plot: way.bmp, must end with"),
        (("--pings", "0"), "--pings: 0, must be >= 1"),
    ],
)
def test_what_is_wrong_is_one_line(run: Run, arguments: tuple[str, ...], says: str) -> None:
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert err.startswith("noctule: ")
    assert says in err
    assert err.count("\n") == 1
