"""`noctule calibrate`, and runs at the codes of its files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tests.system.conftest import Run, RunJson

BAT = ("run", "spiking-bat", "--brain", "chip", "--pings", "2", "--seed", "1000")


def test_a_chip_is_calibrated_and_a_run_takes_its_file(
    run: Run, run_json: RunJson, refused: Callable[..., str], tmp_path: Path
) -> None:
    file = str(tmp_path / "codes.toml")
    found = run_json("calibrate", "latency-chip", "--die", "1003", "-o", file)
    assert (found["chip"], found["silicon"]["die"], found["failed"]) == ("latency-chip", 1003, "")
    assert found["bench_s"] > 1.0
    assert len(found["biases"]["tap"]) == 16
    of_file = run_json(*BAT, "--die", "1003", "--codes", file)
    own = run_json(*BAT, "--die", "1003")
    usual = run_json(*BAT, "--die", "1003", "--codes", "default")
    assert of_file["winner"] == own["winner"]
    assert of_file["path_m"] == own["path_m"] != usual["path_m"]
    assert "die A/1003, the run has A/1004" in refused(*BAT, "--die", "1004", "--codes", file)
    status, out, _ = run("calibrate", "latency-chip", "--die", "1003")
    assert status == 0
    assert "on the bench" in out


def test_what_is_refused(refused: Callable[..., str]) -> None:
    assert "latency-chip" in refused("calibrate", "latency-chp")
    assert "fixed gate voltages have no codes" in refused(
        *BAT, "--bias-kind", "gate", "--codes", "calibrated"
    )
    assert "codes: none, must be" in refused(*BAT, "--codes", "none")
