"""Every system refuses to leave a chip's validity box, or goes on and says so, in one way."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from system.cli.command_line import main

# what puts the chip of each system into the loop, a temperature (degC) outside its box, and the side
OUTSIDE = {
    # the air's own law ends at 60 degC
    "approach": (["--level", "behavioural", "--duration", "0.1s"], "-20", "ranging_chip.temperature"),
    "head": (["--duration", "0.2s"], "110", "sonar_head.temperature"),
    "forest": (["--ranges", "chip", "--pings", "2"], "110", "ranging_chip.temperature"),
    "car": (["--ranges", "chip", "--pings", "2"], "110", "ranging_chip.temperature"),
    "spiking-bat": (["--brain", "chip", "--pings", "2"], "110", "latency_chip.temperature"),
    "rover": (["--cells", "chip", "--bias-kind", "generator"], "110", "wavefront_chip.temperature"),
}


@pytest.mark.parametrize("name", OUTSIDE)
def test_outside_a_run_is_refused_with_path_box_and_remedy(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    options, celsius, side = OUTSIDE[name]
    assert main(["run", name, *options, "--temperature", celsius, "--json"]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert f"{side}: {celsius} degC, must be " in err
    assert err.strip().endswith("; use the transistor level, or give --outside warn")


@pytest.mark.parametrize("name", OUTSIDE)
def test_a_run_goes_on_where_a_warning_is_asked_for_and_says_so(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    options, celsius, side = OUTSIDE[name]
    asked = ["run", name, *options, "--temperature", celsius, "--outside", "warn"]
    assert main([*asked, "--json"]) == 0
    cautions = json.loads(capsys.readouterr().out)["summary"]["cautions"]
    assert any(text.startswith(f"{side}: {celsius} degC, must be") for text in cautions)
    assert main(asked) == 0
    assert capsys.readouterr().out.strip().splitlines()[-1] == f"caution: {cautions[-1]}"
    assert main(["run", name, *options, "--outside", "warn", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["summary"]["cautions"] == []


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
