"""A study of a system tells its yield by the system's own success, and a yes or no as a share."""

import json
import re
from pathlib import Path

import pytest

from circuits.lowering.kernel import Machine
from system.car.run import SYSTEM
from system.cli.command_line import main

HERE = "tests.system.study.test_success"
STUDY = ("montecarlo", "car", "--param", "pings=10", "-n", "3", "--threads", "1")
NONE = "0 of 3 (0 to 71 %)"  # Clopper and Pearson's of none of three: 1 - 0.025^(1/3) = 0.7076


def on_an_even_die(machine: Machine) -> bool:
    return (machine.silicon.die.number or 0) % 2 == 0


def test_a_study_tells_success_without_being_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "study"
    assert main([*STUDY, "-o", str(folder)]) == 0
    text = capsys.readouterr().out
    assert f"succeeded          0  {NONE}" in text
    assert f"collided           0  {NONE}" in text
    assert (
        f"yield 0.00 %, 95 % interval 0.00 to 70.76 % (Clopper-Pearson): succeeded ({SYSTEM.success})" in text
    )
    assert "did not succeed" in text
    page = re.sub(r"(?<=>)\s+(?=<)", "", (folder / "report.html").read_text())
    assert f"<h3>collided</h3><p>3 samples defined, 0 not defined.</p><p>Yes: {NONE}" in page
    assert "<h3>Yield: 0.00 %</h3>" in page
    told = (text + re.sub('src="data:[^"]*"', "", page)).replace(str(folder), "")  # a path may have "-0"
    assert not re.search("-0[^.0-9]", told)
    assert main([*STUDY, "-o", str(folder), "--resume", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    share = found["metrics"]["collided"]["share"]
    assert (share["passed"], share["value"], share["kind"]) == (0, 0.0, "Clopper-Pearson")
    assert share["interval"]["high"] == pytest.approx(1.0 - 0.025 ** (1 / 3))
    assert found["metrics"]["collided"]["quantiles"] == {}
    assert found["metrics"]["side_share"]["share"] is None
    assert found["yield"]["specifications"] == [f"succeeded ({SYSTEM.success})"]
    assert found["yield"]["causes"] == {"did not succeed": 3}


def test_what_is_asked_for_goes_before_success(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*STUDY, "--metric", "distance_m", "--spec", "collided in :0.5", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["metrics"]) == {"succeeded", "distance_m", "collided"}
    assert (found["yield"]["passed"], found["yield"]["specifications"]) == (3, ["collided in :0.5"])


def test_a_study_of_a_system_can_stop_by_its_success(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*STUDY, "--require", "90%", "--json"]) == 0
    assert (
        json.loads(capsys.readouterr().out)["metrics"]["succeeded"]["share"]["kind"] == "confidence sequence"
    )


def test_a_users_function_that_returns_a_bool_is_a_yes_or_no(capsys: pytest.CaptureFixture[str]) -> None:
    options = ("rebound-neuron", "-n", "4", "--threads", "1", "--metric", f"{HERE}:on_an_even_die")
    assert main(["montecarlo", *options]) == 0
    assert "on_an_even_die          0  2 of 4 (7 to 93 %)" in capsys.readouterr().out
