"""What every device type offers."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping

from circuits.errors import ParameterError


class Device(ABC):
    """A frozen dataclass of a name, terminals (node references) and parameters in SI units."""

    __slots__ = ()

    name: str

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


def require_positive(name: str, attribute: str, value: float, unit: str) -> None:
    """Raise `ParameterError` unless `value` is a finite number above zero."""
    if not (math.isfinite(value) and value > 0.0):
        raise ParameterError(f"{name}.{attribute}: {value:g} {unit}, must be > 0; give a positive size")


def require_finite(name: str, attribute: str, value: float, unit: str) -> None:
    """Raise `ParameterError` unless `value` is a finite number."""
    if not math.isfinite(value):
        raise ParameterError(f"{name}.{attribute}: {value:g} {unit}, must be finite")
