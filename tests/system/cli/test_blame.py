"""`noctule blame` of a toy: its text, JSON, page and refusals."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from system.cli.command_line import main
from system.cli.keys.study import BLAME
from system.options.die.file import read_die_file
from tests.json_document import wrong

TOY = str(Path(__file__).parents[1] / "study" / "blame" / "robot.py") + ":SYSTEM"


def test_document_has_its_keys_and_files_are_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    files = ["--report", "why.html", "--plot", "why.png", "--mended", "mended.toml"]
    assert main(["blame", TOY, "--die", "1003", *files, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert wrong(found, BLAME) == []
    assert found["guilty"]
    assert found["mends"]
    assert [each["succeeded"] for each in found["runs"]] == [False, True, True]
    page = Path("why.html").read_text(encoding="utf-8")
    assert all(each["path"] in page for each in found["culprits"])
    assert Path("why.png").stat().st_size > 5_000
    heal = [path for edit in read_die_file(Path("mended.toml")).edits for path in edit.paths]
    assert heal == sorted(each["path"] for each in found["culprits"])
    words = shlex.split(found["command"])
    words[2] = TOY
    assert main([*words[1:], "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["summary"]["succeeded"]


def test_success_in_words_of_the_user_takes_the_place_of_the_systems_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What the user asks for, here more than the healed die does, is what each trial is judged by."""
    page = tmp_path / "why.html"
    words = ["--success", "total_V > -1mV and total_V < 1mV", "--report", str(page)]
    assert main(["blame", TOY, "--die", "1003", *words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert wrong(found, BLAME) == []
    assert found["success"] == "total_V > -1mV and total_V < 1mV"
    assert found["mends"]
    assert [each["succeeded"] for each in found["runs"]] == [False, True, True]
    assert "total_V &gt; -1mV and total_V &lt; 1mV" in page.read_text(encoding="utf-8")


def test_a_success_that_no_trial_can_have_is_told_as_not_the_die(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The healed die's sum is 0, so a sum that must be large is met by neither, or by the die alone."""
    assert main(["blame", TOY, "--die", "1003", "--success", "total_V > 1V", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert not found["guilty"]
    assert [each["succeeded"] for each in found["runs"]] == [False, False]


def test_a_metric_that_is_not_defined_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    """The toy has no distance, so that no trial succeeds by it: that is told beside the verdict."""
    assert main(["blame", TOY, "--die", "1003", "--success", "distance_m > 1 or total_V > 1"]) == 1
    out = capsys.readouterr().out
    assert out.startswith("success: distance_m > 1 or total_V > 1\n")
    assert "Caution: distance_m: not defined in runs of seed 0" in out


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ("--die 1003 --success 'total < 1'", "--success: metric total: unknown; did you mean total_V?"),
        ("--die 1003 --success 'total_V < 1s'", '--success: "1s", must be a voltage in V'),
        ("--die 1003 --success 'total_V <'", 'success: "total_V <", column 10: the end, must be otherwise'),
        ("--die 1003 --heal 'toy_chip'", "all trials of seeds 0 to 5 succeed, must fail in one"),
        ("--die nominal", "die nominal all trials of seeds 0 to 5 succeed"),
        ("--die 1003 --trials 20", "--trials: 20, must be at least 150"),
        ("--die 1003 --heal toy_chip.nothing", "--heal: toy_chip.nothing, is the path of no device"),
    ],
)
def test_refusals_are_one_line(options: str, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["blame", TOY, *shlex.split(options)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert text in err
