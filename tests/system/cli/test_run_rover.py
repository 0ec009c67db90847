"""`noctule run rover` and `noctule run`: one JSON document, tables, and one line for whatever is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.system.conftest import Run, RunJson


def test_the_document(run_json: RunJson, tmp_path: Path) -> None:
    picture = tmp_path / "way.png"
    found = run_json(
        "run", "rover", "--ideal", "--map", "map1-road-obstacles", "--start", "2,10", "--goal", "19,10",
        "--seed", "5", "--plot", str(picture),
    )  # fmt: skip
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


def test_a_map_of_ones_own(run_json: RunJson, tmp_path: Path) -> None:
    path = tmp_path / "yard.csv"
    path.write_text("1,9,1\n1,0,1\n1,1,1\n")
    found = run_json("run", "rover", "--map", str(path), "--start", "0,0", "--goal", "0,2")
    assert (found["cells"], found["die"]) == ("chip", 1000)
    assert found["summary"]["cost"] == 5.0  # around the south; over the 9 it is 11


def test_a_way_over_blocked_cells_is_told(run_json: RunJson, run: Run, tmp_path: Path) -> None:
    path = tmp_path / "wall.txt"
    path.write_text("1 1 1 1 1 1\n1 0 0 0 0 1\n1 1 1 1 0 1\n1 0 0 1 0 1\n1 1 1 1 1 1\n")
    asked = ("run", "rover", "--ideal", "--map", str(path), "--start", "0,0", "--goal", "2,3")
    found = run_json(*asked)
    way = np.array(found["driven_path_m"])
    row, column = 4 - (way[:, 1] // 6.0).astype(int), (way[:, 0] // 6.0).astype(int)
    inside = (row == 1) & (column >= 1) & (column <= 4)
    length = np.hypot(*np.diff(way, axis=0).T)
    assert (
        length[inside[1:] & inside[:-1]].sum() <= found["blocked_m"] <= length[inside[1:] | inside[:-1]].sum()
    )
    assert found["blocked_m"] > 1.0
    told = (
        f"driven over blocked cells: {found['blocked_m']:.1f} m; they bind the plan, and nothing stands there"
    )
    assert told in run(*asked)[1]


def test_chips_are_named_with_their_silicon(run_json: RunJson, run: Run) -> None:
    options = ("--cells", "chip", "--die", "1000", "--bias-kind", "ideal", "--unit", "20us")
    status, out, _ = run("run", "rover", *options, "--temperature", "40")
    assert status == 0
    assert "rover, wave on chip cells, 40 degC, die A/1000" in out
    found = run_json("run", "rover", *options)
    assert (found["cells"], found["die"], found["bias_kind"], found["unit_s"]) == (
        "chip",
        1000,
        "ideal",
        2e-5,
    )


def test_a_chip_plans_under_the_full_law_and_with_capacitors_that_deviate(run_json: RunJson) -> None:
    options = ("--cells", "chip", "--die", "1000", "--law", "full", "--variation", "full")
    found = run_json("run", "rover", *options, "--bias-kind", "generator", "--temperature", "0s:0,60s:60")
    assert found["law"] == "full"
    assert (found["variation"], found["summary"]["arrived"]) == ("full", 1)


def test_a_chip_is_calibrated_unless_asked_for_its_design(run_json: RunJson, tmp_path: Path) -> None:
    """By `wavefront-chip` for the map's shape."""
    path = tmp_path / "yard.csv"
    path.write_text("1,9,1\n1,30,1\n1,1,1\n")
    options = ("--map", str(path), "--start", "0,0", "--goal", "0,2", "--cells", "chip", "--die", "1000")
    own = run_json("run", "rover", *options, "--temperature", "37")
    assert (own["summary"]["ran_on"]["codes"], own["summary"]["regret"]) == ("calibrated", 0.0)
    assert own["summary"]["ran_on"]["calibrated_at_C"] == 27.0
    usual = run_json("run", "rover", *options, "--codes", "default")
    assert usual["summary"]["ran_on"]["codes"] == "default"


def test_a_study_of_the_rover(run_json: RunJson) -> None:
    route = [f"--param={text}" for text in ("map=map2", "start=16,3", "goal=10,10", "unit=10us")]
    found = run_json("montecarlo", "rover", "-n", "3", *route, "--metric", "cost", "--metric", "regret")
    values = found["values"]
    assert [c - r for c, r in zip(values["cost"], values["regret"], strict=True)] == [24.0] * 3
