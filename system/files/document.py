"""Documents that are read from files, JSON and TOML, held against the type that they must have.

A type is a dataclass or a `msgspec.Struct` (with `forbid_unknown_fields=True` where nothing else may stand in
it): types of fields are checked, `Annotated[int, msgspec.Meta(ge=1)]` has limits, and what a constructor
refuses with a `ValueError` is told with its place in the document. Whatever the bytes are, nothing but
`DataError` comes out: text that is none, brackets without end, numbers that no float holds. JSON has no NaN
and no infinity, as its standard says.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin

import msgspec
import numpy as np

from circuits.errors import DataError

T = TypeVar("T")

LARGEST = 64 * 2**20  # bytes of a document; ours
_PLACE = " - at `$"  # what msgspec puts between a reason and its place
_SHOWN = 200  # characters of a reason; ours


def from_json(data: bytes | str, kind: type[T], where: str, remedy: str) -> T:
    """Read a JSON document.

    Parameters
    ----------
    data
        The document, text or UTF-8.
    kind
        Type of the result; a `dict` where only that much is known. Fields that are arrays of numpy, by their
        types of `circuits.arrays`, are lists in the document, of an array of numbers null where one is NaN.
    where, remedy
        File (and line) that an error names, and what it tells to try.

    Raises
    ------
    DataError
        `where: place in the document: what is wrong; remedy`.
    """
    return _decoded(lambda: msgspec.json.decode(data, type=kind, dec_hook=_array), where, remedy)


def from_toml(data: bytes | str, kind: type[T], where: str, remedy: str) -> T:
    """Read a TOML document; as `from_json`."""
    return _decoded(lambda: msgspec.toml.decode(data, type=kind), where, remedy)


def converted(value: Any, kind: type[T], where: str, remedy: str) -> T:
    """Make a value of a type of what a document had in JSON's or TOML's own types; as `from_json`."""
    return _decoded(lambda: msgspec.convert(value, type=kind), where, remedy)


def toml_file(path: Path) -> dict[str, Any]:
    """Keys and values of a TOML file; raises `DataError` where it cannot be read or is none."""
    remedy = "must be TOML in UTF-8"
    try:
        return from_toml(document_bytes(path, remedy), dict[str, Any], str(path), remedy)
    except FileNotFoundError as error:
        raise DataError(f"{path}: {error.strerror}, must be a readable file; check the path") from None


def plain(value: object) -> Any:
    """A value of such a type in JSON's own types, as `from_json` takes it back."""
    return msgspec.to_builtins(value, enc_hook=_listed)


def folder_bytes(folder: Path, name: str, kind: str, remedy: str) -> bytes:
    """Contents of the document by which a folder is of a `kind`; `DataError` for none of that name."""
    try:
        return document_bytes(folder / name, remedy)
    except (FileNotFoundError, NotADirectoryError):
        raise DataError(f"{folder}: no {kind}, there is no {name}; name a {kind}'s folder") from None


def document_bytes(path: Path, remedy: str) -> bytes:
    """Contents of a file that holds one document; raises `DataError` where it cannot be read or is too large.

    `FileNotFoundError` passes: only the caller knows whether the file has to be there.
    """
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST + 1)
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:  # a path with a null character is a ValueError
        reason = getattr(error, "strerror", None) or str(error)
        raise DataError(f"{path}: cannot be read, {reason}; {remedy}") from None
    if len(data) > LARGEST:
        raise DataError(f"{path}: longer than {LARGEST // 2**20} MiB, no such document is; {remedy}")
    return data


def _array(kind: Any, items: Any) -> Any:
    """An array from a list; what is none is a `TypeError` of numpy's, or a `ValueError`."""
    if get_origin(kind) is not np.ndarray:
        raise NotImplementedError
    _, dtype = get_args(kind)
    try:
        return np.array(items, dtype=get_args(dtype)[0])
    except (TypeError, OverflowError) as error:
        raise ValueError(str(error)) from None


def _listed(value: Any) -> Any:
    """Arrays as lists, with None for NaN, and numbers of numpy as Python's."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "f" and np.isnan(value).any():
        known: Any = value.astype(object)
        known[np.isnan(value)] = None
        return known.tolist()
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise NotImplementedError


def _decoded(decode: Callable[[], T], where: str, remedy: str) -> T:
    try:
        return decode()
    except RecursionError:
        reason, place = "nested too deeply", ""
    except (ValueError, OverflowError) as error:
        reason, place = _told(error)
    raise DataError(f"{where}: {place}{reason}; {remedy}")


def _told(error: Exception) -> tuple[str, str]:
    """What is wrong, in one line, and the place of it, `plan.count: `, empty for the whole document."""
    text = " ".join(str(error).split()).replace("`", "")
    reason, _, place = text.rpartition(_PLACE.replace("`", ""))
    if not reason:
        reason, place = text, ""
    place = place.removeprefix(".")
    return reason[:_SHOWN], f"{place}: " if place else ""
