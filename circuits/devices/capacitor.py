"""Capacitor: `q = C (v_a - v_b)`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from circuits.devices.device import Device, require_positive


@dataclass(frozen=True, slots=True)
class Capacitor(Device):
    """A capacitor of `capacitance` farad between `a` and `b`."""

    name: str
    a: str
    b: str
    capacitance: float

    def terminals(self) -> tuple[str, ...]:
        """Return (a, b)."""
        return self.a, self.b

    def parameters(self) -> Mapping[str, float]:
        """Return the capacitance, F."""
        return {"capacitance": self.capacitance}

    def check(self) -> None:
        """Require a capacitance above zero."""
        require_positive(self.name, "capacitance", self.capacitance, "F")

    def conducting(self) -> tuple[tuple[int, int], ...]:
        """No direct current flows."""
        return ()
