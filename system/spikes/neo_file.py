"""Files of spikes that Neo writes (BSD): NWB through pynwb, NIX through nixio; an optional extra.

Neo is imported here alone. A file has one block with one segment, the run, and in it a spike train for each
address, in their order, with its name; times are seconds from the beginning of the run. NIX keeps the number
of the address as the annotation `address`; in NWB it is the train's row in the table of units. NWB asks for a
date at which the run began: it has none, and 1970-01-01 UTC stands there. Identifier of an NWB file is the
SHA-256 of the spikes that it holds.
"""

from __future__ import annotations

import datetime as dt
import hashlib
import warnings
from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.errors import SimulatorError
from system.files.writing import temporary_folder, write_bytes_atomic

NEEDS = {".nwb": "pynwb", ".nix": "nixio"}  # what Neo writes each format through
TIME_BASE = "times in s from the beginning of the run"
_BEGAN = dt.datetime(1970, 1, 1, tzinfo=dt.UTC)


def check_neo(suffix: str, other: str) -> None:
    """Raise `SimulatorError` where a format's libraries are not installed; other: what to write instead."""
    missing = [name for name in ("neo", NEEDS[suffix]) if find_spec(name) is None]
    if missing:
        verb = "needs it" if len(missing) == 1 else "needs them"
        raise SimulatorError(
            f"{', '.join(missing)}: not installed, {suffix} {verb}; pip install {' '.join(missing)},"
            f" or write {other}"
        )


def write_neo(path: str, trains: Mapping[str, F64], stop: float) -> None:
    """Write spike trains, whole or not at all; stop: end of the run, s.

    HDF5 locks the file that it writes: it is made in a folder of its own.
    """
    suffix = Path(path).suffix.lower()
    with temporary_folder() as folder, warnings.catch_warnings(action="ignore"):
        made = folder / f"spikes{suffix}"
        neo = import_module("neo")
        block = _block(neo, trains, stop)
        if suffix == ".nwb":
            neo.io.NWBIO(str(made), mode="w").write_all_blocks([block])
        else:
            with neo.io.NixIO(str(made), mode="ow") as file:
                file.write_block(block)
        data = made.read_bytes()
    write_bytes_atomic(path, data)


def _block(neo: Any, trains: Mapping[str, F64], stop: float) -> Any:
    segment = neo.Segment(name="run")
    for address, (name, times) in enumerate(trains.items()):
        segment.spiketrains.append(
            neo.SpikeTrain(times, units="s", t_start=0.0, t_stop=stop, name=name, address=address)
        )
    block = neo.Block(
        name="noctule", session_start_time=_BEGAN, session_description=f"spikes, {TIME_BASE}",
        identifier=_identifier(trains, stop),
    )  # fmt: skip
    block.segments.append(segment)
    return block


def _identifier(trains: Mapping[str, F64], stop: float) -> str:
    found = hashlib.sha256(repr((stop, list(trains))).encode())
    for times in trains.values():
        found.update(np.ascontiguousarray(times, dtype="<f8").tobytes() + b"|")
    return found.hexdigest()
