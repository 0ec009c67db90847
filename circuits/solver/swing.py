"""Watched signals that swing without ever crossing the threshold at which their events would count."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from circuits.arrays import F64

SWINGS = 0.5  # ours: share of its threshold that a signal has to move by to be told


@dataclass(frozen=True, slots=True)
class Swing:
    """The lowest and highest voltage of a signal, and the threshold that it stays on one side of, V."""

    low: float
    high: float
    threshold: float

    def __str__(self) -> str:
        """What happened, and what to try."""
        moves = f"swings between {self.low:.3g} and {self.high:.3g} V and never crosses its threshold"
        remedy = "state the port's threshold, or drive a port of kind supply"
        return f"{moves} of {self.threshold:.3g} V, so that no event counts; {remedy}"


def uncrossed(names: Sequence[str], thresholds: F64, extent: F64) -> dict[str, Swing]:
    """Those of the watched nodes that swing on one side of their threshold, by name.

    thresholds: float64[watched], V. extent: float64[2, watched], V, the lowest and the highest of each.
    """
    found = {}
    for name, threshold, low, high in zip(names, thresholds.tolist(), *extent.tolist(), strict=True):
        if high - low > SWINGS * abs(threshold) and (high < threshold or low > threshold):
            found[name] = Swing(low, high, threshold)
    return found
