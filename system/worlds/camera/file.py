"""Files of events: AEDAT4 for jAER and the dv tools, plain text, and numpy's npz.

Times are int64 microseconds; x counts from the left and y from the top, as these tools do.
"""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circuits.errors import DataError
from system.files import aedat4
from system.files.writing import check_folder, checked_suffix, write_bytes_atomic, write_text_atomic
from system.worlds.camera.event import Events

SUFFIXES = (aedat4.SUFFIX, ".npz", ".txt")
_OTHER = ".txt or .npz"  # which need nothing
HEADER = "# t_us x y on"
_MICRO = 1e6


def check_events(path: str) -> None:
    """Raise before anything is computed if events cannot be written to `path`.

    Raises
    ------
    ParameterError
        The suffix names no known format.
    SimulatorError
        AEDAT4 is asked for and `faery` is not installed.
    DataError
        There is no such folder.
    """
    suffix = checked_suffix(path, SUFFIXES)
    if suffix == aedat4.SUFFIX:
        aedat4.check_aedat4(_OTHER)
    check_folder(path)


def write_events(path: str, events: Events, columns: int = 128, rows: int = 128) -> None:
    """Write events in the format of the suffix of a path.

    The formats are .aedat4, .npz (arrays t, x, y, on) and .txt (four columns). Raises what `check_events`
    raises.

    Parameters
    ----------
    path
        Path of the file.
    events
        The events.
    columns, rows
        How many pixels the sensor has across and down.

    Raises
    ------
    DataError
        The file cannot be written.
    """
    check_events(path)
    suffix = Path(path).suffix.lower()
    t, x, y, on = _in_file_order(events, rows)
    if suffix == aedat4.SUFFIX:
        aedat4.write_aedat4(path, t, x, y, on, (columns, rows), _OTHER)
    elif suffix == ".npz":
        buffer = io.BytesIO()
        np.savez_compressed(buffer, t=t, x=x, y=y, on=on)
        write_bytes_atomic(path, buffer.getvalue())
    else:
        lines = (f"{a} {b} {c} {int(d)}" for a, b, c, d in zip(t, x, y, on, strict=True))
        write_text_atomic(path, "\n".join([HEADER, *lines, ""]))


def read_events(path: str, rows: int = 128) -> Events:
    """Read the events of a .txt or .npz file that `write_events` wrote.

    Parameters
    ----------
    path
        Path of the file.
    rows
        How many rows of pixels the sensor has.

    Raises
    ------
    DataError
        The file cannot be read as one.
    """
    try:
        if Path(path).suffix.lower() == ".npz":
            with Path(path).open("rb") as file, np.load(file) as held:  # numpy leaves a damaged file open
                t, x, y, on = (np.asarray(held[name], np.int64) for name in ("t", "x", "y", "on"))
        else:
            with warnings.catch_warnings(action="ignore", category=UserWarning):  # a file without an event
                t, x, y, on = np.loadtxt(path, dtype=np.int64, ndmin=2).reshape(-1, 4).T
    except aedat4.UNREADABLE as error:
        reason = " ".join(str(error).split())[:200]
        raise DataError(f"{path}: {reason}, must be events that write_events wrote, .txt or .npz") from None
    if t.ndim != 1 or len({a.shape for a in (t, x, y, on)}) > 1:
        raise DataError(f"{path}: t, x, y and on, must be lists of one length; write it with write_events")
    return Events(t / _MICRO, x, rows - 1 - y, on.astype(np.bool_))


def _in_file_order(events: Events, rows: int) -> tuple[NDArray[Any], ...]:
    return aedat4.microseconds(events.time), events.x, rows - 1 - events.y, events.on
