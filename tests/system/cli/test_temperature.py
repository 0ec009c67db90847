"""A temperature that moves, in runs and studies of systems with a chip in the loop."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.system.conftest import Run, RunJson

WARMING = "0s:27,1s:29"
# options of a run of seconds with a chip in its loop, by system
SHORT = {
    "approach": ("--level", "behavioural", "--duration", "0.08s"),
    "bug": ("--brain", "chip", "--neurons", "500", "--duration", "0.1s"),
    "car": ("--ranges", "chip", "--pings", "10"),
    "forest": ("--ranges", "chip", "--selection", "chip", "--pings", "8", "--obstacles", "300"),
    "head": ("--duration", "1s"),
    "pushbot": ("--duration", "0.2s"),
    "rolls": ("--codes", "default", "--duration", "0.2s"),
    "rover": ("--cells", "chip", "--trips", "2", "--learn", "0.5"),
    "spiking-bat": ("--brain", "chip", "--pings", "3"),
}


@pytest.mark.usefixtures("unmeasured_power")
@pytest.mark.parametrize("system", SHORT)
def test_a_run_follows_a_course_and_says_it(run_json: RunJson, system: str) -> None:
    found: dict[str, Any] = run_json("run", system, *SHORT[system], "--temperature", WARMING)
    assert found["temperature_C"] == [[0.0, 27.0], [1.0, 29.0]]
    assert found["summary"]["ran_on"]["temperature_C"] == "27 at 0 s, 29 at 1 s"


def test_a_study_has_one_course_and_no_other_temperature(run: Run, run_json: RunJson, tmp_path: Path) -> None:
    path = tmp_path / "afternoon.csv"
    path.write_text("time_s,temperature_C\n0,27\n1,29\n")
    options = ("montecarlo", "spiking-bat", "--param", "pings=9", "--samples", "1", "--bias-kind", "gate")
    by_file, by_text, still = (
        run_json(*options, "--metric", "distance-m", "--temperature", t) for t in (str(path), WARMING, "27")
    )
    assert by_file["temperature_C"] == [[0.0, 27.0], [1.0, 29.0]]
    assert by_file["values"] == by_text["values"] != still["values"]
    for target, more, says in (
        (options, ("--temperature", WARMING, "--temperature", "30"), "a course beside another"),
        (("montecarlo", "axon-delay", "--samples", "1"), ("--temperature", WARMING), "must be a temperature"),
    ):
        status, out, err = run(*target, *more)
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert says in err


def test_a_study_along_a_course_goes_on_and_its_dies_come_again(run_json: RunJson, tmp_path: Path) -> None:
    options = ("montecarlo", "head", "--param", "duration=0.5s", "--temperature", WARMING)
    options += ("--chunk", "1", "-o", str(tmp_path))
    run_json(*options, "--samples", "2")
    found = run_json(*options, "--samples", "3", "--resume")
    assert (found["chunks_read"], found["temperature_C"]) == (2, [[0.0, 27.0], [1.0, 29.0]])
    again = run_json("replay", str(tmp_path), "--die", "1001")
    assert (again["identical"], again["temperature_C"]) == (True, found["temperature_C"])


def test_a_course_that_leaves_what_was_measured_says_when_and_where(run: Run) -> None:
    options = ("run", "approach", "--level", "behavioural", "--silicon-noise", "off", "--duration", "1s")
    status, out, err = run(*options, "--temperature", "0s:60,1s:70")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert "ranging_chip.temperature: 65.1 degC at 0.505 s, must be -10 to 65 degC" in err
