"""Files of programs: a network as it stands on a chip, in TOML that `noctule map` writes.

Everything that a run needs is in it: the network that was asked for, where it stands, the codes of all
biases, the level of each synapse and how many events stand for one of an input. Matrices are rows of
characters, so that a program can be read and compared by eye:

    levels            row: receiving neuron, column: sending one; . none, 1 to 4 excite, a to d inhibit
    excite, inhibit   row: channel of an input, column: neuron; . none, then 1 to 9, a for 10 up to w for 32

Numbers are SI. Matrices of the network that are too large stand in a file of the same name with `.npz`.
"""

from __future__ import annotations

import string
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
import tomli_w

from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable, default_biases
from chips.rolls.program.program import Program
from circuits.arrays import I64
from circuits.errors import DataError, ParameterError
from system.files.document import converted, plain, toml_file
from system.files.writing import check_folder, checked_suffix, write_text_atomic
from system.mapping.network_file import (
    SUFFIX,
    check_arrays,
    network_of,
    tables_of,
    without_none,
    write_arrays,
)
from system.mapping.report import Finding
from system.mapping.rolls.mapped import Mapped, Placed, PlacedFilter, virtual_inputs

FORMAT: Literal["noctule-program/1"] = "noctule-program/1"
_COUNTS = f".{string.digits[1:]}{string.ascii_lowercase}"
_LEVELS = {0: ".", **{k: str(k) for k in range(1, 5)}, **{-k: "abcd"[k - 1] for k in range(1, 5)}}
_OF = {mark: level for level, mark in _LEVELS.items()}
_REMEDY = "noctule map writes such a file"
_Code = tuple[Annotated[int, msgspec.Meta(ge=0, le=7)], Annotated[int, msgspec.Meta(ge=0, le=255)]]


@dataclass(frozen=True, slots=True)
class ProgramFile:
    """A network on a chip.

    Attributes
    ----------
    format : str
        Which format it is.
    chip : str
        The chip.
    network : dict
        The network, with the tables of a network's file.
    placed : tuple of Placed
        Populations on the chip.
    filters : tuple of PlacedFilter
        Filters that are in use.
    biases : dict
        Coarse and fine code of each bias by its name.
    levels : tuple of str
        Level of each synapse, a row each receiving neuron.
    excite, inhibit : tuple of str
        Events of a virtual synapse for one of a channel, a row each channel.
    findings : tuple of Finding
        What is exact and what is approximate.
    """

    format: Literal["noctule-program/1"]
    chip: Literal["rolls"]
    network: dict[str, Any]
    placed: tuple[Placed, ...]
    filters: tuple[PlacedFilter, ...]
    biases: dict[str, _Code]
    levels: tuple[str, ...]
    excite: tuple[str, ...] = ()
    inhibit: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()


def write_program(path: str | Path, mapped: Mapped) -> None:
    """Write `mapped`, a network on its chip, to the program at `path`; raises as `write_network`."""
    checked_suffix(path, (SUFFIX,))
    arrays = Path(path).with_suffix(".npz")
    tables, large = tables_of(mapped.network, arrays.name)
    n = mapped.network.neurons
    document = ProgramFile(
        FORMAT, "rolls", tables, mapped.placed, mapped.filters, dict(mapped.program.biases.codes()),
        tuple("".join(_LEVELS[int(k)] for k in row) for row in mapped.program.levels[:n, :n]),
        _rows(mapped.excite), _rows(mapped.inhibit), mapped.findings,
    )  # fmt: skip
    if large:
        write_arrays(arrays, large)
    write_text_atomic(path, tomli_w.dumps(without_none(plain(document))))


def check_program_path(path: str) -> None:
    """Raise before anything is computed if a program cannot be written to `path`, as `write_program` says."""
    checked_suffix(path, (SUFFIX,))
    check_folder(path)
    check_arrays(Path(path).with_suffix(".npz"))


def read_program_file(path: str | Path) -> Mapped:
    """Read the program that `write_program` wrote to `path`.

    Raises `DataError`, which names file and key, where it cannot be read or is none.
    """
    where = Path(path)
    return read_program(toml_file(where), where)


def read_program(tables: dict[str, Any], where: Path) -> Mapped:
    """Return the program of a TOML document's `tables`; where: its file. Raises as `read_program_file`."""
    if tables.get("chip") == "nef":
        raise DataError(f"{where}: a program of nef, must be of rolls; map a network of populations on that")
    found = converted(tables, ProgramFile, str(where), _REMEDY)
    try:
        return _mapped(found, where)
    except (ParameterError, LookupError) as error:
        raise DataError(f"{where}: {error}") from None


def _mapped(found: ProgramFile, where: Path) -> Mapped:
    network = network_of(found.network, where.parent)
    sizes = {p.name: p.size for p in network.populations}
    if [p.name for p in found.placed] != list(sizes):
        raise ParameterError(f"placed: must be {', '.join(sizes)}, in this order; map the network again")
    ends = [p.first + sizes[p.name] for p in found.placed]
    if min(p.first for p in found.placed) < 0 or max(ends) > NEURONS:
        raise ParameterError(f"placed: neuron {max(ends) - 1}, must be 0 to {NEURONS - 1}; map it again")
    size = min(max(ends), NEURONS)
    levels = _matrix("levels", found.levels, _OF, (size, size))
    counts = {mark: k for k, mark in enumerate(_COUNTS)}
    shape = network.channels, network.neurons
    excite, inhibit = (_matrix(name, getattr(found, name), counts, shape) for name in ("excite", "inhibit"))
    slow = tuple(k for p in found.placed if p.slow for k in range(p.first, p.first + sizes[p.name]))
    inputs = virtual_inputs(size, excite, inhibit)
    program = Program(levels.astype(np.int8), _biases(found), slow, inputs)
    return Mapped(network, found.placed, found.filters, program, excite, inhibit, found.findings)


def _biases(found: ProgramFile) -> BiasTable:
    table = default_biases()
    for name, code in found.biases.items():
        table = table.with_code(name, *code)
    return table


def _rows(counts: I64) -> tuple[str, ...]:
    return tuple("".join(_COUNTS[k] for k in row) for row in counts) if counts.any() else ()


def _matrix(name: str, rows: tuple[str, ...], of: dict[str, int], shape: tuple[int, int]) -> I64:
    if not rows and name != "levels":
        return np.zeros(shape, dtype=np.int64)
    if len(rows) != shape[0]:
        raise ParameterError(f"{name}: {len(rows)} rows, must be {shape[0]}; map the network again")
    found = np.zeros(shape, dtype=np.int64)
    for k, row in enumerate(rows):
        wrong = next((mark for mark in row if mark not in of), None)
        if wrong is not None or len(row) != shape[1]:
            what = f'"{wrong}"' if wrong is not None else f"{len(row)} columns"
            raise ParameterError(f"{name}[{k}]: {what}, must be {shape[1]} of {''.join(of)}")
        found[k] = [of[mark] for mark in row]
    return found
