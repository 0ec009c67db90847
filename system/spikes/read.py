"""Files of address-events read back: a stream that a chip takes, in the format of its suffix.

| suffix | what is read |
|---|---|
| .csv, .npz | what `write_spikes` writes: times in s, and addresses |
| .aedat4 | times in whole microseconds; the column of an event, and its row times the width, as address |

Any other program's file of these formats is taken alike. Names of addresses are left out.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path

import numpy as np

from chips.aer import Events
from circuits.arrays import F64, I64
from circuits.errors import DataError
from system.files import aedat4
from system.files.text import read_text
from system.files.writing import checked_suffix

_OTHER = ".npz or .csv"  # which need nothing
_COLUMNS = ("time_s", "address")
_Read = tuple[F64, I64]


def read_spikes(path: str) -> Events:
    """Read the address-events of a file: times (s) in order, and addresses.

    Parameters
    ----------
    path
        Path of a .csv, .npz or .aedat4.

    Raises
    ------
    ParameterError
        The suffix names no format that is read.
    SimulatorError
        AEDAT4 needs a library that is not installed.
    DataError
        The file is none, its times go backwards, or an address is below 0.
    """
    found = _READERS[checked_suffix(path, tuple(_READERS))](path)
    times, addresses = found
    if times.shape != addresses.shape or times.ndim != 1:
        raise DataError(f"{path}: {times.size} times and {addresses.size} addresses, must be as many")
    wrong = np.flatnonzero(~np.isfinite(times) | (np.diff(times, prepend=-np.inf) < 0.0))
    if wrong.size:
        k = int(wrong[0])
        before = "" if k == 0 else f", after {times[k - 1]:g} s"
        raise DataError(
            f"{path}: event {k} at {times[k]:g} s{before}, times must be finite and rise; sort them"
        )
    if addresses.size and addresses.min() < 0:
        k = int(np.argmin(addresses))
        raise DataError(f"{path}: event {k} of address {addresses[k]}, must be 0 at least")
    return Events(times, addresses)


def _csv(path: str) -> _Read:
    text = read_text(path, "address-events")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    table = csv.DictReader(io.StringIO("\n".join(lines)))
    missing = [name for name in _COLUMNS if name not in (table.fieldnames or ())]
    if missing:
        raise DataError(f"{path}: no column {', '.join(missing)}; write_spikes writes such a file")
    rows = list(table)
    try:
        times, addresses = ([row[name] for row in rows] for name in _COLUMNS)
        return np.array(times, dtype=np.float64), np.array(addresses, dtype=np.int64)
    except (TypeError, ValueError) as error:
        raise DataError(f"{path}: {error}; times are numbers, addresses whole ones") from None


def _npz(path: str) -> _Read:
    try:
        with Path(path).open("rb") as opened, np.load(opened, allow_pickle=False) as held:
            times, addresses = (held[name] for name in _COLUMNS)
    except aedat4.UNREADABLE as error:
        raise DataError(f"{path}: no file of events, {' '.join(str(error).split())[:80]}") from None
    if addresses.dtype.kind not in "iu" or times.dtype.kind not in "iuf":
        raise DataError(
            f"{path}: {times.dtype} times, {addresses.dtype} addresses; must be numbers, whole ones"
        )
    return times.astype(np.float64), addresses.astype(np.int64)


def _aedat4(path: str) -> _Read:
    t, x, y, width = aedat4.read_aedat4(path, _OTHER)
    return np.asarray(1e-6 * t, dtype=np.float64), x + width * y


_READERS: dict[str, Callable[[str], _Read]] = {".csv": _csv, ".npz": _npz, aedat4.SUFFIX: _aedat4}
