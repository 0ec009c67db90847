"""Text of a file that a user wrote, such as a map."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from circuits.errors import DataError, unknown_name


def map_path(name: str, shipped: Iterable[str], folder: Path) -> Path:
    """Return the path of a map: of a shipped one by its name, or of a user's own file.

    Raises `UnknownNameError` for a name that is neither, with those that are shipped.
    """
    names = list(shipped)
    if name in names:
        return folder / f"{name}.txt"
    path = Path(name)
    if not path.exists() and path.suffix == "" and path.parent == Path():
        raise unknown_name("map", name, names)
    return path


def map_text(name: str, shipped: Iterable[str], folder: Path, noun: str) -> tuple[Path, str]:
    """Return path and text of a map, as `map_path` and `read_text` say, with the errors of both."""
    path = map_path(name, shipped, folder)
    return path, read_text(path, noun)


def read_text(path: str | Path, noun: str) -> str:
    """Return the text of a file in UTF-8, without the mark with which some programs begin it.

    noun : what the file must be, for the error's text.

    Raises
    ------
    DataError
        The file cannot be read, or is no text: one line that names file and line.
    """
    try:
        return Path(path).read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        shown = f"byte 0x{error.object[error.start]:02x} is not UTF-8"
        raise DataError(f"{path}:{line}: {shown}, must be {noun}; save it as text in UTF-8") from None
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise DataError(f"{path}: {reason}, must be a readable file; check path and permissions") from None
