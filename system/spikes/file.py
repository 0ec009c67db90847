"""Files of spikes, in the format of their suffix.

| suffix | times | addresses |
|---|---|---|
| .csv | float64, s | numbers and names, a row a spike; a line above says what they are |
| .npz | `time_s`, float64, s | `address`, int64, and `name`, one an address; `stop_s`, end of the run |
| .aedat4 | int64, whole microseconds | column of an event; polarity on; names have no place |
| .nwb, .nix | float64, s | one train an address, with its name (`system.spikes.neo_file`) |

Addresses count from 0 in the order of the trains. Spikes are in the order of their times, those of one time
in that of their addresses. All times are from the beginning of the run.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from circuits.arrays import F64, I64
from circuits.errors import ParameterError
from system.files import aedat4
from system.files.writing import check_folder, checked_suffix, write_bytes_atomic, write_text_atomic
from system.spikes.neo_file import NEEDS, TIME_BASE, check_neo, write_neo

SUFFIXES = (aedat4.SUFFIX, ".npz", ".csv", *NEEDS)
HEADER = ("time_s", "address", "name")
_OTHER = ".npz or .csv"  # which need nothing


def check_spikes(path: str) -> None:
    """Raise before anything is computed if spikes cannot be written to `path`.

    Raises
    ------
    ParameterError
        The suffix names no known format.
    SimulatorError
        The format needs a library that is not installed.
    DataError
        There is no such folder.
    """
    suffix = checked_suffix(path, SUFFIXES)
    if suffix == aedat4.SUFFIX:
        aedat4.check_aedat4(_OTHER)
    elif suffix in NEEDS:
        check_neo(suffix, _OTHER)
    check_folder(path)


def write_spikes(path: str, trains: Mapping[str, F64], stop: float) -> None:
    """Write spikes in the format of the suffix of a path, as `result.spikes` of a simulation has them.

    The formats are .aedat4, .npz, .csv, .nwb and .nix; a file is written whole or not at all. Raises what
    `check_spikes` raises.

    Parameters
    ----------
    path
        Path of the file.
    trains
        Times of the spikes by the name of where they came from, float64[n], s, from the beginning of the run;
        its address is its place in this order.
    stop
        End of the run, s.

    Raises
    ------
    ParameterError
        A time is not finite, below 0 or after the end; AEDAT4 is asked for without a spike, or for more than
        65535 addresses.
    DataError
        The file cannot be written.
    """
    check_spikes(path)
    given = {name: np.sort(np.asarray(times, dtype=np.float64)) for name, times in trains.items()}
    for name, times in given.items():
        wrong = times[~((times >= 0.0) & (times <= stop))]
        if wrong.size:
            raise ParameterError(f"{name}: spike at {wrong[0]:g} s, must be within the run, 0 to {stop:g} s")
    suffix = Path(path).suffix.lower()
    if suffix in NEEDS:
        write_neo(path, given, stop)
        return
    time, address = _in_order(given)
    if suffix == aedat4.SUFFIX:
        _write_aedat4(path, time, address, len(given))
    elif suffix == ".npz":
        write_bytes_atomic(path, _npz(time, address, list(given), stop))
    else:
        write_text_atomic(path, _csv(time, address, list(given), stop))


def _in_order(trains: Mapping[str, F64]) -> tuple[F64, I64]:
    time = np.concatenate([np.empty(0), *trains.values()])
    address = np.repeat(np.arange(len(trains)), [times.size for times in trains.values()])
    order = np.argsort(time, kind="stable")
    return time[order], address[order].astype(np.int64)


def _write_aedat4(path: str, time: F64, address: I64, count: int) -> None:
    if count > aedat4.WIDEST:
        raise ParameterError(
            f"{path}: {count} addresses, AEDAT4 has room for {aedat4.WIDEST}; write {_OTHER}"
        )
    t, on = aedat4.microseconds(time), np.ones(time.size, dtype=np.bool_)
    aedat4.write_aedat4(path, t, address, np.zeros_like(address), on, (count, 1), _OTHER)


def _npz(time: F64, address: I64, names: list[str], stop: float) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer, time_s=time, address=address, name=np.array(names, dtype=np.str_), stop_s=stop,
        time_base=TIME_BASE,
    )  # fmt: skip
    return buffer.getvalue()


def _csv(time: F64, address: I64, names: list[str], stop: float) -> str:
    text = io.StringIO()
    text.write(f"# {TIME_BASE}, which ended at {stop!r} s; addresses: {len(names)}, from 0\n")
    table = csv.writer(text, lineterminator="\n")
    table.writerow(HEADER)
    table.writerows((repr(t), a, names[a]) for t, a in zip(time.tolist(), address.tolist(), strict=True))
    return text.getvalue()
