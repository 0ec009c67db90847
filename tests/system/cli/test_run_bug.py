"""`noctule run bug`: one JSON document, a table, a picture, and one line for whatever is wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.system.conftest import RunJson


def test_the_document(run_json: RunJson, tmp_path: Path) -> None:
    picture = tmp_path / "way.png"
    found = run_json(
        "run", "bug", "--ideal", "--agent", "bug2", "--map", "bug-spiral", "--plot", str(picture)
    )
    assert found["reached"] is True
    assert found["ended"] == found["summary"]["reason"]
    assert found["ended"].startswith("goal reached after ")
    assert found["path"][0] == found["start"] == [2.5, 6.5]
    assert len(found["path"]) == len(found["state"]) + 1 == round(found["time_s"] / found["step_s"]) + 1
    assert set(found["state"]) == {"go", "follow"}
    assert found["summary"]["path_ratio"] > 1.0
    assert picture.stat().st_size > 10_000  # an empty figure has 3 kB


def test_neurons(run_json: RunJson) -> None:
    found = run_json(
        "run", "bug", "--agent", "bug2", "--brain", "ideal", "--design", "improved", "--neurons", "3000",
        "--seed", "7", "--map", "bug-open",
    )  # fmt: skip
    assert (found["reached"], found["design"], found["seed"]) == (True, "improved", 7)
    assert found["neurons"] == pytest.approx(3000, rel=0.02)  # rounding of every part
    assert found["state"][0] == "memorise"


def test_a_map_of_ones_own(run_json: RunJson, tmp_path: Path) -> None:
    path = tmp_path / "yard.txt"
    path.write_text("S    G\n  #   \n", encoding="utf-8")
    found = run_json("run", "bug", "--ideal", "--map", str(path), "--start", "0.5,0.5", "--goal", "0")
    assert (found["map"], found["reached"], found["start"]) == ("yard", True, [0.5, 0.5])


@pytest.mark.parametrize(
    ("text", "says"),
    [("S  \n", "no goal"), ("  G\n", "no start"), ("S ? G\n", "'?', must be")],
)
def test_maps_that_are_none(refused: Callable[..., str], tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "yard.txt"
    path.write_text(text, encoding="utf-8")
    assert says in refused("run", "bug", "--ideal", "--map", str(path))


def test_a_study_of_the_robot(run_json: RunJson) -> None:
    where = ("--param", "map=bug-open", "--param", "agent=bug0")
    found = run_json("montecarlo", "bug", "-n", "1", *where, "--metric", "reached")
    assert found["values"]["reached"] == [1.0]
