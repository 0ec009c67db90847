"""The table of benchmarks: what it keeps, what it calls worse, and that benchmarks which claim can fail."""

from __future__ import annotations

import ast
import json
import sys
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.benchmark import benchmark

FOLDER = Path(__file__).resolve().parents[1] / "benchmarks"
SCRIPT = """
import json, sys
print("a word", file=sys.stderr)
print(json.dumps([{rows}]))
sys.exit({status})
"""
FAST = (
    '{"name": "fast", "ours": 1.0, "peer": 4.0, "ratio": %s, "accuracy": "a | b", "cores": 1, "least": 3.0}'
)
SMALL = '{"name": "small", "ours": 1.0, "peer": null, "ratio": %s, "accuracy": "-", "cores": 1, "most": 9.0}'
PLAIN = '{"name": "plain", "ours": 1.0, "peer": null, "ratio": null, "accuracy": "-", "cores": 1}'


@pytest.fixture(scope="module")
def table() -> Iterator[Any]:
    with benchmark("table") as found:
        yield found


def write(folder: Path, name: str, *rows: str, status: int = 0) -> None:
    text = SCRIPT.replace("{rows}", ", ".join(rows)).replace("{status}", str(status))
    (folder / f"{name}.py").write_text(text.replace("null", "None"), encoding="utf-8")


def measured(table: Any, folder: Path, compare: Path | None = None) -> int:
    options = Namespace(output=folder / "results", compare=compare, quick=False)
    return int(table.run(table.names(folder), options, folder))


def test_rows_are_kept_and_a_fifth_less_is_worse(
    table: Any, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path, "one", FAST % 4.0, SMALL % 2.0, PLAIN)
    write(tmp_path, "_part", PLAIN)
    assert measured(table, tmp_path) == 0
    results = tmp_path / "results"
    first = (results / "table.json").read_text(encoding="utf-8")
    (kept,) = json.loads(first, parse_constant=pytest.fail).values()
    assert [row["ratio"] for row in kept["rows"]] == [4.0, 2.0, None]
    assert "| fast | 1 | 4 | 4 | at least 3 | 1.333 | 1 | a / b |" in (results / "table.md").read_text()
    (tmp_path / "before.json").write_text(first, encoding="utf-8")

    write(tmp_path, "one", FAST % 3.1, SMALL % 2.3, PLAIN)
    assert measured(table, tmp_path) == 1
    told = capfd.readouterr().out
    assert "worse: one, fast: 4 to 3.1\n" in told
    assert "2 of 3 rows have a better side and were compared, 1 are worse by 20%" in told
    assert len((results / "history.jsonl").read_text().splitlines()) == 2

    write(tmp_path, "one", FAST % 3.3, SMALL % 2.5, PLAIN)
    assert measured(table, tmp_path, tmp_path / "before.json") == 1
    assert "worse: one, small: 2 to 2.5\n" in capfd.readouterr().out


def test_another_machine_is_told_and_another_form_is_not_compared(
    table: Any, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path, "one", FAST % 9.0)
    assert measured(table, tmp_path) == 0
    at = tmp_path / "results" / "table.json"
    kept = json.loads(at.read_text(encoding="utf-8"))
    kept["one"]["machine"] = "an abacus, 10 cores"
    at.write_text(json.dumps(kept), encoding="utf-8")
    write(tmp_path, "one", FAST % 4.0)
    assert measured(table, tmp_path) == 0
    assert "9 to 4, on another machine, which is not judged" in capfd.readouterr().out
    kept["one"]["quick"] = True
    (tmp_path / "quick.json").write_text(json.dumps(kept), encoding="utf-8")
    assert measured(table, tmp_path, tmp_path / "quick.json") == 0
    assert "0 of 1 rows" in capfd.readouterr().out


def test_a_row_that_is_gone_is_told_and_no_table_is_not_compared(
    table: Any, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, "one", FAST % 4.0, PLAIN)
    assert measured(table, tmp_path) == 0
    write(tmp_path, "one", PLAIN)
    assert measured(table, tmp_path) == 0
    assert "gone: one, fast\n" in capfd.readouterr().out
    kept = str(tmp_path / "results" / "table.json")
    monkeypatch.setattr(sys, "argv", ["table.py", "--compare", kept, "--output", str(tmp_path / "none")])
    with pytest.raises(SystemExit) as ended:
        table.main()
    assert ended.value.code == 2
    assert "no table.json to compare" in capfd.readouterr().err


def test_a_missed_claim_and_a_crash_are_failures_and_the_others_run(
    table: Any, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "crash.py").write_text("raise SystemExit('no such folder')", encoding="utf-8")
    write(tmp_path, "missed", FAST % 2.0, status=1)
    write(tmp_path, "then", PLAIN)
    assert measured(table, tmp_path) == 1
    told = capfd.readouterr()
    assert "crash: no rows, it ended with 1" in told.err
    assert "fast: 2, claim at least 3, MISSED" in told.out
    assert "3 benchmarks, 2 missed a claim or failed" in told.out


def claims_in_words() -> Iterator[str]:
    for path in sorted(FOLDER.glob("[!_]*.py")):
        text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        if text.startswith(("Claim:", "Claims:")):
            yield path.stem


@pytest.mark.parametrize("name", list(claims_in_words()))
def test_a_benchmark_that_claims_has_a_row_that_can_fail(name: str) -> None:
    tree = ast.parse((FOLDER / f"{name}.py").read_text(encoding="utf-8"))
    calls = [each for each in ast.walk(tree) if isinstance(each, ast.Call)]
    made = [each for each in calls if isinstance(each.func, ast.Name) and each.func.id == "Row"]
    ends = [len(each.args) > 6 or {k.arg for k in each.keywords} & {"least", "most"} for each in made]
    assert any(ends), f"{name}: no Row has least or most"
