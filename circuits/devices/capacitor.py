"""Linear capacitor: `q = C (v_a - v_b)`, with an optional voltage at the beginning of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from circuits.brief import OPTIONAL, brief
from circuits.devices.device import TwoTerminal, require_finite, require_positive


@dataclass(frozen=True, slots=True, repr=False)
class Capacitor(TwoTerminal):
    """A capacitor between two nodes.

    Attributes
    ----------
    a, b : str
        The nodes.
    capacitance : float
        Capacitance, F.
    ic : float or None
        Voltage v_a - v_b at the beginning of every run, V; None leaves it to the rest of the circuit.

    Raises
    ------
    ParameterError
        The capacitance is not above zero, or not of a plausible size.
    """

    capacitance: float
    ic: float | None = field(default=None, metadata=OPTIONAL)

    def __repr__(self) -> str:
        return brief(self)

    def parameters(self) -> Mapping[str, float]:
        """The capacitance, F."""
        return {"capacitance": self.capacitance}

    def check(self) -> None:
        """Raise `ParameterError` unless the capacitance is above zero and the initial voltage is finite."""
        require_positive(self, "capacitance", "F")
        if self.ic is not None:
            require_finite(self, "ic", "V")

    def conducting(self) -> tuple[tuple[int, int], ...]:
        """No pairs, since a capacitor carries no direct current."""
        return ()
