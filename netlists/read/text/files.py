"""The files that a netlist consists of, read safely and within the limits of the reader.

A netlist may include other files. A file is read only if it lies inside the root folder, is a regular file,
and fits what `netlists.read.limits.Limits` allows.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from stat import S_ISREG

from circuits.errors import DataError
from netlists.read.card import shown
from netlists.read.limits import Limits
from netlists.read.note import Notes

_LAST = "\x1a"  # what ends a file of DOS, as vendors' libraries are
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")


@dataclass(slots=True)
class Files:
    """What has been read of a netlist so far; every function of this module that reads adds to it.

    Attributes
    ----------
    root : Path or None
        Folder that every included file must lie in, with links resolved; None where no file may be included.
    limits : Limits
        How many files, lines and bytes the netlist may have.
    notes : Notes
        What the reader has to tell its user.
    size : int
        Bytes that were read.
    lines : int
        Lines that were read.
    names : list of str
        Names of the files that were read, in that order and without their folders.
    sections : set of (Path, str)
        The sections of libraries that were asked for and found.
    open : list of (Path, str)
        The files that are being read, each with its section that is asked for, empty for the whole file: each
        one was included by the one before it.
    """

    root: Path | None
    limits: Limits
    notes: Notes
    size: int = 0
    lines: int = 0
    names: list[str] = field(default_factory=list)
    sections: set[tuple[Path, str]] = field(default_factory=set)
    open: list[tuple[Path, str]] = field(default_factory=list)


def root_folder(folder: Path) -> Path:
    """Resolve the links in the path of the folder that included files must lie in.

    Raises
    ------
    DataError
        `folder` is no folder.
    """
    resolved = folder.resolve()
    if not resolved.is_dir():
        raise DataError(f"{shown(str(folder))}: no folder, the root must be one; name a folder that exists")
    return resolved


def inside(path: Path, root: Path, name: str, place: str = "") -> Path:
    """Resolve the links in `path` and return the result, which lies inside `root`.

    Parameters
    ----------
    path
        Path of a file, as the netlist names it.
    root
        Folder that it must lie in, with links resolved.
    name, place
        The file's name as written, and the file and line that name it, empty where none does: both for an
        error's text.

    Raises
    ------
    DataError
        There is no such file, or it lies outside `root`.
    """
    try:
        resolved = path.resolve()
    except (OSError, RuntimeError, ValueError):  # a loop of links, or a NUL in the name
        raise DataError(f"{_called(name, place)}: no such file; correct the name") from None
    if not resolved.is_relative_to(root):
        rule = "lies outside the root folder; copy it inside, or set `root`"
        raise DataError(f"{_called(name, place)} {rule}")
    return resolved


def contents(files: Files, path: Path, place: str = "") -> str:
    """Read the text of a file and count it against the limits.

    Parameters
    ----------
    files
        What has been read so far; it is brought up to date.
    path
        The file, with links resolved.
    place
        File and line that name it, empty where none does, for an error's text.

    Raises
    ------
    DataError
        The file cannot be read, is no regular file, or exceeds a limit.
    """
    limits = files.limits
    if len(files.names) == limits.files:
        raise DataError(
            f"{place or f'{shown(path.name)}:1'}: more than {limits.files} files, the limit; join some"
        )
    try:
        status = path.stat()
        if not S_ISREG(status.st_mode):
            raise DataError(f"{_called(path.name, place)} is no file; name a file")
        if files.size + status.st_size > limits.size:
            raise _too_large(place or f"{shown(path.name)}:1", limits)
        with path.open("rb") as file:
            data = file.read(limits.size - files.size + 1)
    except OSError as error:
        reason = error.strerror or "cannot be read"
        raise DataError(f"{_called(path.name, place)}: {reason}; check the file") from None
    files.names.append(path.name)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        files.notes.add("text that is no UTF-8, read as Latin-1", f"{path.name}:{line}")
        text = data.decode("latin-1")
    head, _, rest = text.partition(_LAST)
    text = text if rest.strip(f"{_LAST} \r\n") else head
    count(files, text, path.name)
    return text


def _called(name: str, place: str) -> str:
    """A file by its name, after the place that names it where there is one."""
    return f"{place}: {shown(name)}" if place else shown(name)


def count(files: Files, text: str, name: str) -> None:
    """Count a text against the limits of how much is read.

    Parameters
    ----------
    files
        What has been read so far; it is brought up to date.
    text
        The text of one file.
    name
        The file's name, for an error's text.

    Raises
    ------
    DataError
        The limit of bytes or lines is exceeded, the text is empty, or it has control characters.
    """
    limits = files.limits
    files.size += len(text) if text.isascii() else len(text.encode("utf-8", "replace"))
    files.lines += text.count("\n") + 1
    if files.size > limits.size:
        raise _too_large(f"{name}:1", limits)
    if files.lines > limits.lines:
        last = limits.lines + text.count("\n") + 1 - files.lines
        raise DataError(
            f"{name}:{max(last, 1)}: more than {limits.lines} lines, the limit; split the netlist"
        )
    if not text.strip():
        raise DataError(f"{name}:1: empty, must be a netlist; give a title line and elements")
    found = _CONTROL.search(text)
    if found:
        line = text.count("\n", 0, found.start()) + 1
        raise DataError(f"{name}:{line}: control character {found.group()!r}, must be text; remove it")


def _too_large(place: str, limits: Limits) -> DataError:
    return DataError(f"{place}: more than {limits.size} bytes, the limit; split the netlist")
