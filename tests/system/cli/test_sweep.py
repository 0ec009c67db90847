"""The command `noctule sweep`: points, measures, files, and what is refused in one line."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from circuits.errors import ParameterError
from circuits.registry import load_block
from circuits.silicon.silicon import Silicon
from circuits.sweep.sweep import sweep
from system.cli.command_line import main
from system.options.swept import read_values

BLOCK = "rebound-neuron"


def test_points_are_those_of_the_library(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [str(tmp_path / name) for name in ("points.csv", "points.nc", "points.png")]
    words = ["--over", "v_rest=0V..2V:5", "--over", "temperature=0,60", "--current", "vdd", "--json"]
    assert main(["sweep", BLOCK, *words, "--csv", files[0], "--netcdf", files[1], "--plot", files[2]]) == 0
    found = json.loads(capsys.readouterr().out)
    block = load_block(BLOCK)
    over = {"v_rest": np.linspace(0.0, 2.0, 5), "temperature": [0.0, 60.0]}
    same = sweep(block.bench(), over, Silicon(block.process))
    voltage, current = same.voltage.sel(node="v_mem"), same.current.sel(device="vdd")
    assert (found["dimensions"], found["shape"]) == (["v_rest", "temperature"], [5, 2])
    np.testing.assert_array_equal(found["voltages_V"]["v_mem"], voltage.to_numpy().ravel())
    np.testing.assert_array_equal(found["currents_A"]["vdd"], current.to_numpy().ravel())
    with xr.open_dataset(files[1], engine="h5netcdf") as kept:
        np.testing.assert_array_equal(kept.voltage, same.voltage)
        assert kept.v_rest.attrs["units"] == "V"
    rows = list(csv.DictReader(Path(files[0]).read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 10
    assert float(rows[3]["v(v_mem)_V"]) == found["voltages_V"]["v_mem"][3]
    assert [rows[3]["v_rest_V"], rows[3]["temperature_degC"]] == ["0.5", "60.0"]
    assert Path(files[2]).read_bytes().startswith(b"\x89PNG")


def test_transients_are_measured(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--over", "membrane_capacitance=500fF,900fF", "--analysis", "tran"]
    measures = ["--measure", "t = cross(spike, 2.5, rise)", "--measure", "v = max(v_mem)"]
    assert main(["sweep", BLOCK, *words, *measures, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["unmeasured"] == {"t: spike does not rise through 2.5V": 1}
    early, never = found["measured"]["t"]["values"]
    assert (early is not None, never) == (True, None)
    assert main(["sweep", BLOCK, *words, *measures]) == 0
    said = capsys.readouterr().out
    assert "membrane_capacitance 500fF to 900fF, 2 values" in said
    assert "1 without t: spike does not rise through 2.5V" in said


def test_nothing_at_any_point_is_no(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["sweep", BLOCK, "--over", "die=1000..1001", "--analysis", "tran"]
    assert main([*words, "--measure", "t = cross(spike, 9V)"]) == 1
    assert capsys.readouterr().err == (
        "noctule: sweep: nothing at any point; t: spike does not pass through 9V\n"
    )


REFUSED = {
    "": "noctule: --over: nothing to sweep, must be at least one; write --over v_in=0V..5V:101",
    "--over v_rst=0V,1V": "noctule: --over: name v_rst: unknown; did you mean v_rest?",
    "--over call=0V,1V": "noctule: --over: call, there are several of that name, must be one; write"
    " source:call or stimulus:call",
    "--over v_rest=0V..1": 'noctule: v_rest: "1", must be a voltage in V; write the unit too, as in 1V',
    "--over v_rest=0:5:101": 'noctule: v_rest: "0:5:101", must be FROM..TO:COUNT; write as 0V..1.8V:181,',
    "--over v_rest=0V..1V": 'noctule: v_rest: "0V..1V", must say how many values; write as 0V..1.8V:181,'
    " 1pA..1uA:61log, 1000..1019 or 1V,2V",
    "--over v_rest=0V,1V --over v_rest=2V": "noctule: --over: v_rest is set 2 times, must be once",
    "--over v_rest=0V..1V:9log": 'noctule: v_rest: "0V..1V:9log", a log range must not reach 0;',
    "--over source:call=0V,1V --node v_mm": "noctule: node v_mm: unknown; did you mean v_mem?",
    "--over v_rest=0V,1V --analysis tran": "noctule: --measure: none, must be at least one of a transient;",
    "--over v_rest=0V,1V --measure max(v_mm)": 'noctule: --measure: "max(>v_mm)", column 5: node v_mm:',
    "--over corner=ss,xx": "noctule: --corner: xx, must be one of",
    "--over membrane_capacitance=0fF,1fF": "noctule: ",
    "--over v_rest=0V,1V --analysis tran --measure max(v_mem) --node v_mem": "noctule: --node: not of",
    "--over v_rest=0V,1V --plot x.txt": "noctule: --plot: x.txt, must end with .png",
}


@pytest.mark.parametrize(("words", "line"), REFUSED.items())
def test_what_is_refused(words: str, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", BLOCK, *words.split()]) == 2
    said = capsys.readouterr().err
    assert said.startswith(line)
    assert said.count("\n") == 1


def test_values_are_read() -> None:
    assert read_values("0V..1V:3", "V", "v") == (0.0, 0.5, 1.0)
    assert read_values("1pA..100pA:3log", "A", "i") == pytest.approx((1e-12, 1e-11, 1e-10))
    assert read_values("1000..1002", "", "die") == (1000, 1001, 1002)
    assert read_values("-20..85:4", "degC", "temperature") == pytest.approx((-20.0, 15.0, 50.0, 85.0))
    assert read_values("ss, ff", "", "corner") == ("ss", "ff")
    for text in ("0V..1Q:3", "0V..1V:1", "1..2:x"):
        with pytest.raises(ParameterError):
            read_values(text, "V", "v")
