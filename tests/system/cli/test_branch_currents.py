"""Currents of inductors and of sources between two nodes are told in amperes, by every verb."""

from __future__ import annotations

from pathlib import Path

import pytest

from circuits.measure.branch import branches, waveform
from circuits.solver.transient import simulate
from netlists.ngspice.raw import write_raw
from netlists.read import read_netlist
from system.cli.command_line import main
from tests.system.conftest import RunJson

DECK = (
    "t\nv1 in 0 pulse(0 1 0 1n 1n 1 2)\nr1 in a 100\nl1 a b 1m\nv2 b 0 0\nv3 c a 0.5\nr2 c 0 1k\n"
    ".tran 1u 100u\n.end\n"
)


@pytest.fixture
def deck(tmp_path: Path) -> str:
    (tmp_path / "coil.cir").write_text(DECK)
    return str(tmp_path / "coil.cir")


def test_a_run_tells_them(deck: str, tmp_path: Path, run_json: RunJson) -> None:
    csv = tmp_path / "run.csv"
    found = run_json("simulate", deck, "--csv", str(csv), "--measure", "top = max(i(l1))")
    told = found["measures"]
    through_r1 = (1.0 - told["a_last_V"]) / 100.0
    assert told["i_l1_last_A"] == pytest.approx(through_r1 + told["i_v3_last_A"], rel=1e-6)
    assert told["i_l1_last_A"] == pytest.approx(9.5e-3, rel=1e-3)  # ten time constants after the step
    assert found["measured"][0]["value"] == told["i_l1_max_A"]
    assert not any("branch" in name for name in told)
    heads = csv.read_text().splitlines()[0].split(",")
    assert {"i(l1)_A", "i(v3)_A", "a_V"} <= set(heads)
    assert not any("branch" in head for head in heads)


def test_an_operating_point_and_a_sweep_tell_them(deck: str, run_json: RunJson) -> None:
    found = run_json("op", deck)
    assert found["element_currents_A"] == pytest.approx({"l1": -0.5e-3, "v3": -0.5e-3}, rel=1e-6)
    assert not any("branch" in name for name in found["voltages_V"])
    swept = run_json("sweep", deck, "--over", "v1=0V..1V:3")
    assert swept["currents_A"]["l1"] == pytest.approx([-0.5e-3, 4.5e-3, 9.5e-3], rel=1e-6)
    assert not any("branch" in name for name in (*swept["currents_A"], *swept["voltages_V"]))
    assert {"l1", "v3", "r1"} <= set(swept["currents_A"])


def test_a_rawfile_tells_them(tmp_path: Path) -> None:
    result = simulate(read_netlist(DECK).testbench)
    write_raw(result, tmp_path / "run.raw")
    assert b"i(l1)\tcurrent" in (tmp_path / "run.raw").read_bytes()
    assert sorted(element for element, _ in branches(result.machine).values()) == ["l1", "v3"]
    assert waveform(result, "a").unit == "V"


def test_a_measure_of_such_a_node_is_refused(deck: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", deck, "--measure", "m = max(l1_x23_branch)"]) == 2
    assert "node l1_x23_branch: unknown" in capsys.readouterr().err
