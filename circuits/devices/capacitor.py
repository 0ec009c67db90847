"""Capacitor: `q = C (v_a - v_b)`, with a voltage that a run may begin with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from circuits.brief import OPTIONAL, brief
from circuits.devices.device import Device, require_finite, require_positive


@dataclass(frozen=True, slots=True, repr=False)
class Capacitor(Device):
    """A capacitor of `capacitance` farad between `a` and `b`.

    `ic`: v_a - v_b (V) at the start of every run, None for what the rest of the circuit makes it.
    """

    name: str
    a: str
    b: str
    capacitance: float
    ic: float | None = field(default=None, metadata=OPTIONAL)

    def __repr__(self) -> str:
        return brief(self)

    def terminals(self) -> tuple[str, ...]:
        """Return (a, b)."""
        return self.a, self.b

    def parameters(self) -> Mapping[str, float]:
        """Return the capacitance, F."""
        return {"capacitance": self.capacitance}

    def check(self) -> None:
        """Require a capacitance above zero, and an initial voltage that is finite."""
        require_positive(self, "capacitance", "F")
        if self.ic is not None:
            require_finite(self, "ic", "V")

    def conducting(self) -> tuple[tuple[int, int], ...]:
        """No direct current flows."""
        return ()
