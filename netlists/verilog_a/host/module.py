"""A module of Verilog-A, compiled: its currents, charges and their derivatives at voltages of its nodes.

OpenVAF (the extra `verilog-a`) turns the module into the equations of OSDI's descriptor: a resistive and a
reactive residual for each node, internal ones included, and the derivatives of both. They are evaluated as
OSDI has them, each call from the model's parameters on. The compiler takes a parameter of the type integer as
the bits of its number.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import extra
from circuits.errors import DataError, ParameterError, unknown_name

ZERO_CELSIUS = 273.15  # K
_TYPE, _INTEGER, _TEXT = 3, 1, 2  # of a parameter, in the flags of OSDI's descriptor
_BRANCH = re.compile(r"V\((\w+)(?:,(\w+))?\)")
_UNKNOWN = re.compile(r"inode(\d+)")
_KNOWN = {
    "param",
    "param_given",
    "hidden_state",
    "voltage",
    "current",
    "temperature",
    "sysfun",
    "implicit_unknown",
}


class Residuals(NamedTuple):
    """What leaves the nodes of an instance: A and C, float64[nodes], with derivatives by their voltages."""

    current: F64
    charge: F64
    conductance: F64  # S, float64[nodes, nodes]
    capacitance: F64  # F, float64[nodes, nodes]


@dataclass(frozen=True, slots=True)
class Module:
    """A compiled module.

    name: its name in the file. nodes: its terminals and then its internal nodes. terminals: how many of them
    are terminals. parameters: default by the parameter's name in lower case, where the file states a number.
    """

    name: str
    nodes: tuple[str, ...]
    terminals: int
    parameters: Mapping[str, float]
    compiled: Any = field(repr=False)
    integers: frozenset[str] = field(repr=False)  # parameters of that type, in lower case
    names: tuple[tuple[str, str], ...] = field(repr=False)  # of all that an evaluation takes, and their kinds

    def parameter_names(self) -> set[str]:
        """Names of its parameters in lower case."""
        return {name.lower() for name, kind in self.names if kind == "param"}

    def given(self, parameters: Mapping[str, float], temperature_c: float) -> dict[str, float]:
        """Give what an evaluation takes but for voltages: parameters over the defaults, and the temperature.

        Raises `UnknownNameError` for a parameter that it has not, and `ParameterError` where one without a
        number for its default is not given.
        """
        known = self.parameter_names()
        for name in parameters:
            if name.lower() not in known:
                raise unknown_name(f"{self.name} parameter", name, sorted(known))
        own = dict(self.parameters) | {name.lower(): float(value) for name, value in parameters.items()}
        lacking = sorted(known - own.keys())
        if lacking:
            raise ParameterError(
                f"{self.name}: no number for {', '.join(lacking)}, whose defaults are expressions; give them"
            )
        values = {
            name: self._bits(name, own[name.lower()]) if name.lower() in self.integers else own[name.lower()]
            for name, kind in self.names
            if kind == "param"
        }
        for name, kind in self.names:
            if kind == "temperature":
                values[name] = temperature_c + ZERO_CELSIUS
            elif kind == "sysfun":
                values[name] = 1.0
            elif kind == "param_given":
                values.setdefault(name, 0.0)
        return values

    def _bits(self, name: str, value: float) -> float:
        """A whole number as the compiler takes it: as the number whose lower 32 bits it is."""
        if value != int(value) or abs(value) >= 1 << 31:
            raise ParameterError(f"{self.name}.{name.lower()}: {value:g}, must be a whole number; correct it")
        return float(struct.unpack("<d", struct.pack("<q", int(value) & 0xFFFFFFFF))[0])

    def evaluate(self, given: Mapping[str, float], v: F64) -> Residuals:
        """Evaluate at voltages of its nodes, float64[nodes], V; given: what the method of that name gives."""
        at = dict(given)
        for name, kind in self.names:
            if kind == "voltage":
                plus, minus = _ends(name)
                at[name] = float(
                    v[self.nodes.index(plus)] - (0.0 if minus is None else v[self.nodes.index(minus)])
                )
            elif kind == "implicit_unknown":
                found = _UNKNOWN.fullmatch(name)
                at[name] = float(v[self.terminals + int(found[1])]) if found else 0.0
        residuals, entries = self.compiled.run_init_eval(at)
        parts = np.array(residuals, dtype=np.float64).reshape(len(self.nodes), 2)
        slopes = np.zeros((2, len(self.nodes), len(self.nodes)))
        for row, column, resistive, reactive in entries:
            slopes[0, row, column] += resistive
            slopes[1, row, column] += reactive
        return Residuals(parts[:, 0].copy(), parts[:, 1].copy(), slopes[0], slopes[1])


def compile_module(path: Path, name: str | None = None) -> Module:
    """Compile a module of a file of Verilog-A.

    Parameters
    ----------
    path
        The file.
    name
        Of the module, which may be left out where the file has one alone.

    Raises
    ------
    SimulatorError
        The compiler is not installed.
    DataError
        The file cannot be read or compiled, or the module has what this host does not know.
    """
    if not path.is_file():
        raise DataError(f"{path}: no such file; name one of Verilog-A")
    try:
        found = _compiler().compile_va(str(path), allow_analog_in_cond=True)
    except ValueError as error:
        raise DataError(f"{path}: no Verilog-A that OpenVAF compiles ({error}); correct it") from None
    by_name = {each.name: each for each in found}
    if name is None and len(by_name) != 1:
        raise DataError(f"{path}: has the modules {', '.join(by_name) or 'none'}; name one")
    chosen = next(iter(by_name)) if name is None else name
    if chosen not in by_name:
        raise unknown_name(f"{path}: module", chosen, by_name)
    return _module(path, by_name[chosen])


def _module(path: Path, compiled: Any) -> Module:
    pairs = [*zip(compiled.init_param_names, compiled.init_param_kinds, strict=True)]
    pairs += zip(compiled.param_names, compiled.param_kinds, strict=True)
    names = tuple(dict.fromkeys(pairs))
    nodes = tuple(node["name"] for node in compiled.get_osdi_descriptor()["nodes"])
    strange = [f"{name} ({kind})" for name, kind in names if kind not in _KNOWN]
    strange += [
        name for name, kind in names if kind == "voltage" and not set(filter(None, _ends(name))) <= set(nodes)
    ]
    if compiled.collapsible_pairs:
        strange.append("nodes that may collapse")
    if strange:
        raise DataError(
            f"{path}: module {compiled.name} has {', '.join(strange[:3])}, which is not supported here; take"
            " another"
        )
    kinds = {each["name"].lower(): each["flags"] & _TYPE for each in compiled.get_osdi_descriptor()["params"]}
    if _TEXT in kinds.values():
        raise DataError(f"{path}: module {compiled.name} has parameters that are texts; take another")
    integers = frozenset(name for name, kind in kinds.items() if kind == _INTEGER)
    defaults = {key.lower(): float(value) for key, value in compiled.get_param_defaults().items()}
    return Module(compiled.name, nodes, compiled.num_terminals, defaults, compiled, integers, names)


def _ends(branch: str) -> tuple[str, str | None]:
    found = _BRANCH.fullmatch(branch)
    return (branch, None) if found is None else (found[1], found[2])


def _compiler() -> Any:
    return extra(
        "openvaf_py", "openvaf_py: not installed, models in Verilog-A need it; pip install openvaf-py"
    )
