"""Arrays of a page: numbers as a reader needs them, deflated, with what tells how to read them.

Each array is laid out by its bytes' significance, all lowest bytes first, which deflates to less. Times that
rise are kept as steps of a quantum, so that two million events take a few megabytes.
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np

_LONG = 1024  # numbers from which rising times are kept as steps; ours
_QUANTA = 1e8  # in the range of such times; ours: 0.6 us of a minute


class Arrays:
    """Arrays that go into one block of bytes."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.size = 0
        self._known: dict[int, tuple[np.ndarray[Any, np.dtype[Any]], dict[str, Any]]] = {}

    def add(self, values: np.ndarray[Any, np.dtype[Any]]) -> dict[str, Any]:
        """Take an array in, and return where and how it stands: for a JSON document.

        The entry has `type`, as of numpy's without the order of bytes, `at`, its first byte, and `length`;
        steps of times have `from` and `quantum`, s. An array that is in already is not taken again.
        """
        if id(values) not in self._known:
            self._known[id(values)] = values, self._added(values)  # the array too, or its id is another's
        return self._known[id(values)][1]

    def _added(self, values: np.ndarray[Any, np.dtype[Any]]) -> dict[str, Any]:
        found: dict[str, Any] = {"length": int(values.size)}
        if values.dtype == np.bool_:
            values = values.astype(np.uint8)
        elif values.dtype.kind in "iu":
            values = values.astype(_least(values))
        elif values.size >= _LONG and np.all(np.diff(values) >= 0.0):
            span = float(values[-1] - values[0])
            found |= {"from": float(values[0]), "quantum": span / _QUANTA or 1.0}
            ticks = np.round((values - values[0]) / found["quantum"]).astype(np.uint32)
            values = np.diff(ticks, prepend=np.uint32(0))
        else:
            values = values.astype(np.float32)
        width = values.dtype.itemsize
        planes = np.ascontiguousarray(values).view(np.uint8).reshape(-1, width).T
        found |= {"type": values.dtype.str.lstrip("<>|="), "at": self.size}
        self.parts.append(planes.tobytes())
        self.size += values.nbytes
        return found

    def text(self) -> str:
        """Return all of them deflated (zlib), as base64 text."""
        return base64.b64encode(zlib.compress(b"".join(self.parts), 6)).decode("ascii")


def _least(values: np.ndarray[Any, np.dtype[Any]]) -> type[np.generic]:
    """The smallest type without a sign that holds all values, which are not below 0."""
    most = int(values.max()) if values.size else 0
    return np.uint8 if most < 2**8 else np.uint16 if most < 2**16 else np.uint32
