"""Answers that take seconds and never change, kept in the user's cache folder by all that they follow from.

The name of such a file is a digest of what was asked, of all sources and records of circuits and chips, and
of the libraries that compute. So an answer is never older than what it follows from: after a change it is
found under another name, by computing it. A file that was cut or edited, which its seal tells, is computed
and written again, and where nothing can be written nothing is kept. Of threads and processes that ask at the
same time one computes, and the others wait.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from platform import machine
from typing import Any, TypeVar

import msgspec
import numpy as np

from chips.record import record_key
from chips.record_file import cache_folder
from circuits.errors import DataError
from circuits.seal import sealed, unsealed
from system.files.claim import alone
from system.files.writing import write_bytes_atomic

T = TypeVar("T")


def kept(name: str, asked: tuple[object, ...], kind: type[T], compute: Callable[[], T]) -> T:
    """Return what `compute` gives, which is called where the answer is not kept yet.

    Parameters
    ----------
    name
        What it is, with hyphens: a part of the file's name.
    asked
        All that the answer depends on beside sources and records, told apart by their `repr`.
    kind
        Class of the answer: a dataclass of numbers, texts, arrays, and tuples and mappings of them.
    compute
        What takes long.
    """
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):  # arrays in full
        digest = record_key(asked, sources_of(), _computed_by())
    path = answers_folder() / f"{name}-{digest}.bin"
    known = _read(path, kind)
    if known is not None:
        return known
    with alone(path.with_suffix(".lock")):
        known = _read(path, kind)  # whoever asked at the same time has written it
        if known is not None:
            return known
        answer = compute()
        with suppress(OSError, DataError):
            path.parent.mkdir(parents=True, exist_ok=True)
            write_bytes_atomic(path, sealed(msgspec.msgpack.encode(answer, enc_hook=_parts_of)))
    return answer


def answers_folder() -> Path:
    """Return the folder in which answers are kept; it need not exist."""
    return cache_folder() / "answers"


@cache
def sources_of(*others: Path) -> str:
    """Return a digest of all sources and records of circuits and chips, and of those in other folders."""
    roots = {*others, *(Path(str(files(package))) for package in ("circuits", "chips"))}
    found = sha256()
    for path in (path for root in sorted(roots) for path in _sources_in(root)):
        found.update(path.name.encode())
        found.update(path.read_bytes())
    return found.hexdigest()


def _sources_in(root: Path) -> Iterable[Path]:
    return sorted([*root.rglob("*.py"), *root.rglob("*.nc"), *root.rglob("*.csv")])


@cache
def _computed_by() -> tuple[str, ...]:
    """What else may move the last bits."""
    return machine(), *(version(library) for library in ("numpy", "scipy", "numba"))


def _read(path: Path, kind: type[T]) -> T | None:
    """The answer that a file keeps; None without one, and for one that is not as it was written."""
    try:
        return msgspec.msgpack.decode(unsealed(path.read_bytes()), type=kind, dec_hook=_array_of)
    except (OSError, ValueError, TypeError):
        return None


def _parts_of(value: Any) -> tuple[str, tuple[int, ...], bytes]:
    if not isinstance(value, np.ndarray) or value.dtype.hasobject:
        raise TypeError(f"{type(value).__name__}, must be an array of numbers")
    return value.dtype.str, value.shape, value.tobytes()


def _array_of(_: type, parts: Any) -> Any:
    name, shape, numbers = parts
    return np.frombuffer(numbers, np.dtype(name)).reshape(shape).copy()
