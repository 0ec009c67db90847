"""Files of programs of the NEF chip: a network of values, and the codes that stand for it.

The TOML file has the network and what is exact and approximate; the file of the same name with `.npz` at its
end has the codes (`system.mapping.nef.mapped.codes_of`), float64[n] each.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import tomli_w

from circuits.errors import DataError, ParameterError
from system.files.document import converted, plain
from system.files.writing import checked_suffix, write_text_atomic
from system.mapping.nef.mapped import MappedValues, codes_of, mapped_with
from system.mapping.nef.network import ValueNetwork
from system.mapping.network_file import SUFFIX, array_of, tables_of, without_none, write_arrays
from system.mapping.report import Finding
from system.table import read_table

FORMAT: Literal["noctule-program/1"] = "noctule-program/1"
_REMEDY = "noctule map writes such a file"


@dataclass(frozen=True, slots=True)
class ValueProgramFile:
    """A network of values on the NEF chip.

    Attributes
    ----------
    format, chip : str
        Which format it is, and the chip.
    network : dict
        What was asked for, with the tables of its file.
    codes : str
        Name of the file beside it that has the codes.
    findings : tuple of Finding
        What is exact and what is approximate.
    """

    format: Literal["noctule-program/1"]
    chip: Literal["nef"]
    network: dict[str, Any]
    codes: str
    findings: tuple[Finding, ...] = ()


def write_value_program(path: str | Path, mapped: MappedValues) -> None:
    """Write `mapped` to the program at `path`, its codes beside it; raises as `write_network`."""
    checked_suffix(path, (SUFFIX,))
    arrays = Path(path).with_suffix(".npz")
    tables, _ = tables_of(mapped.network, arrays.name)
    document = ValueProgramFile(FORMAT, "nef", tables, arrays.name, mapped.findings)
    write_arrays(arrays, codes_of(mapped))
    write_text_atomic(path, tomli_w.dumps(without_none(plain(document))))


def read_value_program(tables: dict[str, Any], where: Path) -> MappedValues:
    """Return the program of a TOML document's `tables`; where: its file.

    Raises `DataError`, which names file and key, where it or its file of codes is none.
    """
    found = converted(tables, ValueProgramFile, str(where), _REMEDY)
    try:
        network = read_table(ValueNetwork, found.network)
        codes = {name: array_of(where.parent / found.codes, name) for name in ("bias", "stages", "decoders")}
        return mapped_with(network, codes, found.findings)
    except (ParameterError, LookupError) as error:
        raise DataError(f"{where}: {error}") from None
