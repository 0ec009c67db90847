"""Share of the runs or samples that pass, with its exact confidence interval, and how it is written."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from system.rule import Measured, Value
from system.study.statistics.interval import Interval, clopper_pearson

_DIGITS = 6  # after the point, at most


@dataclass(frozen=True, slots=True)
class Share:
    """Number of runs or samples that pass, out of how many, with the 95 % interval of their share.

    Attributes
    ----------
    passed : int
        How many of these runs or samples pass.
    of : int
        How many there are.
    """

    passed: int
    of: int

    @property
    def value(self) -> float:
        """The share, from 0 to 1; it is 0 where there are no samples."""
        return self.passed / max(self.of, 1)

    @property
    def interval(self) -> Interval:
        """The exact 95 % interval of the share, after Clopper and Pearson."""
        return clopper_pearson(self.passed, self.of)

    def measured(self, shown: Value = None) -> Measured:
        """Give the share as a measured value that an expectation can judge.

        It is shown in words unless `shown` is given. The value is NaN where there are no samples.
        """
        value = self.value if self.of else math.nan
        return Measured(value, str(self) if shown is None else shown, self.interval)

    def __str__(self) -> str:
        """Write the share as `19 of 20 (75 to 100 %)`."""
        return f"{self.passed} of {self.of} ({percent(self.interval)})"


def percent(ends: Interval) -> str:
    """Write the interval of a share as `75 to 100 %`, with enough digits for its ends to differ."""
    for digits in range(_DIGITS):
        low, high = (f"{100.0 * end:.{digits}f}" for end in (ends.low, ends.high))
        if low != high:
            return f"{low} to {high} %"
    return f"{100.0 * ends.low:g} to {100.0 * ends.high:g} %"


def share_where(said: Iterable[bool]) -> Share:
    """Give the share of the values that are true."""
    every = [bool(x) for x in said]
    return Share(sum(every), len(every))
