"""Writing files whole: a reader sees the earlier file or the finished one, never half of one.

The new contents go to a hidden file beside the target; it is flushed to the disk and then takes the target's
name in one step. If anything fails the hidden file is removed and the earlier output stays as it was. It is
claimed (`system.files.claim`) while it is written, so that what a killed process left can be told and swept
away. A target that is a device or a pipe (`/dev/stdout`) cannot be replaced and is written straight.
"""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from circuits.errors import DataError, ParameterError
from system.files.claim import claimed, sweep, take

if TYPE_CHECKING:
    import xarray as xr

HIDDEN = ".noctule-"  # a hidden file's name begins with it
_REASONS = {
    errno.EACCES: "permission denied; choose a folder that you may write to",
    errno.EDQUOT: "your disk quota is used up; free some space or choose another disk",
    errno.EFBIG: "the file grows beyond the allowed size; raise the limit (ulimit -f) or write less",
    errno.EISDIR: "it is a folder; give the name of a file in it",
    errno.ENAMETOOLONG: "its name is too long; choose a shorter one",
    errno.ENOSPC: "no space is left on the disk; free some or choose another disk",
    errno.ENOTDIR: "part of its path is a file; choose a folder",
    errno.EPERM: "permission denied; choose a folder that you may write to",
    errno.EROFS: "the disk is read-only; choose another one",
}


def checked_suffix(path: Path | str, suffixes: Sequence[str]) -> str:
    """Give the suffix of a path in small letters; raises `ParameterError` for none of `suffixes`."""
    suffix = Path(path).suffix.lower()
    if suffix not in suffixes:
        raise ParameterError(f"{path}: must end with {', '.join(suffixes)}; choose one of them")
    return suffix


def check_folder(path: Path | str) -> None:
    """Raise `DataError` before anything is computed if the folder of `path` is not there."""
    if not Path(path).parent.is_dir():
        raise _without_folder(Path(path))


def write_text_atomic(path: Path | str, text: str) -> None:
    """Write `text` to `path` as UTF-8, whole or not at all.

    Raises
    ------
    DataError
        If the file cannot be written; an earlier file at `path` is then unchanged.
    """
    write_bytes_atomic(path, text.encode("utf-8"))


def write_netcdf_atomic(path: Path | str, data: xr.Dataset) -> None:
    """Write labelled arrays as netCDF, whole or not at all.

    The file is made in memory: one that HDF5 cannot finish, as the disk is full, ends the process when it is
    closed.

    Raises
    ------
    DataError
        If the file cannot be written; an earlier file at `path` is then unchanged.
    """
    write_bytes_atomic(path, data.to_netcdf(engine="h5netcdf"))


def sweep_hidden(folder: Path) -> None:
    """Remove the hidden files that killed processes left in a folder."""
    sweep(folder, f"{HIDDEN}*")


@contextlib.contextmanager
def temporary_folder() -> Iterator[Path]:
    """A folder among the system's temporary ones, claimed while it is there; those of killed processes go."""
    above = Path(tempfile.gettempdir())
    prefix = f"{HIDDEN}{os.getuid()}-"
    sweep(above, f"{prefix}*")
    with (
        tempfile.TemporaryDirectory(prefix=prefix, dir=above, ignore_cleanup_errors=True) as name,
        claimed(Path(name)),
    ):
        yield Path(name)


def write_bytes_atomic(path: Path | str, data: bytes | memoryview) -> None:
    """Write `data` to `path`, whole or not at all.

    Raises
    ------
    DataError
        If the file cannot be written; an earlier file at `path` is then unchanged.
    """
    with replace_atomic(path) as temporary:
        temporary.write_bytes(data)


@contextlib.contextmanager
def replace_atomic(path: Path | str) -> Iterator[Path]:
    """Give a path to write to, which becomes `path` when the block ends well.

    For libraries that write files themselves: `with replace_atomic("a.raw") as temporary: write(temporary)`.
    The file is claimed meanwhile: what HDF5 writes, which locks its files too, goes by `write_netcdf_atomic`.

    Parameters
    ----------
    path
        The file to write. A symbolic link keeps pointing where it does; an existing file keeps its mode.

    Yields
    ------
    An empty file in the folder of `path` with its suffix, to be written and closed within the block.

    Raises
    ------
    DataError
        If the file cannot be written; an earlier file at `path` is then unchanged. Errors that the block
        raises about other files pass through.
    """
    shown = Path(path)
    temporary = shown
    try:
        if _is_special(shown):
            yield shown
            return
        target = shown.resolve()
        temporary = target.with_name(f"{HIDDEN}{secrets.token_hex(6)}{target.suffix}")
        with _created(temporary, like=target):
            yield temporary
            _flush(temporary)
            temporary.replace(target)
        with contextlib.suppress(OSError):  # the file is whole; only its name's durability is at stake
            _flush(target.parent)
    except OSError as error:
        if error.filename not in {None, str(temporary), str(temporary.parent)}:
            raise
        raise _unwritable(shown, error.errno, error) from error


def _is_special(path: Path) -> bool:
    """Whether `path` is there and is a device, a pipe or a socket; a folder is an error at once."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return False
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    return not stat.S_ISREG(mode)


@contextlib.contextmanager
def _created(temporary: Path, like: Path) -> Iterator[None]:
    """Make an empty file with the mode of `like`, or the umask's where there is none; it is gone after."""
    descriptor = -1
    try:
        descriptor = os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_RDWR | os.O_CLOEXEC, 0o666)
        take(descriptor)
        if like.exists():
            shutil.copymode(like, temporary)
        yield
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        if descriptor >= 0:
            os.close(descriptor)


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _unwritable(path: Path, code: int | None, error: Exception) -> DataError:
    if code == errno.ENOENT:
        return _without_folder(path)
    reason = _REASONS.get(code or 0) or f"{_first_line(error)}; check the path and the disk"
    return DataError(f"{path}: cannot be written, {reason}")


def _without_folder(path: Path) -> DataError:
    return DataError(f"{path}: cannot be written, there is no folder {path.parent}; make it first (mkdir -p)")


def _first_line(error: Exception) -> str:
    text = (error.strerror if isinstance(error, OSError) else None) or str(error) or type(error).__name__
    return text.splitlines()[0].rstrip(".")
