"""Which module of Verilog-A the transistors of each polarity are: a file of TOML.

    [n]
    file = "mos.va"              # beside this file
    module = "mos"               # where the file has several
    width = "w"                  # names of the sizes among the module's parameters
    length = "l"
    multiplicity = "m"           # left out where it has none: then currents and charges are multiplied
    [n.parameters]
    vto = 0.5

and `[p]` likewise. The module's first four terminals are drain, gate, source and bulk.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from circuits.errors import DataError, unknown_name
from circuits.silicon.process import POLARITIES, Polarity
from circuits.silicon.toml_file import read_toml
from netlists.verilog_a.host.module import Module, compile_module

_KEYS = ("file", "module", "width", "length", "multiplicity", "parameters")


@dataclass(frozen=True, slots=True)
class Model:
    """What the transistors of a polarity are.

    module: the compiled module. parameters: its parameters but for sizes. width, length, multiplicity: names
    of the sizes among its parameters; the last is empty where it has none.
    """

    module: Module
    parameters: Mapping[str, float]
    width: str = "w"
    length: str = "l"
    multiplicity: str = ""

    def sized(self, width: float, length: float, multiplicity: float) -> dict[str, float]:
        """Parameters of an instance; sizes in m."""
        sizes = {self.width: width, self.length: length}
        return {
            **self.parameters,
            **sizes,
            **({self.multiplicity: multiplicity} if self.multiplicity else {}),
        }


def read_models(path: Path) -> dict[Polarity, Model]:
    """Read the models of both polarities.

    Raises
    ------
    DataError
        The file cannot be read, is no TOML, or lacks a polarity or a module's file.
    UnknownNameError
        A key, a module or a parameter that is not known.
    SimulatorError
        The compiler is not installed.
    """
    given = read_toml(path, "a file of models")
    for key in given:
        if key not in POLARITIES:
            raise unknown_name(f"{path}: polarity", key, POLARITIES)
    return {polarity: _model(path, polarity, given.get(polarity)) for polarity in POLARITIES}


def _model(path: Path, polarity: str, table: Any) -> Model:
    if not isinstance(table, dict) or not isinstance(table.get("file"), str):
        raise DataError(f"{path}: no [{polarity}] with a file; write [{polarity}] and file = ...")
    for key in table:
        if key not in _KEYS:
            raise unknown_name(f"{path}: key of [{polarity}]", key, _KEYS)
    module = compile_module(path.parent / table["file"], table.get("module"))
    if module.terminals < 4:
        raise DataError(f"{path}: {module.name} has {module.terminals} terminals, must be 4; name another")
    names = {key: str(table[key]) for key in ("width", "length", "multiplicity") if key in table}
    model = Model(module, {k: _number(path, k, v) for k, v in table.get("parameters", {}).items()}, **names)
    module.given(model.sized(1e-6, 1e-6, 1.0), 27.0)  # refuses what it has not
    return model


def _number(path: Path, name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DataError(f"{path}: {name}: {value!r}, must be a number; correct it")
    return float(value)
