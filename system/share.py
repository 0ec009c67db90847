"""A share of runs with its exact interval."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from system.study.interval import Interval, clopper_pearson


@dataclass(frozen=True, slots=True)
class Share:
    """How many of so many, and the 95 % interval of their share."""

    passed: int
    of: int

    @property
    def value(self) -> float:
        """Share, 0 of none."""
        return self.passed / max(self.of, 1)

    @property
    def interval(self) -> Interval:
        """Clopper and Pearson's."""
        return clopper_pearson(self.passed, self.of)

    def __str__(self) -> str:
        """As `19 of 20 (75 to 100 %)`."""
        ends = self.interval
        return f"{self.passed} of {self.of} ({100.0 * ends.low:.0f} to {100.0 * ends.high:.0f} %)"


def share_where(said: Iterable[bool]) -> Share:
    """How many are true."""
    every = [bool(x) for x in said]
    return Share(sum(every), len(every))
