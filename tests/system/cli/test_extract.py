"""`noctule extract`: a process's file from measured currents, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from circuits.extraction.fit import law_current
from circuits.extraction.points import Points
from circuits.silicon.process import ROLLS_180
from circuits.silicon.process_file import read_process
from system.cli.command_line import main
from tests.circuits.extraction.test_fit import table
from tests.refusals import command_refusals


def test_measured_currents_become_a_process_that_blocks_run_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gate = np.linspace(0.25, 1.2, 40)
    true, one = replace(ROLLS_180.n, v_t0=0.44, mu_cox=310e-6), np.ones(gate.size)
    blank = Points("n", 2e-6 * one, 1e-6 * one, 27.0 * one, one, gate, 0.0 * one, one)
    points = replace(blank, current=law_current(true, ROLLS_180, blank))
    path, made = table(points, tmp_path / "fet.csv"), tmp_path / "mine.toml"
    picture = tmp_path / "fit.png"
    assert main(["extract", "--points", str(path), "-o", str(made), "--plot", str(picture), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    process = read_process(made)
    assert process.name == "mine"
    assert process.n.v_t0 == pytest.approx(0.44, abs=2e-3)
    assert process.p == ROLLS_180.p
    judged = document["distances"][-1]
    assert (judged["role"], judged["points"]) == ("judged", 40)
    assert judged["median"] < 0.01
    free = [n["name"] for n in document["numbers"] if n["value"] is None]
    assert {"v_t0_drift", "early_field", "surface_potential"} <= set(free)
    assert picture.stat().st_size > 10_000
    assert "nFETs, free, as in the base:" in made.read_text()
    assert main(["op", "rolls-neuron", "--process", str(made), "--json"]) == 0


test_what_is_wrong_is_told_in_a_line = command_refusals(
    "extract",
    rows=[
        ("-o x.toml", "--process: or --points or --fit, one of them"),
        ("--process gf180mcu --points a.csv -o x.toml", "--process: or --points or --fit, one of them"),
        ("--process gf180mcu --base rolls-180 -o x.toml", "--base: only with --points"),
        ("--points a.csv --only x -o x.toml", "--only, --conditions: only with --fit"),
        ("--fit coach --only nothing -o x.toml", "coach: no measurement is called nothing"),
        ("--fit none -o x.toml", "none: no CSV files, must be a folder of measurements"),
        ("--fit coach --only ndp_run1 --only x --conditions none.toml -o x.toml", "none.toml: No such file"),
        ("--fit coach --only dpi_base -o x.toml", "points for 22 numbers of the process, must be more"),
        ("--process sky90 -o x.toml", "process: sky90, must be one of gf180mcu, sky130"),
        ("--points none.csv -o x.toml", "none.csv: No such file"),
        ("--process gf180mcu -o none/x.toml", "none"),
    ],
)
