"""Files of networks, TOML that a user writes (`system.mapping.network` says what the numbers mean).

    [[population]]  name, size, tau, refractory, leak
    [[input]]       name, size
    [[connection]]  from, to, weight, rule, tau, to_itself, probability, seed, matrix
    [[probe]]       name, population, tau

A time is a text with its unit, as "20ms". `matrix` is a list of rows, or "FILE.npz:NAME" of a file beside.
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from dataclasses import MISSING
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from circuits.arrays import F64
from circuits.errors import CircuitError, DataError, ParameterError
from system.files.aedat4 import UNREADABLE
from system.files.document import toml_file
from system.files.writing import checked_suffix, write_bytes_atomic, write_text_atomic
from system.mapping.network import Network
from system.option import settings
from system.table import read_table

SUFFIX = ".toml"
_OWN = re.compile(r"connection\d+|bias|stages|decoders")  # arrays of networks and programs
INLINE = 1024  # entries of a matrix up to which it stands in the TOML itself; ours


def read_network(path: str | Path) -> Network:
    """Read the network of the TOML file at `path`.

    Raises `DataError`, which names file and key, where it or an array that it names is none.
    """
    where = Path(path)
    try:
        return network_of(toml_file(where), where.parent)
    except (ParameterError, LookupError) as error:
        raise DataError(f"{where}: {error}") from None


def network_of(tables: Mapping[str, Any], folder: Path) -> Network:
    """Return the network of a TOML document's tables; folder: where its arrays are."""
    found = dict(tables)
    connections = found.get("connection")
    if isinstance(connections, list):
        found["connection"] = [_with_matrix(one, folder) for one in connections]
    return read_table(Network, found)


def write_network(path: str | Path, network: Any) -> None:
    """Write `network`, of any kind, to the TOML file at `path`.

    Large matrices of populations go beside it, to the file with `.npz` at its end.

    Raises `ParameterError` for a path that does not end with `.toml`, or where the `.npz` has other arrays,
    and `DataError` where it cannot write.
    """
    checked_suffix(path, (SUFFIX,))
    arrays = Path(path).with_suffix(".npz")
    tables, large = tables_of(network, arrays.name)
    if large:
        write_arrays(arrays, large)
    write_text_atomic(path, tomli_w.dumps(tables))


def tables_of(network: Any, arrays: str) -> tuple[dict[str, Any], dict[str, F64]]:
    """Return a network of any kind as tables of TOML, and by name the matrices for the file `arrays`."""
    large: dict[str, F64] = {}
    tables: dict[str, Any] = {}
    kind: Any = type(network)
    for key, one in settings(kind).items():
        if not isinstance(getattr(network, one.field), tuple):
            tables[key] = getattr(network, one.field)
            continue
        rows = [_row(each) for each in getattr(network, one.field)]
        for k, row in enumerate(rows):
            matrix = np.array(row.get("matrix", ()))
            if matrix.size > INLINE:
                large[f"{key}{k}"] = matrix
                row["matrix"] = f"{arrays}:{key}{k}"
        if rows:
            tables[key] = rows
    return tables, large


def write_arrays(path: Path, arrays: Mapping[str, F64]) -> None:
    """Write a file of arrays of a network or program; raises as `check_arrays`, and where it cannot write."""
    check_arrays(path)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    write_bytes_atomic(path, buffer.getvalue())


def check_arrays(path: Path) -> None:
    """Raise `ParameterError` where there is a file at `path` already that is of no network or program."""
    if not path.exists():
        return
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as held:
            own = all(_OWN.fullmatch(name) for name in held)
    except UNREADABLE:
        own = False
    if not own:
        raise ParameterError(
            f"{path}: is there, of other arrays than a network's, which would be lost; give another name"
        )


def without_none(value: Any) -> Any:
    """Return a document without keys that have None: TOML has no null."""
    if isinstance(value, dict):
        return {k: without_none(v) for k, v in value.items() if v is not None}
    return [without_none(v) for v in value] if isinstance(value, list | tuple) else value


def _row(thing: Any) -> dict[str, Any]:
    """What differs from its default, by key."""
    found = {}
    kind: Any = type(thing)
    for key, one in settings(kind).items():
        value = getattr(thing, one.field)
        if one.default is MISSING or value != one.default:
            found[key] = f"{float(value)!r}s" if one.option.unit == "s" else value
    return found


def _with_matrix(one: Any, folder: Path) -> Any:
    """A connection's table with the matrix that it names."""
    named = one.get("matrix") if isinstance(one, dict) else None
    if not isinstance(named, str):
        return one
    file, colon, key = named.rpartition(":")
    if not colon:
        raise ParameterError(f'matrix: "{named}", must be rows of numbers, or "FILE.npz:NAME"')
    return {**one, "matrix": array_of(folder / file, key).tolist()}


def array_of(path: Path, key: str) -> F64:
    """Return the array of a name in a file of arrays; raises `DataError` where it cannot be read."""
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as held:
            found = held[key]
            return np.asarray(found, dtype=np.float64)
    except CircuitError:
        raise
    except UNREADABLE as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())[:80]
        raise DataError(f"{path}: {reason}, must have an array {key}") from None
