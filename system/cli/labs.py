"""The verb `noctule labs`: a die and a hidden sheet of answers for each student, and a check of numbers."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from circuits.errors import ParameterError
from system.bench.answers import ASKED, Answer, answers_of, read_numbers
from system.cli.exit_status import DONE, NO
from system.cli.labs_verb import Labs
from system.cli.output import print_json, print_line, print_table, progress_bar, working
from system.files.writing import check_folder, write_text_atomic

_MOST = 1000  # students


def labs_command(asked: Labs) -> int:
    """Write dies and answers, or check numbers; returns `NO` where a number is outside."""
    if (asked.students is None) == (asked.check is None):
        raise ParameterError("--students, --check: must be one of them; give --students 30 or --check FILE")
    return _check(asked) if asked.check is not None else _give_out(asked)


def _give_out(asked: Labs) -> int:
    count = asked.students or 0
    if not 1 <= count <= _MOST:
        raise ParameterError(f"--students: {count}, must be 1 to {_MOST}")
    if asked.output is None:
        raise ParameterError("--output: not given; name a folder that dies and answers are written into")
    if asked.first < 0:
        raise ParameterError(f"--first: {asked.first}, must be 0 or more")
    folder = Path(asked.output)
    if folder.exists():
        raise ParameterError(f"--output: {folder} is there already; name a new folder")
    check_folder(str(folder))
    sheets = _sheets(asked.first, count)
    dies, silent = list(sheets), max(sheets) + 1 - asked.first - count
    (folder / "answers").mkdir(parents=True)
    for die, sheet in sheets.items():
        write_text_atomic(str(folder / "answers" / f"{die}.toml"), sheet)
    rows = "".join(f"{k + 1},{die}\n" for k, die in enumerate(dies))
    write_text_atomic(str(folder / "students.csv"), f"student,die\n{rows}")
    if asked.as_json:
        print_json({"folder": str(folder), "dies": dies, "silent": silent})
    else:
        if silent:
            print_line(f"passed over: {silent} dies on which a neuron stays silent")
        print_line(f"{folder}: students.csv with {count} dies, and answers/, which only the lecturer needs")
    return DONE


def _sheets(first: int, count: int) -> dict[int, str]:
    """Sheets by die, of the first so many dies on which every number can be measured."""
    found: dict[int, str] = {}
    die = first
    with progress_bar("labs") as progress:
        while len(found) < count:
            answers = answers_of(die)
            if all(math.isfinite(each.value) for each in answers.values()):
                found[die] = _sheet(die, answers)
                progress(len(found) / count)
            die += 1
    return found


def _sheet(die: int, answers: dict[str, Answer]) -> str:
    """A sheet as TOML, which `noctule labs` can check as well."""
    lines = [f"{name} = {each.value:.6g}  # +- {each.error:.2g}" for name, each in answers.items()]
    return "\n".join([f"die = {die}", *lines, ""])


def _check(asked: Labs) -> int:
    die, numbers = read_numbers(asked.check or "")
    with working(f"measuring die {die}"):
        answers = answers_of(die, tuple(numbers))
    inside = {
        name: abs(value - answers[name].value) <= answers[name].error for name, value in numbers.items()
    }
    if asked.as_json:
        told = {name: _entry(numbers[name], answers[name], is_in) for name, is_in in inside.items()}
        print_json({"die": die, "numbers": told, "outside": sum(not each for each in inside.values())})
    else:
        rows = [_row(name, numbers[name], answers[name], is_in) for name, is_in in inside.items()]
        print_table(f"die {die}", ("number", "yours:", "may be off by:", ""), rows)
    return DONE if all(inside.values()) else NO


def _entry(value: float, answer: Answer, is_in: bool) -> dict[str, Any]:  # noqa: FBT001 - a value of the table
    return {"value": value, "error": None if math.isnan(answer.error) else answer.error, "inside": is_in}


def _row(name: str, value: float, answer: Answer, is_in: bool) -> tuple[str, ...]:  # noqa: FBT001 - likewise
    unit = f" {ASKED[name].unit}".rstrip()
    return name, f"{value:g}{unit}", f"{answer.error:.2g}{unit}", "inside" if is_in else "outside"
