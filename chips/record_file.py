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
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from circuits.catalogue import later
from circuits.errors import DataError
from circuits.seal import check_sealed, sealed
from circuits.silicon.process import AMI_1500_IDEAL, PROCESSES, Process

if TYPE_CHECKING:
    import xarray as xr

h5py = later("h5py")  # reads a file in a tenth of the time that importing xarray takes

ENVIRONMENT = "NOCTULE_CACHE_DIR"
_MEASURE = "run noctule characterise"
_UNNUMBERED = b"This is a netCDF dimension but not a netCDF variable"  # a dimension without coordinates
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


@dataclass(frozen=True, slots=True)
class Contents:
    """What a record's file holds.

    attributes: by their names; axes: numbers or names along each dimension that has any; tables: for each
    variable its dimensions and its values.
    """

    attributes: Mapping[str, Any]
    axes: Mapping[str, Any]
    tables: Mapping[str, tuple[tuple[str, ...], Any]]


def load_record(path: Path) -> Contents:
    """Return the contents of a record's file; raises `DataError` for a file that is none.

    A file outside the package must be as it was written, which its seal tells.
    """
    try:
        if path.resolve().parent != _shipped_folder().resolve():
            with path.open("rb") as contents:
                check_sealed(contents)
        with h5py.File(path, "r") as file:
            return _contents(file)
    except (OSError, LookupError, ValueError, RuntimeError, TypeError, AttributeError) as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise DataError(f"{path}: no record, {reason}; delete it, or {_MEASURE}") from None


def _contents(file: Any) -> Contents:
    """What an open file holds; raises `ValueError`, or what h5py raises, for one of other contents."""
    if not all(isinstance(item, h5py.Dataset) for item in file.values()):
        raise ValueError("it holds what is no array")
    count = sum(item.size or 0 for item in file.values())
    if count > _MOST:
        raise ValueError(f"{count} numbers, must be at most {_MOST}")
    axes, tables = {}, {}
    for name, item in file.items():
        if not item.is_scale:
            tables[name] = tuple(d[0].name.removeprefix("/") for d in item.dims), _values(item)
        elif not item.attrs["NAME"].startswith(_UNNUMBERED):
            axes[name] = _values(item)
    return Contents({name: _plain(value) for name, value in file.attrs.items()}, axes, tables)


def _values(item: Any) -> Any:
    """Numbers of a variable, or its names."""
    return item[()] if h5py.check_string_dtype(item.dtype) is None else item.asstr()[()]


def _plain(value: Any) -> Any:
    """An attribute, of which one number or name is an array of one in a netCDF file."""
    if getattr(value, "shape", None) == (1,):
        value = value[0]
    return value.decode() if isinstance(value, bytes) else value


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
