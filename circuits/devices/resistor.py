"""Resistor: `I = (v_a - v_b) / R`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from circuits.devices.device import Device, require_positive


@dataclass(frozen=True, slots=True)
class Resistor(Device):
    """A resistor of `resistance` ohm between `a` and `b`."""

    name: str
    a: str
    b: str
    resistance: float

    def terminals(self) -> tuple[str, ...]:
        """Return (a, b)."""
        return self.a, self.b

    def parameters(self) -> Mapping[str, float]:
        """Return the resistance, ohm."""
        return {"resistance": self.resistance}

    def check(self) -> None:
        """Require a resistance above zero."""
        require_positive(self, "resistance", "Ohm")

    def conducting(self) -> tuple[tuple[int, int], ...]:
        """Current flows from a to b."""
        return ((0, 1),)
