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


@pytest.mark.parametrize(
    ("options", "text"),
    [
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
