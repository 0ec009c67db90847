"""A campaign's file: a line that names the campaign, then a line of JSON a run.

Nothing that is not the campaign's own is ever changed: a file that is there must be a regular one, no link,
and begin with this campaign's line, before anything of it is cut or added. What follows the last whole line
of such a file, half a run of a process that was killed while it wrote, is cut off with a warning. Two
processes never write into one file: the second is refused.
"""

from __future__ import annotations

import json
import os
import stat
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Generic, TypeVar, final

import msgspec

from circuits.errors import DataError, ParameterError
from system.files.claim import take
from system.files.document import from_json, plain

Key = TypeVar("Key")
Result = TypeVar("Result")
Header = dict[str, str]  # name and mark of the campaign
# No link is followed and no pipe waited for; what is added always goes to the end.
_OPEN = os.O_NOFOLLOW | os.O_NONBLOCK | os.O_APPEND | os.O_CLOEXEC


class _Line(msgspec.Struct, Generic[Key, Result], forbid_unknown_fields=True):
    """A line of the file: a key, and what was found."""

    key: Key
    found: Result


class CutLine(UserWarning):
    """Half a line was cut off a campaign's file."""


@final
class CampaignFile(Generic[Key, Result]):
    """A campaign's file while it is open."""

    def __init__(self, path: Path, descriptor: int, header: Header, line: type[_Line[Key, Result]]) -> None:
        """Read the file, whose runs are of a type; raises as `open_runs`."""
        self._path, self._descriptor, self._claimed = path, descriptor, False
        data = _contents(path, descriptor)
        self._size, self._whole = len(data), data.rfind(b"\n") + 1
        self._known = _runs(path, data[: self._whole], header, line)

    def find(self, key: Key) -> Result | None:
        """A run that the file has. Where it has none, nobody else may write the file from then on.

        Raises
        ------
        ParameterError
            Another process writes to the file, or has done so since it was opened.
        DataError
            The file cannot be written.
        """
        found = self._known.get(key)
        if found is None and not self._claimed:
            self._claim()
            self._claimed = True
        return found

    def _claim(self) -> None:
        """Take the file for this process, and cut off half a last line."""
        _lock(self._path, self._descriptor)
        if os.fstat(self._descriptor).st_size != self._size:
            raise ParameterError(f"output: {self._path}, another process wrote to it just now; try again")
        if not os.access(self._path, os.W_OK):
            raise DataError(f"{self._path}: cannot be written, permission denied; name another file")
        if self._whole != self._size:
            os.truncate(self._descriptor, self._whole)
            cut = f"half a line at its end, {self._size - self._whole} bytes, was cut off"
            warnings.warn(f"{self._path}: {cut}; its run is made again", CutLine, stacklevel=3)

    def keep(self, key: Key, result: Result) -> None:
        """Add a run, which is on the disk afterwards; raises `DataError` where it cannot be written."""
        _write_line(self._path, self._descriptor, {"key": key, "found": plain(result)})
        self._known[key] = result


@contextmanager
def open_runs(
    path: Path, header: Header, key: type[Key], result: type[Result], *, resume: bool
) -> Iterator[CampaignFile[Key, Result]]:
    """Begin a campaign's file, or go on with one that is there.

    key, result: types of what its lines hold.

    Raises
    ------
    ParameterError
        The file is there and `resume` is not given, or is not there and it is; it is no regular file, no
        campaign's, or one of another campaign or other numbers.
    DataError
        The file cannot be read or written.
    """
    if os.path.lexists(path):
        _check_kind(path)
        if not resume:
            raise ParameterError(f"output: {path} is there; add `resume` to go on with it, or name another")
    elif resume:
        raise ParameterError(f"resume: {path} is not there, nothing to go on with; leave it out")
    else:
        _begin(path, header)
    descriptor = _opened(path)
    try:
        yield CampaignFile(path, descriptor, header, _Line[key, result])  # type: ignore[valid-type]
    finally:
        os.close(descriptor)


def _check_kind(path: Path) -> None:
    mode = path.lstat().st_mode
    if not stat.S_ISREG(mode):
        kinds = {stat.S_IFDIR: "a folder", stat.S_IFLNK: "a link"}
        kind = kinds.get(stat.S_IFMT(mode), "a device or a pipe")
        raise ParameterError(f"output: {path} is {kind}, must be a file of its own; name another")


def _begin(path: Path, header: Header) -> None:
    """Make the file with its first line; what another process makes meanwhile is left alone."""
    try:
        descriptor = os.open(path, _OPEN | os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
    except FileExistsError:
        raise ParameterError(f"output: {path} is there by now; name another file") from None
    except OSError as error:
        raise _unwritable(path, error) from None
    try:
        _write_line(path, descriptor, header)
    except DataError:
        path.unlink()  # ours, and with nothing in it
        raise
    finally:
        os.close(descriptor)


def _opened(path: Path) -> int:
    """Open, for writing too where that is allowed: runs on a read-only disk can still be reported."""
    try:
        return os.open(path, _OPEN | (os.O_RDWR if os.access(path, os.W_OK) else os.O_RDONLY))
    except OSError as error:
        raise DataError(f"{path}: cannot be read, {error.strerror}; name another file") from None


def _contents(path: Path, descriptor: int) -> bytes:
    try:
        with open(descriptor, "rb", closefd=False) as file:
            return file.read()
    except OSError as error:
        raise DataError(f"{path}: cannot be read, {error.strerror}; name another file") from None


def _lock(path: Path, descriptor: int) -> None:
    try:
        take(descriptor)
    except BlockingIOError:
        raise ParameterError(f"output: {path}, another process is writing it; name another file") from None


def _runs(path: Path, data: bytes, header: Header, line: type[_Line[Key, Result]]) -> dict[Key, Result]:
    """Runs of whole lines, of which the first must be the campaign's."""
    first, *rest = data.split(b"\n")[:-1] or [b""]
    if not _is_header(first, header):
        raise ParameterError(
            f"resume: {path} is not of this campaign, or has other numbers; name another file"
        )
    read = [
        from_json(text, line, f"{path}: line {number}", "delete it, or name another file")
        for number, text in enumerate(rest, 2)
    ]
    return {run.key: run.found for run in read}


def _is_header(line: bytes, header: Header) -> bool:
    with suppress(DataError):
        return from_json(line, dict, "", "") == header
    return False


def _write_line(path: Path, descriptor: int, row: Mapping[str, Any]) -> None:
    left = memoryview((json.dumps(row, allow_nan=False) + "\n").encode())
    try:
        while left:  # a full disk takes a part first
            left = left[os.write(descriptor, left) :]
        os.fsync(descriptor)
    except OSError as error:
        raise _unwritable(path, error) from None


def _unwritable(path: Path, error: OSError) -> DataError:
    return DataError(f"{path}: cannot be written, {error.strerror}; name another file")
