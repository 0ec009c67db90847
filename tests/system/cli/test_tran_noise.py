"""`noctule simulate --analysis tran-noise`: trials, their spread, and the files."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from system.cli.command_line import main

ANALYSIS = ["simulate", "rebound-neuron", "--analysis", "tran-noise"]
RUN = [*ANALYSIS, "--law", "ideal", "--step", "4us"]


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Path]:
    folder = tmp_path_factory.mktemp("tran-noise")
    files = [
        "--csv",
        str(folder / "a.csv"),
        "--netcdf",
        str(folder / "a.nc"),
        "--plot",
        str(folder / "a.png"),
    ]
    with pytest.MonkeyPatch.context() as patch:
        lines: list[str] = []
        patch.setattr("sys.stdout.write", lines.append)
        assert main([*RUN, "--trials", "3", "--seed", "5", "--workers", "2", *files, "--json"]) == 0
    return json.loads("".join(lines)), folder


def test_json_has_trials_and_their_spread(found: tuple[dict[str, Any], Path]) -> None:
    document, _ = found
    assert (document["seed"], document["step_s"], document["band_Hz"]) == (5, 4e-6, 125e3)
    times = [t["measures"]["t_inh_s"] for t in document["trials"]]
    told = document["summary"]["t_inh_s"]
    assert told["count"] == 3.0
    assert told["standard_deviation"] == pytest.approx(np.std(times, ddof=1))
    # the solver's is 5.492 ms; noise moves it by microseconds, the step of 4 us by less than 0.2 %
    assert told["mean"] == pytest.approx(5.492e-3, rel=2e-3)
    assert len(set(times)) == 3
    assert all(t["outcome"] == "one-spike" for t in document["trials"])
    assert document["summary"]["spike_0_s"]["count"] == 3.0


def test_files_say_the_same(found: tuple[dict[str, Any], Path]) -> None:
    document, folder = found
    times = [t["measures"]["t_inh_s"] for t in document["trials"]]
    with xr.open_dataset(folder / "a.nc", engine="h5netcdf") as data:
        np.testing.assert_array_equal(data.t_inh_s.to_numpy(), times)
        spikes = data.spikes_spike.to_numpy()
    assert [s.tolist() for s in spikes] == [t["spikes_s"]["spike"] for t in document["trials"]]
    table = np.genfromtxt(folder / "a.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    np.testing.assert_allclose(table["t_inh_s"], times, rtol=1e-11)
    assert (folder / "a.png").read_bytes().startswith(b"\x89PNG")


def test_the_same_seed_is_the_same_run(
    found: tuple[dict[str, Any], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*RUN, "--trials", "2", "--seed", "5", "--workers", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["trials"] == found[0]["trials"][:2]


def test_wrong_numbers_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    for option, text in (
        (["--trials", "0"], "--trials: 0"),
        (["--seed", "-1"], "seed: -1"),
        (["--workers", "0"], "workers: 0"),
        (["--step", "0s"], "step: 0 s"),
    ):
        assert main([*ANALYSIS, *option]) == 2
        assert text in capsys.readouterr().err
