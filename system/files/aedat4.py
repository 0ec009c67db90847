"""AEDAT4, the event files of jAER and the dv tools, written by `faery` (LGPL), an optional extra.

It is imported here alone. Times are whole microseconds.
"""

from __future__ import annotations

import zipfile
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circuits.arrays import F64, I64
from circuits.catalogue import extra
from circuits.errors import DataError, ParameterError
from system.files.writing import replace_atomic

SUFFIX = ".aedat4"
WIDEST = 65_535  # the file has 16 bits for a column
_MICRO = 1e6
# What numpy, zipfile, zlib and faery raise for a file that is damaged, which may say that arrays are endless.
UNREADABLE = (
    OSError, ValueError, KeyError, TypeError, EOFError, OverflowError, MemoryError, RuntimeError,
    AttributeError, SyntaxError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


def microseconds(time: F64) -> I64:
    """Times (s) as whole microseconds."""
    return np.rint(time * _MICRO).astype(np.int64)


def check_aedat4(other: str) -> None:
    """Raise `SimulatorError` where `faery` is not installed; other: what to write instead."""
    _faery(other)


def write_aedat4(
    path: str, t: I64, x: I64, y: I64, on: NDArray[Any], size: tuple[int, int], other: str
) -> None:
    """Write events, whole or not at all.

    t : microseconds, in order; x, y : column and row; on : polarity; each one entry an event.
    size : columns and rows; other : what to write instead where this cannot be.

    Raises
    ------
    ParameterError
        There is no event, which the format's reader refuses.
    SimulatorError
        `faery` is not installed.
    DataError
        The file cannot be written.
    """
    faery = _faery(other)
    if len(t) == 0:
        raise ParameterError(f"{path}: no events, an AEDAT4 file needs at least one; write {other}")
    packed = np.zeros(len(t), dtype=faery.EVENTS_DTYPE)
    packed["t"], packed["x"], packed["y"], packed["on"] = t, x, y, on
    with replace_atomic(path) as temporary:
        faery.events_stream_from_array(packed, dimensions=size).to_file(temporary)


def read_aedat4(path: str, other: str) -> tuple[I64, I64, I64, int]:
    """Return the events of a file: microseconds, columns and rows, int64[n] each, and its width in columns.

    other : what to read instead where `faery` is not installed, which raises `SimulatorError`. Raises
    `DataError` for a file that is none.
    """
    faery = _faery(other)
    try:
        stream = faery.events_stream_from_file(path)
        packed, (width, _) = stream.to_array(), stream.dimensions()
    except UNREADABLE as error:
        raise DataError(f"{path}: no AEDAT4 file of events, {' '.join(str(error).split())[:80]}") from None
    t, x, y = (packed[name].astype(np.int64) for name in ("t", "x", "y"))
    return t, x, y, int(width)


def _faery(other: str) -> Any:
    return extra("faery", f"faery: not installed, AEDAT4 needs it; pip install faery, or write {other}")
