"""`noctule simulate --analysis ac`: what it prints and writes, and which options it takes."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from system.cli.command_line import main
from system.cli.small_signal import corner_frequency
from system.options.block import choose
from system.study.metrics.gradient import gradients
from tests.refusals import command_refusals

BLOCK = "onset-neuron"
AC = ["simulate", BLOCK, "--analysis", "ac", "--source", "envelope", "--node", "v_amp"]


def test_json_csv_netcdf_and_picture_say_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = {kind: str(tmp_path / f"out.{kind}") for kind in ("csv", "nc", "png")}
    files = ["--csv", paths["csv"], "--netcdf", paths["nc"], "--plot", paths["png"], "--json"]
    many = ["--temperatures", "-20,27", "--dies", "1000-1002", "--points", "2", "--to", "1k"]
    assert main([*AC, *many, *files]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert (found["unit"], found["failed"], len(found["frequency_Hz"])) == ("V/V", 0, 7)
    dies = [(run["temperature_C"], run["die"]) for run in found["runs"]]
    assert dies == [(t, d) for t in (-20.0, 27.0) for d in (1000, 1001, 1002)]
    with xr.open_dataset(paths["nc"], engine="h5netcdf") as data:
        complex_ = data.transfer_real + 1j * data.transfer_imaginary
        one = complex_.sel(temperature=27.0, die=1001, node="v_amp").to_numpy()
        assert data.attrs["source"] == "envelope"
    run = found["runs"][4]["nodes"]["v_amp"]
    np.testing.assert_allclose(run["magnitude"], np.abs(one), rtol=1e-12)
    table = np.genfromtxt(paths["csv"], delimiter=",", names=True)
    np.testing.assert_allclose(table["v_amp_magnitude"][28:35], np.abs(one), rtol=1e-11)
    np.testing.assert_allclose(table["v_amp_phase_deg"][28:35], run["phase_deg"], rtol=1e-9, atol=1e-9)
    assert Path(paths["png"]).read_bytes().startswith(b"\x89PNG")


def test_print_has_gain_and_corner(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(AC) == 0
    out = capsys.readouterr().out
    assert "9.9881" in out
    assert "8989" in out


@pytest.mark.usefixtures("ngspice_library")
def test_ngspice_says_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    found = []
    for engine in ("native", "ngspice"):
        assert main([*AC, "--points", "3", "--engine", engine, "--json"]) == 0
        found.append(json.loads(capsys.readouterr().out))
        assert found[-1]["engine"] == engine
    # both grids end at whole decades
    np.testing.assert_allclose(found[0]["frequency_Hz"], found[1]["frequency_Hz"], rtol=1e-9)
    ours, theirs = (f["runs"][0]["nodes"]["v_amp"] for f in found)
    # 1 % is asked for; the operating points are 1e-6 apart at most
    np.testing.assert_allclose(ours["magnitude"], theirs["magnitude"], rtol=1e-5)
    np.testing.assert_allclose(ours["phase_deg"], theirs["phase_deg"], rtol=1e-5, atol=1e-5)


def test_the_corner_of_a_low_pass() -> None:
    f = np.geomspace(1.0, 1e4, 81)
    # interpolation on 20 points a decade
    assert corner_frequency(f, 1.0 / np.hypot(1.0, f / 100.0)) == pytest.approx(100.0, rel=1e-3)
    assert corner_frequency(f, np.ones_like(f)) is None
    assert corner_frequency(f, np.zeros_like(f)) is None


test_wrong_options_are_refused_in_one_line = command_refusals(
    "simulate",
    BLOCK,
    rows=[
        ("--analysis ac", "--source: not given"),
        ("--analysis ac --source nothing", "source nothing: unknown"),
        ("--analysis ac --source envelope --node nothing", "node nothing: unknown"),
        ("--analysis ac --source envelope --seed 1", "--seed: not of --analysis ac"),
        ("--analysis ac --source envelope --flicker", "--flicker: not of --analysis ac"),
        ("--analysis ac --source envelope --raw x", "--raw: not of --analysis ac"),
        ("--analysis noise --node v_amp --engine ngspice", "--engine: not of"),
        ("--analysis ac --source envelope --dies 5-3", "--dies: 5-3"),
        ("--analysis ac --source envelope --dies 5-6 --die 5", "--die: 5 beside"),
        (
            "--analysis ac --source envelope --temperatures 0,1 --temperature 2",
            "--temperature: 2 beside",
        ),
        ("--analysis ac --source envelope --from 1V", "--from"),
        ("--analysis ac --source envelope --points 0", "points: 0"),
        ("--analysis ac --source envelope --temperatures 27,900", "temperature: 900"),
        ("--source envelope", "--source: not of --analysis tran"),
        ("--from 1", "--from: not of --analysis tran"),
        ("--analysis noise --trials 3 --node v_amp", "--trials: not of --analysis noise"),
        ("--analysis tran-noise --points 3", "--points: not of --analysis tran-noise"),
        ("--analysis tf", "is not one of"),
    ],
)


def test_a_transfer_is_measured(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--analysis", "ac", "--source", "v_rest", "--points", "40", "--json"]
    measures = [
        "--measure", "low = value(db(v_mem), at=1Hz)", "--measure", "f = cross(db(v_mem) - low, -3dB, fall)",
        "--measure", "never = cross(mag(v_mem), 9)",
    ]  # fmt: skip
    assert main(["simulate", "rebound-neuron", *words, *measures]) == 0
    found = json.loads(capsys.readouterr().out)
    (run,) = found["runs"]
    low, corner, never = run["measured"]
    magnitude = np.array(run["nodes"]["v_mem"]["magnitude"])
    assert low["value"] == pytest.approx(20.0 * np.log10(magnitude[0]))
    assert [m["unit"] for m in run["measured"]] == ["dB", "Hz", "Hz"]
    # 3 dB is 10^(-3/20), and the points are 6 % apart
    expected = corner_frequency(np.array(found["frequency_Hz"]), magnitude)
    assert corner["value"] == pytest.approx(expected, rel=0.02)
    assert never["reason"] == "mag(v_mem) does not pass through 9"
    assert main(["simulate", "rebound-neuron", *words, "--measure", "max(v_mem)"]) == 2
    assert "has magnitude and phase; write mag(v_mem), db(v_mem) or phase(v_mem)" in capsys.readouterr().err


def test_a_transfer_to_a_current_is_measured(capsys: pytest.CaptureFixture[str]) -> None:
    words = [
        "photoreceptor",
        "--analysis",
        "ac",
        "--from",
        "1kHz",
        "--to",
        "100kHz",
        "--points",
        "1",
        "--json",
    ]
    asked = {"i": "value(mag(i(vdd)), at=10kHz)", "z": "value(mag(v_sf) / mag(i(m_sf)), at=10kHz)"}
    measures = [word for name, text in asked.items() for word in ("--measure", f"{name} = {text}")]
    for source, units in (("v_prb", ["S", "Ohm"]), ("v_pd", ["", "Ohm"])):
        assert main(["simulate", *words, "--source", source, *measures]) == 0
        (run,) = json.loads(capsys.readouterr().out)["runs"]
        assert "i(vdd)" not in run["nodes"]
        assert [m["unit"] for m in run["measured"]] == units
        forms = (f"mag(i(vdd),{source},10kHz)", f"mag(v_sf,{source},10kHz)", f"mag(i(m_sf),{source},10kHz)")
        choice = choose("photoreceptor")
        one, two, three = gradients(choice.testbench(), forms, choice.silicon).value.values.tolist()
        assert [m["value"] for m in run["measured"]] == pytest.approx([one, two / three], rel=1e-9)
    assert main(["simulate", *words, "--source", "v_prb", "--measure", "max(mag(i(vd)))"]) == 2
    assert "device or source vd: unknown; did you mean vdd" in capsys.readouterr().err


@pytest.mark.usefixtures("ngspice_library")
def test_ngspice_measures_currents_of_sources(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["simulate", "photoreceptor", "--analysis", "ac", "--source", "v_prb", "--points", "1", "--json"]
    measure = ["--measure", "max(mag(i(vdd)))"]
    found = []
    for engine in ("native", "ngspice"):
        assert main([*words, *measure, "--engine", engine]) == 0
        found.append(json.loads(capsys.readouterr().out)["runs"][0]["measured"][0]["value"])
    assert found[1] == pytest.approx(found[0], rel=1e-4)
    assert main([*words, "--measure", "max(mag(i(m_sf)))", "--engine", "ngspice"]) == 2
    assert "device or source m_sf: unknown" in capsys.readouterr().err
