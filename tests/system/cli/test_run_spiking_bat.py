"""`noctule run spiking-bat`: one JSON document, a table, and one line for whatever is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.system.conftest import RunJson


def test_the_document_of_a_flight_by_spikes(run_json: RunJson, tmp_path: Path) -> None:
    picture = tmp_path / "path.png"
    options = ("--brain", "network", "--seed", "1003", "--pings", "3", "--start", "25m,25m", "--map")
    path = tmp_path / "wood.csv"
    path.write_text("x_m,y_m\n10,10\n")
    found = run_json("run", "spiking-bat", *options, str(path), "--plot", str(picture))
    assert (found["brain"], found["ping_rate_Hz"], found["paths"], found["taps"]) == (
        "network", 10.0, 33, 15,
    )  # fmt: skip
    assert (found["summary"]["pings"], found["ended"]) == (3.0, "all 3 pings flown")
    # nothing is in the way to the goal: straight left at 2 m/s for 0.3 s; arcs beside the middle one win with
    # it, whose speed is up to 5 % less, 0.03 m
    assert found["path_m"][-1] == pytest.approx([24.4, 25.0], abs=0.03)
    assert len(found["path_m"]) == len(found["time_s"]) + 1
    assert picture.stat().st_size > 5_000


def test_the_document_of_a_chips_flight(run_json: RunJson) -> None:
    options = ("--brain", "chip", "--die", "1003", "--bias-kind", "ideal", "--unit", "16,5")
    found = run_json("run", "spiking-bat", *options, "--pings", "3", "--temperature", "30")
    assert (found["die"], found["temperature_C"], found["bias_kind"], found["codes"]) == (
        1003, 30.0, "ideal", None,
    )  # fmt: skip
    assert found["transistor_units"] == [[16, 5]]
    assert (found["summary"]["ran_on"]["codes"], found["calibrated_at_C"]) == ("calibrated", 27.0)
    assert found["summary"]["overflowed"] == 0.0


def test_a_study_flies_a_forest_a_die(run_json: RunJson) -> None:
    found = run_json("montecarlo", "spiking-bat", "-n", "2", "--param", "pings=2", "--metric", "pings")
    assert found["failed"] == []
