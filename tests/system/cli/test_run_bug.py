"""`noctule run bug`: one JSON document, a table, a picture, and one line for whatever is wrong."""

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
        status = main(("run", "bug", *arguments))
        return status, *capsys.readouterr()

    return call


def test_the_document(run: Run, tmp_path: Path) -> None:
    picture = tmp_path / "way.png"
    status, out, err = run("--agent", "bug2", "--map", "bug-spiral", "--plot", str(picture), "--json")
    assert (status, err) == (0, "")
    found = json.loads(out, parse_constant=pytest.fail)
    assert found["reached"] is True
    assert found["ended"] == found["summary"]["reason"]
    assert found["ended"].startswith("goal reached after ")
    assert found["path"][0] == found["start"] == [2.5, 6.5]
    assert len(found["path"]) == len(found["state"]) + 1 == round(found["time_s"] / found["step_s"]) + 1
    assert set(found["state"]) == {"go", "follow"}
    assert found["summary"]["path_ratio"] > 1.0
    assert picture.stat().st_size > 10_000  # an empty figure has 3 kB


def test_neurons(run: Run) -> None:
    status, out, err = run(
        "--agent", "bug2", "--brain", "ideal", "--design", "improved", "--neurons", "3000", "--seed", "7",
        "--map", "bug-open", "--json",
    )  # fmt: skip
    assert (status, err) == (0, "")
    found = json.loads(out, parse_constant=pytest.fail)
    assert (found["reached"], found["design"], found["seed"]) == (True, "improved", 7)
    assert found["neurons"] == pytest.approx(3000, rel=0.02)  # rounding of every part
    assert found["state"][0] == "memorise"


def test_the_table_says_when_there_is_no_way(run: Run) -> None:
    status, out, err = run("--map", "bug-sealed", "--agent", "bug1")
    assert (status, err) == (0, "")
    assert "no way leads from the start to the goal" in out
    assert "unreachable after" in out


def test_a_map_of_ones_own(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "yard.txt"
    path.write_text("S    G\n  #   \n", encoding="utf-8")
    found = json.loads(run("--map", str(path), "--start", "0.5,0.5", "--goal", "0", "--json")[1])
    assert (found["map"], found["reached"], found["start"]) == ("yard", True, [0.5, 0.5])


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--agent", "bug3"), "--agent: bug3, must be bug0, bug1 or bug2"),
        (("--brain", "cortex"), "--brain: cortex, must be reference, ideal or chip"),
        (("--map", "bug-cop"), "did you mean bug-cup?"),
        (("--start", "1"), '--start: "1", must be a number from 0 to 0'),
        (("--start", "6.5,6.5"), "--start: 6.5,6.5, a wall is 0 away, must be at least the robot's radius"),
        (("--goal", "30,3"), "--goal: 30,3, must be in the map of 26 x 16"),
        (("--duration", "-1s"), "--duration: -1 s, must be >= 0.01"),
        (("--seed", "3"), "--seed: 3, a reference has no neurons"),
        (("--plot", "way.bmp"), "--plot: way.bmp, must end with"),
        (("--die", "3"), "--die: die A/3, no chip is in the loop; add --brain chip"),
        (("--agent", "bug1", "--brain", "ideal"), "--agent: bug1, has no network; use --brain reference"),
        (("--brain", "ideal", "--neurons", "9"), "--neurons: 9, must be from 300 to 40000"),
        (("--design", "improved"), "--design: a reference has no neurons; add --brain ideal"),
    ],
)
def test_what_is_wrong_is_one_line(run: Run, arguments: tuple[str, ...], says: str) -> None:
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert err.startswith("noctule: ")
    assert says in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "says"),
    [("S  \n", "no goal"), ("  G\n", "no start"), ("S ? G\n", "'?', must be")],
)
def test_maps_that_are_none(run: Run, tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "yard.txt"
    path.write_text(text, encoding="utf-8")
    status, out, err = run("--map", str(path))
    assert (status, out) == (2, "")
    assert says in err
    assert err.count("\n") == 1


def test_a_study_of_the_robot(capsys: pytest.CaptureFixture[str]) -> None:
    where = ("--param", "map=bug-open", "--param", "agent=bug0")
    arguments = ("montecarlo", "bug", "-n", "2", *where, "--metric", "reached", "--json")
    assert main(arguments) == 0
    assert json.loads(capsys.readouterr().out)["values"]["reached"] == [1.0, 1.0]
