"""`noctule run car`: one JSON document, a table, and one line for whatever is wrong."""

from __future__ import annotations

from pathlib import Path

from tests.system.conftest import RunJson


def test_the_document(run_json: RunJson, tmp_path: Path) -> None:
    picture = tmp_path / "way.png"
    options = ("--forest", "open", "--seed", "1003", "--pings", "40", "--vmax", "0.1m/s", "--no-multipath")
    found = run_json("run", "car", "--ideal", *options, "--plot", str(picture))
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


def test_the_document_with_a_chip(run_json: RunJson) -> None:
    options = (
        "--ranges",
        "chip",
        "--die",
        "1003",
        "--temperature",
        "30",
        "--no-process-variation",
        "--pings",
        "5",
    )
    found = run_json("run", "car", *options)
    assert (found["die"], found["temperature_C"]) == (1003, 30.0)
    on = found["summary"]["ran_on"]
    assert (on["codes"], on["calibrated_at_C"]) == ("calibrated", 27.0)
    assert found["unsure_delays"] >= 0


def test_a_forest_of_ones_own(run_json: RunJson, tmp_path: Path) -> None:
    path = tmp_path / "own.csv"
    path.write_text("x_m,y_m\n0.3,0.3\n0.3,-0.3\n0.9,0.3\n")
    options = ("--forest", str(path), "--ranges", "exact", "--plot", str(tmp_path / "way.png"))
    found = run_json("run", "car", *options)
    assert found["pipes_m"] == [[0.3, 0.3], [0.3, -0.3], [0.9, 0.3]]
    assert found["summary"]["reason"] == "came through the forest"
