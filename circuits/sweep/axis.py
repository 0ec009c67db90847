"""What a sweep goes over: a source, the silicon, or a parameter of the function that makes the testbench."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError, unknown_name
from circuits.lowering.kernel import Machine
from circuits.silicon.die import CORNERS
from circuits.silicon.process import check_temperature

Kind = Literal["source", "temperature", "die", "corner", "parameter"]
Way = Literal["up", "down", "both"]
SILICON: dict[str, tuple[Kind, str]] = {
    "temperature": ("temperature", "degC"),
    "die": ("die", ""),
    "corner": ("corner", ""),
}
DIRECTION = "direction"
MOST = 100_000_000  # values of a sweep; ours
_TAKEN = {"voltage", "current", "stable", "reason", "node", "device", DIRECTION}  # names in the dataset


@dataclass(frozen=True, slots=True)
class Axis:
    """A quantity that is swept.

    Attributes
    ----------
    name : its name, which is the dimension's in the dataset.
    kind : what it is.
    unit : unit of its values.
    values : in the order in which they are visited.
    """

    name: str
    kind: Kind
    unit: str
    values: tuple[Any, ...]

    @property
    def numbers(self) -> F64:
        """Its values, float64[N]."""
        return np.array(self.values, dtype=np.float64)


def axes_of(
    over: Mapping[str, Sequence[Any] | F64], machine: Machine, parameters: Mapping[str, str]
) -> tuple[Axis, ...]:
    """Read what is swept.

    Parameters
    ----------
    over
        Values by name: of a source of the machine, a bias port's included, of `temperature` (degC), `die` or
        `corner`, or of a parameter.
    machine
        The testbench, lowered.
    parameters
        Unit of each parameter, by name.

    Raises
    ------
    ParameterError
        There is nothing to sweep, or a value is no value of its kind.
    UnknownNameError
        There is nothing of that name.
    """
    if not over:
        raise ParameterError("over: nothing, must be at least one name with its values")
    axes = tuple(_axis(name, values, machine, parameters) for name, values in over.items())
    points = int(np.prod([len(axis.values) for axis in axes]))
    if points * len(machine.names) > MOST:
        raise ParameterError(
            f"over: {points} points of {len(machine.names)} nodes, must be at most {MOST} values; sweep fewer"
        )
    return axes


def _axis(name: str, given: Sequence[Any] | F64, machine: Machine, parameters: Mapping[str, str]) -> Axis:
    kind, unit = _kind(name, machine, parameters)
    if name in _TAKEN:
        raise ParameterError(f"over: {name}, a name of the dataset's own; rename it")
    values = tuple(np.asarray(given).ravel().tolist())
    if not values:
        raise ParameterError(f"over: {name} has no values, must have at least one")
    _check(name, kind, values)
    if len(set(values)) < len(values):
        raise ParameterError(f"over: {name} has a value twice, must have each once; sweep both ways for two")
    return Axis(name, kind, unit, values)


def _kind(name: str, machine: Machine, parameters: Mapping[str, str]) -> tuple[Kind, str]:
    if name in parameters:
        return "parameter", parameters[name]
    if name in SILICON:
        return SILICON[name]
    if name in machine.source_names:
        quantity = machine.source_quantities[machine.source_names.index(name)]
        return "source", "V" if quantity == "voltage" else "A"
    known = [*machine.source_names, *SILICON, *parameters]
    raise unknown_name(f"{machine.testbench.title}: swept", name, known)


def _check(name: str, kind: Kind, values: tuple[Any, ...]) -> None:
    if kind == "corner":
        for value in values:
            if value not in CORNERS:
                raise ParameterError(f"corner: {value}, must be one of {', '.join(CORNERS)}")
        return
    numbers = np.array(values) if {type(value) for value in values} <= {int, float} else np.array([np.nan])
    if not np.isfinite(numbers).all():
        bad = next(v for v in values if type(v) not in {int, float} or not math.isfinite(v))
        raise ParameterError(f"{name}: {bad!r}, values of a sweep must be finite numbers")
    if kind == "die" and not ((numbers == numbers.astype(np.int64)) & (numbers >= 0)).all():
        bad = next(v for v in values if v != int(v) or v < 0)
        raise ParameterError(f"die: {bad:g}, must be a whole number from 0 on")
    if kind == "temperature":
        for value in (min(values), max(values)):
            check_temperature(value)
