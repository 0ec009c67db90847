"""The contract of a device type: terminals, parameters, checks, and where direct current flows."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

from circuits.checks import LIMITS, keep_allowance, require_plausible, require_real, require_type
from circuits.errors import ParameterError


@dataclass(frozen=True, slots=True)
class Device(ABC):
    """A device: a frozen dataclass with a name, terminals (names of nodes) and parameters in SI units.

    Attributes
    ----------
    name : str
        Name of the device, which no other part of its circuit has.
    allow_implausible : bool
        Whether sizes outside of what silicon has are meant (`circuits.checks`).

    Raises
    ------
    ParameterError
        A value breaks a rule of `check`, or a size is implausible and that is not allowed. The text names the
        device.
    """

    name: str
    allow_implausible: bool = field(default=False, repr=False, compare=False, kw_only=True)

    def __post_init__(self) -> None:
        keep_allowance(self)
        require_type("device.name", self.name, str, "a name")
        for terminal in self.terminals():
            require_type(f"{self.name}", terminal, str, "the name of a node")
        self.check()

    @abstractmethod
    def terminals(self) -> tuple[str, ...]:
        """Names of the nodes that the device is connected to, in the order of its equations."""

    @abstractmethod
    def parameters(self) -> Mapping[str, float]:
        """The device's numbers by name, in SI units."""

    @abstractmethod
    def check(self) -> None:
        """Raise `ParameterError`, with device, value, unit and rule, for a value that breaks a rule."""

    @abstractmethod
    def conducting(self) -> tuple[tuple[int, int], ...]:
        """Pairs of terminal positions between which direct current can flow; -1 stands for ground."""


@dataclass(frozen=True, slots=True)
class TwoTerminal(Device):
    """A device between the nodes `a` and `b` alone."""

    a: str
    b: str

    def terminals(self) -> tuple[str, ...]:
        """The nodes a and b."""
        return self.a, self.b


def require_positive(device: Device, attribute: str, unit: str) -> None:
    """Raise `ParameterError` unless a parameter is a finite number above zero and of a plausible size."""
    label, value = f"{device.name}.{attribute}", getattr(device, attribute)
    require_real(label, value, unit)
    if not (math.isfinite(value) and value > 0.0):
        raise ParameterError(f"{label}: {value:g} {unit}, must be > 0; give a positive size")
    if unit in LIMITS:
        require_plausible(label, value, unit, allowed=device.allow_implausible)


def require_finite(device: Device, attribute: str, unit: str) -> None:
    """Raise `ParameterError` unless a parameter is a finite number, and a voltage of a plausible size."""
    label, value = f"{device.name}.{attribute}", getattr(device, attribute)
    require_real(label, value, unit)
    if not math.isfinite(value):
        raise ParameterError(f"{label}: {value:g} {unit}, must be finite")
    if unit in LIMITS:
        require_plausible(label, value, unit, allowed=device.allow_implausible)
