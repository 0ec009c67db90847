"""`noctule op`: the table by device in print, CSV and JSON."""

import csv
import json
from pathlib import Path

import pytest

from system.cli import op
from system.cli.command_line import main
from tests.system.conftest import RunJson

BLOCK = "rebound-neuron"


def test_every_device_is_in_the_json_and_in_the_csv(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "op.csv"
    assert main(["op", BLOCK, "--law", "ideal", "--csv", str(path), "--json"]) == 0
    devices = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)["devices"]
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [d["name"] for d in devices] == [r["name"] for r in rows]
    assert len(rows) == 34
    mr1 = next(d for d in devices if d["name"] == "membrane.mr1")
    # the bias i_rslope: 500 pA in a saturated pFET
    assert mr1["current_A"] == pytest.approx(-500e-12, rel=1e-4)
    assert (mr1["type"], mr1["inversion"], mr1["region"]) == ("pfet", "weak", "saturated")
    assert mr1["headroom_V"] == pytest.approx(mr1["v_ds_V"] - mr1["v_ds_sat_V"])
    assert float(rows[[r["name"] for r in rows].index("membrane.mr1")]["g_m_S"]) == mr1["g_m_S"]


def test_print_has_nodes_then_devices_and_says_what_it_leaves_out(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["op", BLOCK, "--law", "ideal"]) == 0
    whole = capsys.readouterr().out
    assert whole.index("v_mem") < whole.index("34 devices") < whole.index("membrane.mr1")
    assert "500pA" in whole
    assert "more devices" not in whole
    monkeypatch.setattr(op, "DEVICES_SHOWN", 10)
    assert main(["op", BLOCK]) == 0
    head = capsys.readouterr().out
    assert "24 more devices; --csv FILE" in head
    assert "axon.ma8" not in head


def test_a_resistor_has_its_current_and_empty_cells(tmp_path: Path) -> None:
    path = tmp_path / "op.csv"
    assert main(["op", "centroid-board", "--csv", str(path)]) == 0
    with path.open(newline="") as file:
        resistors = [r for r in csv.DictReader(file) if r["type"] == "resistor"]
    assert resistors
    assert all(r["g_m_S"] == "" and abs(float(r["current_A"])) < 1.0 for r in resistors)


def test_a_file_that_cannot_be_written_is_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["op", BLOCK, "--csv", str(tmp_path / "none" / "op.csv")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_the_supply_delivers_what_the_devices_take(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["op", BLOCK, "--law", "ideal", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    found = document["source_currents_A"]
    assert found["vdd"] > 500e-12 > abs(found["v_rest"])  # at least what membrane.mr1 carries
    assert main(["op", BLOCK]) == 0
    assert "delivers" in capsys.readouterr().out


def test_a_layouts_coupling_is_of_its_own_line_alone(
    run_json: RunJson, capsys: pytest.CaptureFixture[str]
) -> None:
    own = ("op", "rebound-neuron", "--coupling", "bus")
    assert run_json(*own)["process"] == "ami-1500"
    for process, asked in (("rolls-180", ("op", "rolls-neuron", "--coupling", "bus")),
                           ("coach-180", (*own, "--process", "coach-180"))):  # fmt: skip
        assert main(list(asked)) == 2
        said = capsys.readouterr().err
        assert f"--coupling: bus, its figures are those of the 1.5 um line, and {process} has other" in said
