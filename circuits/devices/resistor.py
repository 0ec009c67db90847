"""Linear resistor: `I = (v_a - v_b) / R`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from circuits.devices.device import TwoTerminal, require_positive


@dataclass(frozen=True, slots=True)
class Resistor(TwoTerminal):
    """A resistor of `resistance` ohm between the nodes `a` and `b`.

    Raises `ParameterError` unless the resistance is above zero and of a plausible size.
    """

    resistance: float

    def parameters(self) -> Mapping[str, float]:
        """The resistance, Ohm."""
        return {"resistance": self.resistance}

    def check(self) -> None:
        """Raise `ParameterError` unless the resistance is above zero."""
        require_positive(self, "resistance", "Ohm")

    def conducting(self) -> tuple[tuple[int, int], ...]:
        """Direct current flows between a and b."""
        return ((0, 1),)
