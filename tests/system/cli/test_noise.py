"""`noctule simulate --analysis noise`: what it prints and writes."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from system.cli.command_line import main

NOISE = [
    "simulate",
    "rebound-neuron",
    "--analysis",
    "noise",
    "--node",
    "v_mem",
    "--points",
    "5",
    "--law",
    "ideal",
]


def test_json_csv_netcdf_and_picture_say_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = {kind: str(tmp_path / f"out.{kind}") for kind in ("csv", "nc", "svg")}
    files = ["--csv", paths["csv"], "--netcdf", paths["nc"], "--plot", paths["svg"], "--json"]
    assert main([*NOISE, "--source", "v_rest", "--dies", "1000-1001", *files]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    run = found["runs"][1]
    assert (found["node"], found["referred_unit"], run["die"]) == ("v_mem", "V^2/Hz", 1001)
    # sqrt(k T / C) of the membrane, 640 fF with its parasitics, is 80 uV; its current's transistor makes more
    assert run["rms_V"] == pytest.approx(80e-6, rel=0.1)
    assert run["rms_V"] == pytest.approx(np.hypot(run["white_rms_V"], run["flicker_rms_V"]), rel=1e-3)
    assert run["contributions"][0]["device"] == "membrane.m1"
    assert sum(d["share"] for d in run["contributions"]) == pytest.approx(1.0, rel=1e-3)
    with xr.open_dataset(paths["nc"], engine="h5netcdf") as data:
        one = data.sel(temperature=27.0, die=1001)
        output = (one.white + one.flicker).sum("device").to_numpy()
        gain = one.gain.to_numpy()
    np.testing.assert_allclose(run["output_V2_per_Hz"], output, rtol=1e-12)
    np.testing.assert_allclose(run["referred_per_Hz"], output / gain**2, rtol=1e-12)
    table = np.genfromtxt(paths["csv"], delimiter=",", names=True)
    csv = (table["white_V2_per_Hz"] + table["flicker_V2_per_Hz"])[output.size :]
    np.testing.assert_allclose(csv, output, rtol=1e-10)
    assert Path(paths["svg"]).stat().st_size > 0


def test_flicker_can_be_left_out(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*NOISE, "--no-flicker", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["flicker"], found["referred_unit"]) == (False, None)
    assert found["runs"][0]["flicker_rms_V"] == 0.0
    assert found["runs"][0]["referred_per_Hz"] is None


def test_one_output_is_needed_or_two_between_which_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "rebound-neuron", "--analysis", "noise"]) == 2
    assert "--node: 0 given" in capsys.readouterr().err
    assert main([*NOISE, "--node", "spike", "--node", "v_rest"]) == 2
    assert "--node: 3 given" in capsys.readouterr().err
