"""Times that vary from trial to trial: the deviation of transistors and that of a model, side by side."""

from __future__ import annotations

import math
from dataclasses import dataclass

from circuits.arrays import F64


@dataclass(frozen=True, slots=True)
class Beside:
    """Deviation (s) of `count` times of the transistors, and that of the model."""

    name: str
    mean: float
    transistors: float
    count: int
    model: float

    @property
    def ratio(self) -> float:
        """The model's over the transistors'."""
        return self.model / self.transistors

    @property
    def known(self) -> float:
        """Deviation, relative, of a deviation that so many times give."""
        return 1.0 / math.sqrt(2.0 * self.count)


def known(times: F64) -> tuple[float, float, int]:
    """Give the mean and the deviation of times, and how many they are."""
    return float(times.mean()), float(times.std(ddof=1)), times.size
