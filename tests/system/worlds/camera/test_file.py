"""Files of events."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from circuits.errors import DataError, ParameterError, SimulatorError
from system.worlds.camera.event import Events
from system.worlds.camera.file import read_events, write_events

EVENTS = Events(
    np.array([0.001, 0.25, 1.5]), np.array([0, 127, 5]), np.array([0, 127, 7]), np.array([True, False, True])
)


@pytest.mark.parametrize("suffix", ["txt", "npz"])
def test_a_round_trip_is_the_identity(suffix: str, tmp_path: Path) -> None:
    path = str(tmp_path / f"events.{suffix}")
    write_events(path, EVENTS)
    back = read_events(path)
    assert back.time == pytest.approx(EVENTS.time)
    for name in ("x", "y", "on"):
        assert getattr(back, name).tolist() == getattr(EVENTS, name).tolist()


def test_text_counts_rows_from_the_top(tmp_path: Path) -> None:
    path = tmp_path / "events.txt"
    write_events(str(path), EVENTS)
    assert path.read_text() == "# t_us x y on\n1000 0 127 1\n250000 127 0 0\n1500000 5 120 1\n"


def test_none_is_a_file_too(tmp_path: Path) -> None:
    path = str(tmp_path / "none.npz")
    write_events(path, EVENTS.where(np.zeros(3, dtype=np.bool_)))
    assert len(read_events(path)) == 0


def test_aedat4_is_read_back_by_its_library(tmp_path: Path) -> None:
    faery = pytest.importorskip("faery")
    path = tmp_path / "events.aedat4"
    write_events(str(path), EVENTS)
    back = np.concatenate(list(faery.events_stream_from_file(path)))
    assert [tuple(row) for row in back.tolist()] == [
        (1000, 0, 127, True), (250000, 127, 0, False), (1500000, 5, 120, True),
    ]  # fmt: skip


def test_without_the_library_it_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "faery", None)
    with pytest.raises(SimulatorError, match="faery: not installed, AEDAT4 needs it; pip install faery"):
        write_events(str(tmp_path / "a.aedat4"), EVENTS)


def test_bad_names_and_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"must end with \.aedat4, \.npz, \.txt"):
        write_events(str(tmp_path / "a.dat"), EVENTS)
    with pytest.raises(DataError, match="there is no folder"):
        write_events(str(tmp_path / "no" / "a.txt"), EVENTS)
    bad = tmp_path / "bad.txt"
    bad.write_text("1 2 three\n")
    for path in (bad, tmp_path / "none.txt", tmp_path / "none.npz"):
        with pytest.raises(DataError, match="must be events that write_events wrote"):
            read_events(str(path))
