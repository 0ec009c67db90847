"""Files of records: those in the user's cache folder, which take precedence, and those of the package.

`noctule characterise` writes into the cache folder, so that an installed package is never changed. The folder
is `NOCTULE_CACHE_DIR` where that is set, else `noctule` in the user's caches, as the XDG Base Directory
Specification (0.8) has them.

A record is of a process under a law, and its file's name says which (`record_name`): `NAME.nc` of AMI 1.5 um
under the ideal law, `NAME_full.nc` under the full law, `NAME_PROCESS_LAW.nc` of any other process, which the
cache folder alone has.
"""

from __future__ import annotations

import os
import re
from importlib.resources import files
from pathlib import Path

import h5py
import xarray as xr

from circuits.errors import DataError
from circuits.seal import check_sealed, sealed
from circuits.silicon.process import AMI_1500_IDEAL, PROCESSES, Process

ENVIRONMENT = "NOCTULE_CACHE_DIR"
_MEASURE = "run noctule characterise"
_MOST = 4_000_000  # numbers of a record, ours: a hundred times the largest that the package has


def cache_folder() -> Path:
    """Return the folder in which noctule keeps what it measured for this user; it need not exist."""
    chosen = os.environ.get(ENVIRONMENT)
    if chosen:
        return Path(chosen)
    caches = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if caches.is_absolute():  # any other is to be ignored, says the specification
        return caches / "noctule"
    try:
        return Path("~/.cache/noctule").expanduser()
    except RuntimeError:  # a user without a home has no caches: nothing can be in there
        return Path(os.devnull) / "noctule"


def record_name(block: str, process: Process = AMI_1500_IDEAL) -> str:
    """Return the name of the record of a block in a process, without the ending of its file."""
    name, effects = block.replace("-", "_"), process.effects
    if process.name == AMI_1500_IDEAL.name:
        return name if effects == "ideal" else f"{name}_{effects}"
    return f"{name}_{re.sub(r'[^A-Za-z0-9.-]', '-', process.name)}_{effects}"


def measured_by(block: str, process: Process = AMI_1500_IDEAL) -> str:
    """Return the command that measures a block's record in a process.

    Its options are told as fields, `law=full`, which the command line turns into its own words.
    """
    words = ["noctule characterise", block.replace("_", "-")]
    if process.effects != "ideal":
        words.append(f"law={process.effects}")
    if process.name != AMI_1500_IDEAL.name:
        words.append(f"process={process.name if process.name in PROCESSES else 'FILE'}")
    return " ".join(words)


def cached_file(block: str, process: Process = AMI_1500_IDEAL) -> Path:
    """Return the path of a block's record in the cache folder; it need not exist."""
    return cache_folder() / "records" / f"{record_name(block, process)}.nc"


def shipped_file(block: str, process: Process = AMI_1500_IDEAL) -> Path:
    """Return the path of a block's record in the package; it need not exist."""
    return _shipped_folder() / f"{record_name(block, process)}.nc"


def _shipped_folder() -> Path:
    return Path(str(files("chips"))) / "records"


def record_file(block: str, process: Process = AMI_1500_IDEAL) -> Path:
    """Return the path of the record that is read for a block: the user's own, else the package's.

    Raises `DataError` where there is neither.
    """
    for path in (cached_file(block, process), shipped_file(block, process)):
        if os.access(path, os.R_OK):
            return path
    raise DataError(f"{record_name(block, process)}: no record; run {measured_by(block, process)}")


def save_record(data: xr.Dataset, path: Path) -> None:
    """Write a record's netCDF file with its seal."""
    path.write_bytes(sealed(data.to_netcdf(engine="h5netcdf")))  # in memory: HDF5 crashes on a full disk


def load_record(path: Path) -> xr.Dataset:
    """Return the contents of a record's file; raises `DataError` for a file that is none.

    A file outside the package must be as it was written, which its seal tells.
    """
    try:
        _check(path)
        with xr.open_dataset(path, engine="h5netcdf") as data:
            return data.load()
    except (OSError, KeyError, ValueError, RuntimeError, TypeError) as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise DataError(f"{path}: no record, {reason}; delete it, or {_MEASURE}") from None


def _check(path: Path) -> None:
    """Raise `ValueError`, or what h5py raises, for a damaged file, which xarray would leave half open."""
    if path.resolve().parent != _shipped_folder().resolve():
        with path.open("rb") as contents:
            check_sealed(contents)
    sizes: list[int] = []
    with h5py.File(path, "r") as file:
        file.visititems(lambda _, item: sizes.append(getattr(item, "size", None) or 0))
    if sum(sizes) > _MOST:
        raise ValueError(f"{sum(sizes)} numbers, must be at most {_MOST}")


def stale(
    block: str, reason: str = "another circuit or process", process: Process = AMI_1500_IDEAL
) -> DataError:
    """Return the error for a record of other circuits, or of another law, than its model stands for."""
    own, name = cached_file(block, process), record_name(block, process)
    measured_again = f"run {measured_by(block, process)}"
    if os.access(own, os.R_OK):
        where = f" ({own}, which goes before the package's)"
        return DataError(f"{name}: its record{where} is of {reason}; {measured_again}, or delete it")
    return DataError(f"{name}: its record is of {reason}; {measured_again}")
