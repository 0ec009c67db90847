"""`noctule run forest`: one JSON document, a table, and one line for whatever is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.system.conftest import Run, RunJson


def test_the_document(run_json: RunJson, tmp_path: Path) -> None:
    picture = tmp_path / "path.png"
    flight = ("--obstacles", "900", "--vmax", "2.5m/s", "--ping-rate", "10Hz", "--pings", "200")
    found = run_json("run", "forest", "--ideal", *flight, "--seed", "1003", "--plot", str(picture))
    assert (found["obstacles"], found["max_speed_m_per_s"], found["ping_rate_Hz"], found["seed"]) == (
        900, 2.5, 10.0, 1003,
    )  # fmt: skip
    pings = int(found["summary"]["pings"])
    assert len(found["obstacles_m"]) == 900
    assert len(found["path_m"]) == pings + 1
    assert [len(found[k]) for k in ("time_s", "heading_rad", "ping_direction", "arc", "scanning")] == [
        pings
    ] * 5
    assert found["path_m"][0] == found["start_m"]
    assert (found["ping_direction"][0], found["ranges"]) == (2, "exact")
    assert picture.stat().st_size > 10_000


def test_the_document_with_chips(run_json: RunJson, tmp_path: Path) -> None:
    film = tmp_path / "flight.gif"
    options = (
        "--ranges",
        "chip",
        "--selection",
        "chip",
        "--die",
        "1003",
        "--no-process-variation",
        "--pings",
        "6",
    )
    found = run_json("run", "forest", *options, "--animate", str(film), "--temperature", "30")
    assert (found["ranges"], found["selection"], found["die"]) == ("chip", "chip", 1003)
    assert (found["temperature_C"], found["process_variation"]) == (30.0, False)
    assert found["summary"]["heard"] + found["summary"]["missed"] > 0
    assert film.read_bytes()[:6] == b"GIF89a"


def test_a_map_of_ones_own(run_json: RunJson, run: Run, tmp_path: Path) -> None:
    path = tmp_path / "wood.csv"
    path.write_text("x_m,y_m\n10,10\n")
    found = run_json("run", "forest", "--ideal", "--map", str(path), "--start", "20m,30m", "--pings", "5")
    assert found["obstacles_m"] == [[10.0, 10.0]]
    assert found["path_m"][-1] == pytest.approx([18.0, 30.0])
    status, _, err = run("run", "forest", "--map", str(path), "--start", "10.1m,10m")
    assert status == 2
    assert err.count("\n") == 1
    assert "--start: 10.1,10, an obstacle is 0.1 m away" in err
