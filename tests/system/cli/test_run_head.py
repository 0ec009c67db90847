"""`noctule run head`: one JSON document, a table, and one line for whatever is wrong."""

from __future__ import annotations

from pathlib import Path

from tests.system.conftest import RunJson


def test_the_document(run_json: RunJson, tmp_path: Path) -> None:
    picture = tmp_path / "head.png"
    options = ("--die", "1003", "--temperature", "40", "--bias-kind", "ideal", "--area", "0.5")
    found = run_json(
        "run", "head", *options, "--motion", "walk", "--duration", "3s", "--seed", "7", "--plot", str(picture)
    )
    assert (found["die"], found["temperature_C"], found["bias_kind"], found["area"]) == (
        1003, 40.0, "ideal", 0.5,
    )  # fmt: skip
    assert (found["motion"], found["seed"], found["wiring"]) == ("walk", 7, "lso")
    assert {
        len(found[n]) for n in ("time_s", "target_deg", "head_deg", "range_m", "spikes_left", "lost")
    } == {30}
    assert found["summary"]["neck_ends"] == 0.0
    assert found["model_errors"]["counts_wrong"] == 0.0
    assert picture.stat().st_size > 10_000


def test_the_chip_is_calibrated_unless_asked_for_its_design(run_json: RunJson) -> None:
    options = ("--die", "104", "--seed", "104", "--duration", "4s")
    own, usual = (run_json("run", "head", *options, *codes) for codes in ((), ("--codes", "default")))
    assert (own["summary"]["ran_on"]["codes"], own["summary"]["ran_on"]["calibrated_at_C"]) == (
        "calibrated", 27.0,
    )  # fmt: skip
    assert usual["summary"]["ran_on"]["codes"] == "default"
    assert own["head_deg"] != usual["head_deg"]
    gate = run_json("run", "head", *options, "--bias-kind", "gate")
    assert gate["summary"]["ran_on"]["codes"] == "default"
