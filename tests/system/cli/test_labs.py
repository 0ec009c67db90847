"""`noctule labs`: a die and a sheet for each student, and a check that tells wrong numbers from right."""

import json
from functools import cache
from pathlib import Path

import pytest

from system.bench import answers
from system.bench.answers import ASKED, Answer, answers_of, read_numbers
from system.cli import labs
from tests.system.conftest import Run


@pytest.fixture(autouse=True)
def read_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each number is measured twice, the fewest that have a deviation."""
    monkeypatch.setattr(answers, "READINGS", 2)


def test_dies_and_sheets_are_written_and_a_sheet_passes_the_check(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(labs, "answers_of", cache(answers_of))  # each die is measured once
    folder = tmp_path / "class"
    assert run("labs", "--students", "2", "-o", str(folder), "--first", "1005")[0] == 0
    assert (folder / "students.csv").read_text(encoding="utf-8") == "student,die\n1,1005\n2,1006\n"
    sheets = [(folder / "answers" / f"{die}.toml").read_text(encoding="utf-8") for die in (1005, 1006)]
    assert all(name in sheet for sheet in sheets for name in ASKED)
    assert sheets[0].splitlines()[3] != sheets[1].splitlines()[3]
    mine = tmp_path / "mine.toml"
    mine.write_text(sheets[0], encoding="utf-8")
    assert run("labs", "--check", str(mine))[0] == 0
    mine.write_text(sheets[0].replace("die = 1005", "die = 1006"), encoding="utf-8")  # somebody else's
    status, out, _ = run("labs", "--check", str(mine))
    assert status == 1
    assert "outside" in out


def test_a_die_with_a_silent_neuron_is_passed_over(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def measured(die: int, names: tuple[str, ...] = tuple(ASKED)) -> dict[str, Answer]:
        return dict.fromkeys(names, Answer(float("nan") if die == 1001 else 1.0, 0.1))

    monkeypatch.setattr(labs, "answers_of", measured)
    folder = tmp_path / "class"
    options = ("labs", "--students", "1", "-o", str(folder), "--first", "1001")
    assert "passed over: 1 dies" in run(*options)[1]
    assert (folder / "students.csv").read_text(encoding="utf-8") == "student,die\n1,1002\n"


def test_a_wrong_number_is_outside(run: Run, tmp_path: Path) -> None:
    right = answers_of(1000, ("pair_offset_V", "threshold_V"))
    mine = tmp_path / "mine.toml"
    off = right["pair_offset_V"].value + 2.0 * right["pair_offset_V"].error
    mine.write_text(f"die = 1000\npair_offset_V = {off}\nthreshold_V = {right['threshold_V'].value}\n")
    status, out, _ = run("labs", "--check", str(mine), "--json")
    found = json.loads(out)
    assert (status, found["outside"]) == (1, 1)
    assert not found["numbers"]["pair_offset_V"]["inside"]
    assert found["numbers"]["threshold_V"]["inside"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--students", "0", "-o", "class"), "--students: 0, must be 1 to 1000"),
        (("--students", "2"), "--output: not given; name a folder"),
        ((), "--students, --check: must be one of them"),
        (("--check", "none.toml"), "must be a readable file"),
    ],
)
def test_what_cannot_be(options: tuple[str, ...], said: str, run: Run) -> None:
    status, out, err = run("labs", *options)
    assert status not in {0, 1}
    assert (out, err.count("\n")) == ("", 1)
    assert said in err


def test_slips_in_a_file(run: Run, tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    for text, said in (
        ("threshold_V = 0.43\n", "die: missing"),
        ("die = 1000\nthresold_V = 0.43\n", "number thresold_V: unknown; did you mean threshold_V"),
        ("die = 1000\n", "no numbers, must be at least one"),
        ('die = 1000\nthreshold_V = "x"\n', "threshold_V"),
    ):
        mine.write_text(text, encoding="utf-8")
        status, _, err = run("labs", "--check", str(mine))
        assert status not in {0, 1}
        assert err.count("\n") == 1
        assert said in err
    mine.write_text("die = 1000\nthreshold_V = 0.43\n", encoding="utf-8")
    assert read_numbers(str(mine)) == (1000, {"threshold_V": 0.43})
