"""Files of records: those in the user's cache folder, which take precedence, and those of the package.

`noctule characterise` writes into the cache folder, so that an installed package is never changed. The folder
is `NOCTULE_CACHE_DIR` where that is set, else `noctule` in the user's caches, as the XDG Base Directory
Specification (0.8) has them.
"""

from __future__ import annotations

import os
from importlib.resources import files
from pathlib import Path

import h5py
import xarray as xr

from circuits.errors import DataError
from circuits.seal import check_sealed, sealed

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


def cached_file(block: str) -> Path:
    """Return the path of a block's record in the cache folder; it need not exist."""
    return cache_folder() / "records" / _name(block)


def shipped_file(block: str) -> Path:
    """Return the path of a block's record in the package; it need not exist."""
    return Path(str(files("chips"))) / "records" / _name(block)


def record_file(block: str) -> Path:
    """Return the path of the record that is read for a block: the user's own, else the package's.

    Raises `DataError` where there is neither.
    """
    for path in (cached_file(block), shipped_file(block)):
        if os.access(path, os.R_OK):
            return path
    raise DataError(f"{block}: no record; {_MEASURE}")


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
    if path.resolve().parent != shipped_file("").resolve().parent:
        with path.open("rb") as contents:
            check_sealed(contents)
    sizes: list[int] = []
    with h5py.File(path, "r") as file:
        file.visititems(lambda _, item: sizes.append(getattr(item, "size", None) or 0))
    if sum(sizes) > _MOST:
        raise ValueError(f"{sum(sizes)} numbers, must be at most {_MOST}")


def stale(block: str, reason: str = "another circuit or process") -> DataError:
    """Return the error for a record of other circuits, or of another law, than its model stands for."""
    own = cached_file(block)
    measured_again = f"{_MEASURE} {block.replace('_', '-')}"
    if os.access(own, os.R_OK):
        where = f" ({own}, which goes before the package's)"
        return DataError(f"{block}: its record{where} is of {reason}; {measured_again}, or delete it")
    return DataError(f"{block}: its record is of {reason}; {measured_again}")


def _name(block: str) -> str:
    return f"{block.replace('-', '_')}.nc"
