"""A film as a file: netCDF, an array a variable, and the rest of it as JSON in the attribute `film`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from importlib.metadata import version
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

from circuits.catalogue import later
from circuits.errors import DataError
from system.files.writing import write_netcdf_atomic
from system.view.film import Film

xr = later("xarray")


FORMAT = "noctule-run/1"
_ARRAY = "array"  # key of what stands for one

_Array = np.ndarray[Any, np.dtype[Any]]


def keep(path: str, film: Film) -> None:
    """Write a film into a netCDF file.

    Raises `DataError` if it cannot be written; an earlier file at `path` is then unchanged.
    """
    arrays: dict[int, tuple[str, _Array]] = {}
    text = json.dumps(_plain(film, arrays), allow_nan=False)
    data = xr.Dataset(
        {name: ((f"n_{name}",), _written(values)) for name, values in arrays.values()},
        attrs={"format": FORMAT, "version": version("noctule"), "film": text},
    )
    write_netcdf_atomic(path, data)


def kept(path: str) -> Film:
    """Read the film of a file that `keep` has written.

    Raises `DataError` for a file that is not there, or is of no run.
    """
    if not Path(path).is_file():
        raise DataError(f"{path}: no such file; noctule run SYSTEM -o RUN.nc makes one")
    try:
        with xr.open_dataset(path) as data:
            data.load()
            if data.attrs.get("format") != FORMAT:
                raise DataError(f"{path}: not a kept run; noctule run SYSTEM -o RUN.nc makes one")
            arrays = {str(name): values.to_numpy() for name, values in data.data_vars.items()}
            film: Film = _read(Film, json.loads(data.attrs["film"]), arrays)
            return film
    except (OSError, ValueError, KeyError, TypeError):
        raise DataError(f"{path}: not a kept run; noctule run SYSTEM -o RUN.nc makes one") from None


def _written(values: _Array) -> _Array:
    return values.astype(np.uint8) if values.dtype == np.bool_ else values


def _plain(value: Any, arrays: dict[int, tuple[str, _Array]]) -> Any:
    """What JSON holds; an array goes into `arrays` once, by its id."""
    if isinstance(value, np.ndarray):
        name, _ = arrays.setdefault(id(value), (f"a{len(arrays)}", value))
        return {_ARRAY: name}
    if is_dataclass(value):
        return {f.name: _plain(getattr(value, f.name), arrays) for f in fields(value)}
    if isinstance(value, Mapping):
        return dict(value)
    return [_plain(item, arrays) for item in value] if isinstance(value, tuple) else value


def _read(kind: Any, value: Any, arrays: Mapping[str, _Array]) -> Any:
    """What a JSON value stands for where a field is of a `kind`."""
    if isinstance(value, dict) and set(value) == {_ARRAY}:
        return arrays[value[_ARRAY]]
    if get_origin(kind) in {Union, UnionType}:
        kind = next((k for k in get_args(kind) if k is not type(None)), kind)
    if is_dataclass(kind) and isinstance(value, dict):
        hints = get_type_hints(kind)
        return kind(**{name: _read(hints[name], each, arrays) for name, each in value.items()})  # type: ignore[operator]
    if isinstance(value, list):
        inner = get_args(kind)
        return tuple(_read(inner[0] if inner else object, each, arrays) for each in value)
    return value
