"""A share of runs or samples with its exact interval, in words."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from system.rule import Measured, Value
from system.study.statistics.interval import Interval, clopper_pearson

_DIGITS = 6  # after the point, at most


@dataclass(frozen=True, slots=True)
class Share:
    """How many of so many, and the 95 % interval of their share."""

    passed: int
    of: int

    @property
    def value(self) -> float:
        """The share; that of none is 0."""
        return self.passed / max(self.of, 1)

    @property
    def interval(self) -> Interval:
        """The exact 95 % interval of Clopper and Pearson."""
        return clopper_pearson(self.passed, self.of)

    def measured(self, shown: Value = None) -> Measured:
        """The share as a value to judge, shown in words unless given otherwise; that of none is no number."""
        value = self.value if self.of else math.nan
        return Measured(value, str(self) if shown is None else shown, self.interval)

    def __str__(self) -> str:
        """As `19 of 20 (75 to 100 %)`."""
        return f"{self.passed} of {self.of} ({percent(self.interval)})"


def percent(ends: Interval) -> str:
    """Write the interval of a share as `75 to 100 %`, with so many digits that its ends differ."""
    for digits in range(_DIGITS):
        low, high = (f"{100.0 * end:.{digits}f}" for end in (ends.low, ends.high))
        if low != high:
            return f"{low} to {high} %"
    return f"{100.0 * ends.low:g} to {100.0 * ends.high:g} %"


def share_where(said: Iterable[bool]) -> Share:
    """Count how many are true."""
    every = [bool(x) for x in said]
    return Share(sum(every), len(every))
