"""Circuits that a user writes in one file each go through every command, by the file's name alone."""

from __future__ import annotations

import ast
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from circuits.units import unit_of_name
from system.cli.command_line import main

FOLDER = Path(__file__).parents[1] / "examples" / "circuits"
MOST_LINES = 25  # of a circuit
DIALECTS = {"ngspice": "cir", "hspice": "sp", "xyce": "xyce", "spectre": "scs", "cdl": "cdl"}


class Case(NamedTuple):
    """A circuit of a user: its testbench in its file, a source, a node, and a metric with its limits."""

    target: str
    source: str
    node: str
    metric: str
    least: float
    most: float


CASES = (
    Case("follower.py:step", "v_in", "v_out", "v_out_last_V", 2.015, 2.025),
    Case("mirror.py:drive", "i_in", "v_out", "v_out_last_V", 0.9, 1.3),
    Case("axon_hillock.py:spike", "i_in", "spike", "spike_rate_Hz", 350.0, 450.0),
    Case("ring.py:run", "vdd", "v[0]", "v_0_rate_Hz", 100e3, 180e3),
)


@pytest.fixture
def done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., dict[str, Any]]:
    """Give a command's JSON in a folder with the files."""
    for path in FOLDER.glob("*.py"):
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)

    def call(line: str, *more: str) -> dict[str, Any]:
        assert main([*line.split(), *more, "--json"]) == 0, capsys.readouterr().err
        found: dict[str, Any] = json.loads(capsys.readouterr().out)
        return found

    return call


def test_every_file_has_its_case_and_a_short_circuit() -> None:
    assert {path.name for path in FOLDER.glob("*.py")} == {case.target.split(":")[0] for case in CASES}
    for path in FOLDER.glob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        parts = [n for n in tree.body if isinstance(n, ast.FunctionDef | ast.Assign)]
        assert (
            sum((n.end_lineno or 0) - n.lineno + 1 for n in parts[:-1]) < MOST_LINES
        )  # the last is its bench


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.target)
def test_it_is_solved_simulated_and_analysed(case: Case, done: Callable[..., dict[str, Any]]) -> None:
    assert done(f"op {case.target}")["voltages_V"]
    assert case.least < done(f"simulate {case.target}")["measures"][case.metric] < case.most
    ac = done(f"simulate {case.target} --analysis ac --source {case.source} --node {case.node} --points 2")
    assert list(ac["runs"][0]["nodes"]) == [case.node]
    noise = done(f"simulate {case.target} --analysis noise --node {case.node} --points 2")
    assert noise["failed"] == 0


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.target)
def test_it_comes_back_equal_from_every_dialect(case: Case, done: Callable[..., dict[str, Any]]) -> None:
    for dialect, suffix in DIALECTS.items():
        done(f"export {case.target} --dialect {dialect} --output a.{suffix}")
        assert done(f"compare {case.target} a.{suffix}")["equal"]
    assert done(f"export {case.target} --dialect verilog-a --output a.va")["devices"] > 1


@pytest.mark.usefixtures("ngspice_library")
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.target)
def test_it_is_studied_and_replayed(case: Case, done: Callable[..., dict[str, Any]]) -> None:
    unit = unit_of_name(case.metric)
    spec = f"{case.metric} in {case.least:g}{unit}:{case.most:g}{unit}"
    short = ("--stimulus", "duration=20us") if case.target == "ring.py:run" else ()  # two periods and more
    words = f"montecarlo {case.target} --samples 2 --threads 1 --output study"
    study = done(words, "--spec", spec, *short)
    assert study["samples"] == 2
    found = done(f"replay study --die 1001 --code {case.target} --engine ngspice")
    assert found["identical"]
    again, ours = found["measures"][case.metric], found["kept"][case.metric]
    assert again == pytest.approx(ours, rel=1e-2)  # ngspice, one per cent, as the agreement has it
