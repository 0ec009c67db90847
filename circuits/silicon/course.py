"""A course of temperature: straight lines over time, which a run follows in steps.

Before its first point and after its last one the temperature is the nearest one's. A run does not follow it
continuously: what depends on temperature is made anew where the course, rounded to whole steps, has come to
another one, so that the temperature that is used is within half a step of the course's. A delay by a fixed
gate moves by some 6 %/K, so that half a step of 0.1 K is 0.3 % of it; one by an ideal bias's current moves
by a tenth of that.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TypeVar

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.process import check_temperature

STEP = 0.1  # K, ours: in which a course is followed
INSTANT = 10e-6  # s, ours: changes that come within this are one, as where a course has a step
_DECIMALS = 9  # of a kelvin, to which a whole number of steps is written

T = TypeVar("T")
Points = tuple[tuple[float, float], ...]  # times, s, rising, and temperatures, degC


@dataclass(frozen=True, slots=True)
class Course:
    """A course of temperature, followed in steps.

    Attributes
    ----------
    points : tuple of (float, float)
        Times, s, which rise, with the temperature at each, degC.
    step : float
        In which it is followed, K.

    Raises
    ------
    ParameterError
        There is no point, times do not rise, or a temperature is outside of what the laws hold for.
    """

    points: Points
    step: float = STEP

    def __post_init__(self) -> None:
        """Raise `ParameterError` for points that are no course."""
        if not self.points:
            raise ParameterError("temperature: a course without points; write as in 0s:27,60s:44")
        for time, celsius in self.points:
            if not math.isfinite(time):
                raise ParameterError(f"temperature: {celsius:g} degC at {time:g} s, must be at a finite time")
            check_temperature(celsius)
        for (before, _), (after, _) in pairwise(self.points):
            if not before < after:
                raise ParameterError(
                    f"temperature: {after:g} s after {before:g} s, times must rise; sort them"
                )

    def at(self, time: float) -> float:
        """Return the temperature that is used at `time` s, degC: the course's in whole steps."""
        times, celsius = _steps(self.points, self.step)
        return float(celsius[np.searchsorted(times, time, side="right") - 1])

    def next_change(self, time: float) -> float:
        """Return when the temperature that is used next changes after `time` s, s, inf for never."""
        times, _ = _steps(self.points, self.step)
        later = int(np.searchsorted(times, time, side="right"))
        return float(times[later]) if later < times.size else math.inf

    def stretches(self, begin: float, end: float) -> Iterator[tuple[float, float, float]]:
        """Yield begin and end (s) of each stretch from `begin` to `end`, and its temperature, degC."""
        while begin < end:
            until = min(self.next_change(begin), end)
            yield begin, until, self.at(begin)
            begin = until

    def check(self, end: float, refuse: Callable[[float], object]) -> None:
        """Call `refuse` with every temperature (degC) from 0 to `end` s; what it says has the time (`when`).

        Raises `ParameterError` where `refuse` does.
        """
        for begin, _, celsius in self.stretches(0.0, end):
            with told_when(begin):
                refuse(celsius)

    @property
    def begin(self) -> float:
        """The temperature that is used at 0 s, degC."""
        return self.at(0.0)

    def __str__(self) -> str:
        return ", ".join(f"{celsius:g} at {time:g} s" for time, celsius in self.points)


def course_through(points: Points, step: float = STEP) -> Course | None:
    """Return the course through `points`, followed in steps of `step` K; None where there are none."""
    return Course(points, step) if points else None


def beginning_of(temperature_c: float, points: Points, step: float = STEP) -> float:
    """Return where a run begins, degC: `temperature_c`, or the course's through `points` where it has one."""
    return Course(points, step).begin if points else temperature_c


def along(points: Points, temperature_c: float, make: Callable[[float], T]) -> Callable[[float], T]:
    """Return what `make` gives of a temperature, degC, as a function of time, s; it is made once for each.

    Parameters
    ----------
    points
        Those of a course; none for `temperature_c` throughout.
    temperature_c
        Temperature without a course, degC.
    make
        What depends on temperature. Its refusals are told with the time (`when`).
    """
    if not points:
        still = make(temperature_c)
        return lambda _: still
    course, made = Course(points), dict[float, T]()

    def at(time: float) -> T:
        celsius = course.at(time)
        if celsius not in made:
            with told_when(time):
                made[celsius] = make(celsius)
        return made[celsius]

    return at


_NOW: ContextVar[float | None] = ContextVar("course", default=None)


@contextmanager
def told_when(time: float) -> Iterator[None]:
    """Let what is refused, or warned of, say that a course has come there at `time` s (`when`)."""
    token = _NOW.set(time)
    try:
        yield
    finally:
        _NOW.reset(token)


def when() -> str:
    """Return the time of a course in whose name something is asked, as ` at 44.7 s`; empty for none."""
    time = _NOW.get()
    return "" if time is None else f" at {time:g} s"


@lru_cache(maxsize=64)
def _steps(points: Points, step: float) -> tuple[F64, F64]:
    """Times from which on each temperature in whole steps is used, the first one -inf, and these, degC."""
    whole = round(points[0][1] / step)
    times, numbers = [-math.inf], [whole]
    for (begin, low), (end, high) in pairwise(points):
        last = round(high / step)
        way = 1 if high > low else -1
        for number in range(whole + way, last + way, way) if last != whole else ():
            crossed = (number - 0.5 * way) * step
            time = begin + (end - begin) * min(max((crossed - low) / (high - low), 0.0), 1.0)
            if time - times[-1] < INSTANT:
                numbers[-1] = number
            else:
                times.append(time)
                numbers.append(number)
        whole = last
    return np.array(times), np.round(np.array(numbers) * step, _DECIMALS)
