"""Address-events that were written are read back; what is no stream is refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from circuits.errors import DataError, ParameterError
from system.spikes.file import write_spikes
from system.spikes.read import read_spikes
from tests.refusals import file_refusals

TRAINS = {"call": np.array([0.002, 0.5]), "silent": np.empty(0), "echo": np.array([0.25])}


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".aedat4"])
def test_what_was_written_is_read_back(suffix: str, tmp_path: Path) -> None:
    path = str(tmp_path / f"a{suffix}")
    write_spikes(path, TRAINS, 1.0)
    found = read_spikes(path)
    assert found.times.tolist() == pytest.approx([0.002, 0.25, 0.5], abs=1e-9)
    assert found.addresses.tolist() == [0, 2, 0]


def test_an_empty_stream_is_one(tmp_path: Path) -> None:
    path = str(tmp_path / "a.csv")
    write_spikes(path, {"a": np.empty(0)}, 1.0)
    assert read_spikes(path).times.size == 0


test_what_is_no_stream_is_refused = file_refusals(
    DataError,
    "a.csv",
    read_spikes,
    [
        ("time_s,address\n0.2,1\n0.1,1\n", r"event 1 at 0\.1 s, after 0\.2 s, times must be finite and rise"),
        ("time_s,address\nnan,1\n", "event 0 at nan s"),
        ("time_s,address\n0.1,-1\n", r"event 0 of address -1, must be 0 at least$"),
        ("time_s,address\n0.1,x\n", "addresses whole ones$"),
        ("time_s,neuron\n0.1,1\n", "no column address"),
        ("", "no column time_s, address"),
    ],
)


def test_a_damaged_file_and_another_suffix_are_refused(tmp_path: Path) -> None:
    for suffix in (".npz", ".aedat4"):
        path = tmp_path / f"a{suffix}"
        path.write_bytes(b"no such thing")
        with pytest.raises(DataError, match=r"no .*file of events"):
            read_spikes(str(path))
    with pytest.raises(ParameterError, match=r"\.csv"):
        read_spikes(str(tmp_path / "a.dat"))
    with (tmp_path / "b.npz").open("wb") as file:
        np.savez(file, time_s=np.array([0.1]), address=np.array([0.5]))
    with pytest.raises(DataError, match="float64 addresses; must be numbers, whole ones"):
        read_spikes(str(tmp_path / "b.npz"))
