"""What every device type offers."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

from circuits.checks import LIMITS, keep_allowance, require_plausible, require_real, require_type
from circuits.errors import ParameterError


@dataclass(frozen=True, slots=True)
class Device(ABC):
    """A frozen dataclass of a name, terminals (node references) and parameters in SI units.

    Raises `ParameterError` naming the device for a value that breaks a rule of `check`, and for a size that
    nobody means (see `circuits.checks`) unless `allow_implausible`.
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
        """Node references in the order of the device's equations."""

    @abstractmethod
    def parameters(self) -> Mapping[str, float]:
        """Numeric parameters by name, in SI units."""

    @abstractmethod
    def check(self) -> None:
        """Raise `ParameterError` naming the device, the value, its unit and the rule."""

    @abstractmethod
    def conducting(self) -> tuple[tuple[int, int], ...]:
        """Pairs of terminal positions between which a direct current can flow; -1 stands for ground."""


def require_positive(device: Device, attribute: str, unit: str) -> None:
    """Raise `ParameterError` unless a parameter is a finite number above zero, of a size that is meant."""
    label, value = f"{device.name}.{attribute}", getattr(device, attribute)
    require_real(label, value, unit)
    if not (math.isfinite(value) and value > 0.0):
        raise ParameterError(f"{label}: {value:g} {unit}, must be > 0; give a positive size")
    if unit in LIMITS:
        require_plausible(label, value, unit, allowed=device.allow_implausible)


def require_finite(device: Device, attribute: str, unit: str) -> None:
    """Raise `ParameterError` unless a parameter is a finite number, and a voltage of a size that is meant."""
    label, value = f"{device.name}.{attribute}", getattr(device, attribute)
    require_real(label, value, unit)
    if not math.isfinite(value):
        raise ParameterError(f"{label}: {value:g} {unit}, must be finite")
    if unit in LIMITS:
        require_plausible(label, value, unit, allowed=device.allow_implausible)
