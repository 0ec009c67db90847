"""Files of spikes: other programs read back what was written."""

from __future__ import annotations

import csv
import warnings
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.errors import DataError, ParameterError, SimulatorError
from system.spikes import file, neo_file
from system.spikes.file import write_spikes

STOP = 1.0
TRAINS = {
    "spike[0]": np.array([0.5, 1e-3 / 3]),  # in whatever order
    "silent": np.empty(0),
    'odd "name", with 0,1': np.array([0.5, 0.75, STOP]),
}
WANTED = {name: np.sort(times).tolist() for name, times in TRAINS.items()}


def _csv(path: Path) -> dict[str, list[float]]:
    first, *lines = path.read_text(encoding="utf-8").splitlines()
    assert first == ("# times in s from the beginning of the run, which ended at 1.0 s; addresses: 3, from 0")
    found: dict[str, list[float]] = {name: [] for name in TRAINS}
    for row in csv.DictReader(lines):
        assert list(TRAINS)[int(row["address"])] == row["name"]
        found[row["name"]].append(float(row["time_s"]))
    return found


def _npz(path: Path) -> dict[str, list[float]]:
    with path.open("rb") as opened, np.load(opened) as held:
        assert (held["time_s"].dtype, held["address"].dtype) == (np.float64, np.int64)
        assert np.all(np.diff(held["time_s"]) >= 0.0)
        assert (float(held["stop_s"]), str(held["time_base"])) == (STOP, neo_file.TIME_BASE)
        names = held["name"].tolist()
        return {name: held["time_s"][held["address"] == k].tolist() for k, name in enumerate(names)}


def _neo(path: Path) -> dict[str, list[float]]:
    neo = pytest.importorskip("neo")
    with warnings.catch_warnings(action="ignore"):
        if path.suffix == ".nwb":
            reader = neo.io.NWBIO(str(path), mode="r")
            (block,) = reader.read_all_blocks()
            trains = block.segments[0].spiketrains
            assert import_module("pynwb").validate(path=str(path)) == []
            reader.close()
        else:
            with neo.io.NixIO(str(path), mode="ro") as reader:
                trains = reader.read_block().segments[0].spiketrains
            assert [int(each.annotations["address"]) for each in trains] == [0, 1, 2]
    for each in trains:
        assert (each.units.dimensionality.string, float(each.t_start), float(each.t_stop)) == ("s", 0.0, STOP)
    return {each.name: each.magnitude.tolist() for each in trains}


@pytest.mark.parametrize(("suffix", "read"), [(".csv", _csv), (".npz", _npz), (".nwb", _neo), (".nix", _neo)])
def test_what_is_read_back_is_what_was_written(suffix: str, read: object, tmp_path: Path) -> None:
    path = tmp_path / f"spikes{suffix}"
    write_spikes(str(path), TRAINS, STOP)
    assert callable(read)
    assert read(path) == WANTED  # to the last bit
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_aedat4_has_addresses_as_columns_and_whole_microseconds(tmp_path: Path) -> None:
    faery = pytest.importorskip("faery")
    path = tmp_path / "spikes.aedat4"
    write_spikes(str(path), TRAINS, STOP)
    stream = faery.events_stream_from_file(path)
    assert stream.dimensions() == (3, 1)
    assert [tuple(row) for row in np.concatenate(list(stream)).tolist()] == [
        (333, 0, 0, True), (500_000, 0, 0, True), (500_000, 2, 0, True), (750_000, 2, 0, True),
        (1_000_000, 2, 0, True),
    ]  # fmt: skip


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".nwb", ".nix"])
def test_no_spike_is_a_file_too(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"none{suffix}"
    write_spikes(str(path), {"a": np.empty(0)}, STOP)
    assert path.stat().st_size > 0


def test_an_aedat4_file_without_a_spike_or_with_too_many_addresses_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "none.aedat4"
    with pytest.raises(ParameterError, match=r"needs at least one; write \.npz or \.csv"):
        write_spikes(str(path), {"a": np.empty(0)}, STOP)
    many = {str(k): np.zeros(1) for k in range(65_536)}
    with pytest.raises(ParameterError, match="65536 addresses, AEDAT4 has room for 65535"):
        write_spikes(str(path), many, STOP)
    assert not path.exists()


@pytest.mark.parametrize("times", [[-1e-9], [0.5, 1.5], [np.nan], [np.inf]])
def test_a_time_outside_of_the_run_is_refused(times: list[float], tmp_path: Path) -> None:
    wrong: F64 = np.array(times)
    with pytest.raises(ParameterError, match=r"axon: spike at .* must be within the run, 0 to 1 s"):
        write_spikes(str(tmp_path / "a.csv"), {"axon": wrong}, STOP)
    assert list(tmp_path.iterdir()) == []


def test_bad_names_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"must end with \.aedat4, \.npz, \.csv, \.nwb, \.nix; choose"):
        write_spikes(str(tmp_path / "a.dat"), TRAINS, STOP)
    with pytest.raises(DataError, match="there is no folder"):
        write_spikes(str(tmp_path / "no" / "a.npz"), TRAINS, STOP)


@pytest.mark.parametrize(("suffix", "library"), [(".nwb", "pynwb"), (".nix", "nixio")])
def test_without_neo_it_says_what_installs_it(
    suffix: str, library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(neo_file, "find_spec", lambda _: None)
    wanted = f"neo, {library}: not installed, {suffix} needs them; pip install neo {library}, or write .npz"
    with pytest.raises(SimulatorError, match=wanted):
        file.check_spikes(str(tmp_path / f"a{suffix}"))
