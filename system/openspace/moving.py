"""Senses of a flight whose chips' temperature moves: those of a ping are the ones at its time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

from chips.ranging.noise import Jitter
from circuits.silicon.course import Course, Points, along
from system.openspace.senses_kernel import Senses

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Moving:
    """Senses over time.

    senses_at : the senses in a ping at a time, s, the same object as long as the temperature is the same.
    course : of the temperature; None where it stays.
    begun : time of the course at which a flight begins, s.
    """

    senses_at: Callable[[float], Senses]
    course: Course | None = None
    begun: float = 0.0

    def at(self, time: float) -> Senses:
        """The senses in a ping at `time` s of the flight."""
        return self.senses_at(self.begun + time)

    def pings(self, time: float, most: int) -> int:
        """How many pings, at most so many, are surely made from `time` s of the flight on with its senses."""
        ahead = math.inf if self.course is None else self.course.next_change(self.begun + time)
        return most if ahead == math.inf else 1

    def after(self, time: float) -> Moving:
        """The senses of a flight that begins `time` s after the first one."""
        return replace(self, begun=time)


def still(senses: Senses) -> Moving:
    """Senses that stay what they are."""
    return Moving(lambda _: senses)


def along_jitter(
    points: Points, temperature_c: float, make: Callable[[float], T], jitter_of: Callable[[T], Jitter]
) -> Callable[[float], T]:
    """As `circuits.silicon.course.along`, of what has a chip, whose noise goes on at another temperature.

    jitter_of : the jitter of what was made.
    """
    at = along(points, temperature_c, make)
    last = at(0.0)

    def gone_on(time: float) -> T:
        nonlocal last
        before, last = last, at(time)
        if last is not before:
            _go_on(jitter_of(last), jitter_of(before))
        return last

    return gone_on


def _go_on(jitter: Jitter, before: Jitter) -> None:
    """Go on with what flicker was `before`, and with its draws."""
    for name in ("relaxation", "last", "calls"):
        getattr(jitter, name)[:] = getattr(before, name)
