"""`noctule run rover` and `noctule run`: one JSON document, tables, and one line for whatever is wrong."""

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
        status = main(("run", *arguments))
        return status, *capsys.readouterr()

    return call


def test_the_document(run: Run, tmp_path: Path) -> None:
    picture = tmp_path / "way.png"
    status, out, err = run(
        "rover", "--map", "map1-road-obstacles", "--start", "2,10", "--goal", "19,10", "--seed", "5",
        "--plot", str(picture), "--json",
    )  # fmt: skip
    assert (status, err) == (0, "")
    found = json.loads(out, parse_constant=pytest.fail)
    assert found["planned_path"][0] == [2, 10]
    assert found["planned_path"][-1] == [19, 10]
    assert len(found["planned_path"]) == found["summary"]["length"]
    assert found["summary"]["regret"] == 0.0
    assert found["summary"]["frechet_m"] > 0.0
    assert len(found["driven_path_m"]) == len(found["time_s"]) == len(found["gps_path_m"])
    assert (found["map"], found["planner"], found["cells"], found["seed"]) == (
        "map1-road-obstacles", "wave", "ideal", 5,
    )  # fmt: skip
    assert picture.stat().st_size > 10_000


def test_the_table(run: Run) -> None:
    status, out, err = run("rover", "--learn", "0.5", "--trips", "2", "--planner", "dijkstra")
    assert (status, err) == (0, "")
    assert "planned on map1-road-obstacles: 2,10 " in out
    assert "frechet_m" in out
    assert "map error" in out


def test_a_map_of_ones_own(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "yard.csv"
    path.write_text("1,9,1\n1,0,1\n1,1,1\n")
    _, out, _ = run("rover", "--map", str(path), "--start", "0,0", "--goal", "0,2", "--json")
    assert json.loads(out)["summary"]["cost"] == 5.0  # around the south; over the 9 it is 11


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("rover", "--start", "2"), '--start: "2", must be ROW,COLUMN from 0'),
        (("rover", "--goal", "2,-3"), '--goal: "2,-3", must be ROW,COLUMN'),
        (("rover", "--goal", "99,0"), "--goal: 99,0, must be in the map of 20 x 20"),
        (("rover", "--duration", "2s"), "No such option: --duration"),
        (("rover", "--isolation"), "No such option: --isolation"),
        (("approach", "--map", "map2"), "No such option: --map"),
        (("rover", "--learn", "0"), "--learn: 0, must be above 0"),
        (("rover", "--plot", "way.bmp"), "--plot: way.bmp, must end with"),
        (("rovr",), "system rovr: unknown; did you mean rover?"),
        (("rover", "--temperature", "200"), "200"),
        (("rover", "--temperature", "40"), "--temperature: 40.0, no chip is in the loop; add --cells chip"),
        (("rover", "--die", "3"), "--die: die A/3, no chip is in the loop"),
        (("rover", "--unit", "20us", "--cells", "ideal"), "--unit: 2e-05, no chip is in the loop"),
        (("rover", "--bias-kind", "generator"), "--bias-kind: generator, no chip is in the loop"),
    ],
)
def test_what_is_wrong_is_one_line(run: Run, arguments: tuple[str, ...], says: str) -> None:
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert err.startswith("noctule: ")
    assert says in err
    assert err.count("\n") == 1


def test_chips_are_named_with_their_silicon(run: Run) -> None:
    options = ("--cells", "chip", "--die", "1000", "--bias-kind", "generator", "--unit", "20us")
    status, out, _ = run("rover", *options, "--temperature", "40")
    assert status == 0
    assert "rover, wave on chip cells, 40 degC, die A/1000" in out
    found = json.loads(run("rover", *options, "--json")[1])
    assert (found["cells"], found["die"], found["bias_kind"], found["unit_s"]) == (
        "chip",
        1000,
        "generator",
        2e-5,
    )


def test_a_study_of_the_rover(capsys: pytest.CaptureFixture[str]) -> None:
    route = [f"--param={text}" for text in ("map=map2", "start=16,3", "goal=10,10", "unit=10us")]
    assert (
        main(("montecarlo", "rover", "-n", "3", *route, "--metric", "cost", "--metric", "regret", "--json"))
        == 0
    )
    values = json.loads(capsys.readouterr().out)["values"]
    assert [c - r for c, r in zip(values["cost"], values["regret"], strict=True)] == [24.0] * 3
