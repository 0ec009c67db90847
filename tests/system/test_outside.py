"""Every system refuses to leave a chip's validity box, or goes on and says so, in one way."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from system.cli.command_line import main
from system.codes import find
from system.registry import system_names

# what puts the chip of each system into the loop, a temperature (degC) outside its box, and the side
OUTSIDE = {
    # the air's own law ends at 60 degC
    "approach": (
        ["--level", "behavioural", "--silicon-noise", "off", "--duration", "0.1s"], "-20",
        "ranging_chip.temperature",
    ),
    "head": (["--duration", "0.2s"], "110", "sonar_head.temperature"),
    "forest": (["--ranges", "chip", "--pings", "2"], "110", "ranging_chip.temperature"),
    "car": (["--ranges", "chip", "--pings", "2"], "110", "ranging_chip.temperature"),
    "spiking-bat": (["--brain", "chip", "--pings", "2"], "110", "latency_chip.temperature"),
    "rover": (["--cells", "chip", "--bias-kind", "ideal"], "110", "wavefront_chip.temperature"),
    "pushbot": (["--duration", "0.2s"], "70", "rolls_chip.temperature"),
    "bug": (
        ["--brain", "chip", "--bias-kind", "ideal", "--neurons", "500", "--duration", "0.1s"], "110",
        "nef_chip.temperature",
    ),
    "rolls": (["--duration", "0.2s"], "70", "rolls_chip.temperature"),
}  # fmt: skip
IN_TEXT = {"head", "car", "bug"}  # whose text is read beside its document, one way for all
NO_TRANSISTORS = {"pushbot", "bug", "rolls"}  # systems of chips with thousands of cells


def test_every_system_is_here() -> None:
    assert set(OUTSIDE) == set(system_names())


@pytest.mark.parametrize("name", OUTSIDE)
def test_outside_a_run_is_refused_with_path_box_and_remedy(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    options, celsius, side = OUTSIDE[name]
    assert main(["run", name, *options, "--temperature", celsius, "--json"]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert f"{side}: {celsius} degC, must be " in err
    remedy = "stay within" if name in NO_TRANSISTORS else "use the transistor level"
    assert err.strip().endswith(f"; {remedy}, or give --outside warn")


@pytest.mark.usefixtures("unmeasured_power")
@pytest.mark.parametrize("name", OUTSIDE)
def test_a_run_goes_on_where_a_warning_is_asked_for_and_says_so(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    options, celsius, side = OUTSIDE[name]
    asked = ["run", name, *options, "--temperature", celsius, "--outside", "warn"]
    assert main([*asked, "--json"]) == 0
    cautions = json.loads(capsys.readouterr().out)["summary"]["cautions"]
    assert any(text.startswith(f"{side}: {celsius} degC, must be") for text in cautions)
    if name in IN_TEXT:
        assert main(asked) == 0
        assert capsys.readouterr().out.strip().splitlines()[-1] == f"caution: {cautions[-1]}"
    assert main(["run", name, *options, "--outside", "warn", "--json"]) == 0
    inside = json.loads(capsys.readouterr().out)["summary"]["cautions"]
    assert [text for text in inside if not text.startswith("step: ")] == []  # which is of no box


def test_a_study_refuses_its_samples_or_says_which_have_left_a_box(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = ["montecarlo", "forest", "-n", "2", "--param", "ranges=chip", "--param", "pings=2"]
    assert main([*study, "--temperature", "110"]) == 1
    out, err = capsys.readouterr()
    remedy = "110 degC, must be -10 to 65 degC, where the behavioural model was measured; use the transistor"
    assert f"die 1000 failed: ranging_chip.temperature: {remedy}" in out
    assert err.strip().endswith("level, or give --param outside=warn")
    hot = [*study, "--param", "outside=warn", "--temperature", "27", "--temperature", "110", "--json"]
    assert main([*hot, "-o", str(tmp_path / "study")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["outcomes"] == ["measured", "outside the box"] * 2
    assert not found["failed"]
    assert main(["replay", str(tmp_path / "study"), "--die", "1000", "--temperature", "110", "--json"]) == 0
    assert "outside the box" in capsys.readouterr().out


def test_events_faster_than_those_that_were_measured_are_outside(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "rolls", "--input-rate", "2kHz", "--duration", "0.2s"]) == 2
    assert "rolls_chip.input_rate: 2e+03 Hz, must be 0 to 1e+03 Hz, where" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "options", "side"),
    [
        (
            "forest",
            ["--selection", "chip", "--codes", "default", "--area", "0.1"],
            "selection.area: 0.1 times the circuits'",
        ),
        (
            "spiking-bat",
            ["--brain", "chip", "--codes", "default", "--area", "0.1"],
            "latency_chip.area: 0.1 times the circuits'",
        ),
        ("head", ["--area", "0.01"], "sonar_head.area: 0.01 times the circuits'"),
        (
            "bug",
            ["--brain", "chip", "--codes", "default", "--area", "0.02"],
            "nef_chip.area: 0.02 times the circuits'",
        ),
        ("bug", ["--brain", "chip", "--calibrated-at", "70degC"], "nef_chip.calibration: 70 degC"),
        ("rover", ["--cells", "chip", "--unit", "1s"], "wavefront_chip.unit: 1 s"),
    ],
)
def test_other_sides_than_the_temperature(
    name: str, options: list[str], side: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", name, *options]) == 2
    assert f"{side}, must be " in capsys.readouterr().err


def test_a_die_is_not_calibrated_where_its_run_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def never(*_: object) -> None:
        raise AssertionError("calibrated in vain")

    monkeypatch.setattr(find, "kept_anew", never)
    for name in ("pushbot", "rolls", "bug", "forest", "car", "spiking-bat", "approach"):
        options, celsius, side = OUTSIDE[name]
        bias = [word for word in options if word not in {"--bias-kind", "ideal"}]
        assert main(["run", name, *bias, "--die", "987", "--temperature", celsius]) == 2
        assert f"{side}: {celsius} degC" in capsys.readouterr().err
