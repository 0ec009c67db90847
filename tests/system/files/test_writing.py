"""Files are written whole, or the earlier one stays."""

import errno
import os
import stat
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from circuits.errors import DataError
from system.files.writing import (
    check_folder,
    replace_atomic,
    write_bytes_atomic,
    write_netcdf_atomic,
    write_text_atomic,
)

FULL = Path("/dev/full")
NO_SPACE = "no space is left on the disk; free some or choose another disk"


@pytest.fixture
def earlier(tmp_path: Path) -> Path:
    path = tmp_path / "result.csv"
    path.write_text("earlier")
    return path


def only_earlier(path: Path) -> bool:
    return path.read_text() == "earlier" and list(path.parent.iterdir()) == [path]


def test_text_replaces_the_earlier_file(earlier: Path) -> None:
    write_text_atomic(str(earlier), "κ = 0.7\n")
    assert earlier.read_bytes() == "κ = 0.7\n".encode()
    assert list(earlier.parent.iterdir()) == [earlier]


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture]
)  # the file is overwritten by each example
@given(data=st.binary())
def test_bytes_are_what_was_given(tmp_path: Path, data: bytes) -> None:
    write_bytes_atomic(tmp_path / "result.raw", data)
    assert (tmp_path / "result.raw").read_bytes() == data


def test_the_temporary_file_has_folder_and_suffix(tmp_path: Path) -> None:
    with replace_atomic(tmp_path / "run.nc") as temporary:
        assert temporary.parent == tmp_path.resolve()
        assert temporary.suffix == ".nc"
        assert not (tmp_path / "run.nc").exists()
    assert not temporary.exists()


def test_a_library_can_write_it(tmp_path: Path) -> None:
    with replace_atomic(tmp_path / "run.npz") as temporary:
        np.savez(temporary, v=np.arange(3.0))
    with np.load(tmp_path / "run.npz") as found:
        assert found["v"].tolist() == [0.0, 1.0, 2.0]


def test_labelled_arrays_come_back(tmp_path: Path) -> None:
    write_netcdf_atomic(tmp_path / "run.nc", xr.Dataset({"v": ("time", np.arange(3.0))}))
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as found:
        assert found["v"].values.tolist() == [0.0, 1.0, 2.0]
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


@pytest.mark.parametrize("error", [ValueError("bad"), KeyboardInterrupt(), RuntimeError("other")])
def test_a_failure_inside_keeps_the_earlier_file(earlier: Path, error: BaseException) -> None:
    with pytest.raises(type(error)), replace_atomic(earlier) as temporary:
        temporary.write_text("half")
        raise error
    assert only_earlier(earlier)


@pytest.mark.parametrize("call", ["fsync", "open"])
def test_a_full_disk_keeps_the_earlier_file(
    earlier: Path, call: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, call, refuse)
    with pytest.raises(DataError) as caught:
        write_text_atomic(earlier, "new")
    assert str(caught.value) == f"{earlier}: cannot be written, {NO_SPACE}"
    assert only_earlier(earlier)


def test_a_full_disk_while_writing_keeps_the_earlier_file(earlier: Path) -> None:
    with pytest.raises(DataError, match="no space is left"), replace_atomic(earlier) as temporary:
        temporary.write_text("half")
        raise OSError(errno.ENOSPC, "No space left on device", str(temporary))
    assert only_earlier(earlier)


@pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")
def test_a_device_is_written_straight_and_stays() -> None:
    with pytest.raises(DataError, match="/dev/full: cannot be written, no space is left"):
        write_text_atomic(FULL, "new")
    assert stat.S_ISCHR(FULL.stat().st_mode)


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError) as caught:
        write_text_atomic(tmp_path / "none" / "a.csv", "new")
    # what is said before the work is what the writing would say
    with pytest.raises(DataError) as before:
        check_folder(tmp_path / "none" / "a.csv")
    assert str(before.value) == str(caught.value)
    check_folder(tmp_path / "a.csv")
    folder = tmp_path / "none"
    reason = f"there is no folder {folder}; make it first (mkdir -p)"
    assert str(caught.value) == f"{folder}/a.csv: cannot be written, {reason}"


def test_a_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="it is a folder; give the name of a file in it"):
        write_text_atomic(tmp_path, "new")


def test_a_file_as_folder_is_refused(earlier: Path) -> None:
    with pytest.raises(DataError, match="part of its path is a file"):
        write_text_atomic(earlier / "a.csv", "new")


def test_a_name_too_long_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="its name is too long"):
        write_text_atomic(tmp_path / ("a" * 300), "new")


def test_a_forbidden_folder_is_refused(earlier: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> int:  # root may write anywhere, so the refusal is simulated
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(DataError, match="permission denied; choose a folder that you may write to"):
        write_text_atomic(earlier, "new")
    assert only_earlier(earlier)


def test_an_error_about_another_file_passes_through(earlier: Path) -> None:
    with pytest.raises(FileNotFoundError), replace_atomic(earlier):
        (earlier.parent / "input.csv").read_text()
    assert only_earlier(earlier)


def test_an_unknown_error_keeps_its_reason(earlier: Path) -> None:
    reason = "Input/output error; check the path and the disk"
    with pytest.raises(DataError, match=reason), replace_atomic(earlier):
        raise OSError(errno.EIO, "Input/output error")
    assert only_earlier(earlier)


def test_the_mode_of_the_earlier_file_stays(earlier: Path) -> None:
    earlier.chmod(0o640)
    write_text_atomic(earlier, "new")
    assert stat.S_IMODE(earlier.stat().st_mode) == 0o640


def test_a_new_file_follows_the_umask(tmp_path: Path) -> None:
    mask = os.umask(0o027)
    try:
        write_text_atomic(tmp_path / "a.csv", "new")
    finally:
        os.umask(mask)
    assert stat.S_IMODE((tmp_path / "a.csv").stat().st_mode) == 0o640


def test_a_link_keeps_pointing_where_it_does(earlier: Path) -> None:
    link = earlier.with_name("latest.csv")
    link.symlink_to(earlier.name)
    write_text_atomic(link, "new")
    assert link.is_symlink()
    assert earlier.read_text() == "new"
