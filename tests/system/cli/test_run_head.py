"""`noctule run head`: one JSON document, a table, and one line for whatever is wrong."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from system.cli.command_line import main

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    def call(*arguments: str) -> tuple[int, str, str]:
        status = main(("run", "head", *arguments))
        return status, *capsys.readouterr()

    return call


def test_the_document(run: Run, tmp_path: Path) -> None:
    picture = tmp_path / "head.png"
    options = ("--die", "1003", "--temperature", "40", "--bias-kind", "generator", "--area", "0.5")
    status, out, err = run(
        *options, "--motion", "walk", "--duration", "3s", "--seed", "7", "--plot", str(picture), "--json"
    )
    assert (status, err) == (0, "")
    found = json.loads(out, parse_constant=pytest.fail)
    assert (found["die"], found["temperature_C"], found["bias_kind"], found["area"]) == (
        1003, 40.0, "generator", 0.5,
    )  # fmt: skip
    assert (found["motion"], found["seed"], found["wiring"]) == ("walk", 7, "lso")
    assert {
        len(found[n]) for n in ("time_s", "target_deg", "head_deg", "range_m", "spikes_left", "lost")
    } == {30}
    assert found["summary"]["neck_ends"] == 0.0
    assert found["model_errors"]["counts_wrong"] == 0.0
    assert picture.stat().st_size > 10_000


def test_the_table_says_what_is_lost(run: Run) -> None:
    status, out, err = run("--duration", "1s", "--distance", "6m", "--swing", "0", "--motion", "step")
    assert (status, err) == (0, "")
    assert "head, step, lso" in out
    assert "pings without an answer: 10 faint" in out


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--ping-rate", "0"), "--ping-rate: 0 Hz, must be > 0"),
        (("--ping-rate", "90Hz"), "an echo from 1.4 m takes"),
        (("--azimuth", "100deg"), "behind the head"),
        (("--gain=-2deg",), "--gain: -2 deg, must be >= 0"),
        (("--duration", "5V"), "--duration"),
        (("--temperature", "80"), "sonar_head.temperature: 80 degC, must be -10 to 65 degC"),
    ],
)
def test_bad_options_are_one_line(run: Run, arguments: tuple[str, ...], says: str) -> None:
    status, out, err = run(*arguments)
    assert status != 0
    assert out == ""
    assert says in err
    assert err.count("\n") == 1
