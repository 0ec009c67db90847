"""Where behavioural models hold, and what becomes of a run outside: one rule for every chip.

A model holds within the box in which it was held against its transistors: sides such as the temperature, the
area of devices or a bias's current, each from a least to a greatest value. A chip asks `require_inside` of
every side before it is run, and again where its temperature moves. Outside, a run is refused with the
instance path, the value, its time where it moves, the side and what to do, unless `outside_boxes("warn")` is
in force: then it goes on, and is told of every side that it has left.

    with outside_boxes("warn") as left:
        trace = run(scenario)
    print(left.texts())
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Literal

from circuits.errors import ParameterError
from circuits.silicon.course import when

Answer = Literal["refuse", "warn"]
TRANSISTORS = "use the transistor level"  # what to do outside, where there is one
_MEASURED = "where the behavioural model was measured"


class OutsideBoxError(ParameterError):
    """A value is outside of where a model was measured, so that nothing is known of the chip."""


@dataclass(slots=True)
class Left:
    """Sides of boxes that a run has left, each with the value that is furthest outside."""

    answer: Answer
    found: dict[str, tuple[float, str]] = field(default_factory=dict)

    def texts(self) -> tuple[str, ...]:
        """Return a sentence for each side, in the order in which they were left."""
        return tuple(text for _, text in self.found.values())


_IN_FORCE: ContextVar[Left | None] = ContextVar("outside_boxes", default=None)


@contextmanager
def outside_boxes(answer: Answer) -> Iterator[Left]:
    """Refuse what leaves a box, or go on and remember it, while the context lasts.

    Parameters
    ----------
    answer
        `refuse`, as without any context, or `warn`.
    """
    left = Left(answer)
    token = _IN_FORCE.set(left)
    try:
        yield left
    finally:
        _IN_FORCE.reset(token)


def require_inside(
    side: str, value: float, limits: Sequence[float], unit: str, remedy: str = TRANSISTORS
) -> None:
    """Ask that a value is within a side of a model's box.

    Parameters
    ----------
    side
        Instance path and name of the side, such as `ranging_chip.temperature`.
    value
        The value, in `unit`.
    limits
        Least and greatest value that is inside, in `unit`, the latter `inf` where there is none; what stands
        between does not count, and a lone value is both.
    unit
        The unit, empty for a plain number.
    remedy
        What to do outside, beside going on with a warning.

    Raises
    ------
    OutsideBoxError
        It is outside, and no warning is asked for.
    """
    low, high = limits[0], limits[-1]
    if low <= value <= high:
        return
    end = f" {unit}" if unit else ""
    rule = f"at least {low:.3g}" if high == math.inf else f"{low:.3g} to {high:.3g}"
    rule = f"{low:.3g}" if low == high else rule
    told = f"{value:.3g}"
    if low <= float(told) <= high:  # its digits would not show that it is outside
        told = f"{value:.9g}"
    text = f"{side}: {told}{end}{when()}, must be {rule}{end}, {_MEASURED}"
    left = _IN_FORCE.get()
    if left is None:
        raise OutsideBoxError(f"{text}; {remedy}")
    if left.answer == "refuse":
        raise OutsideBoxError(f"{text}; {remedy}, or give `outside=warn`")
    excess = math.inf if math.isnan(value) else max(low - value, value - high)
    if side not in left.found or excess > left.found[side][0]:
        left.found[side] = (excess, text)


def require_area(path: str, area: float, least: float, remedy: str = TRANSISTORS) -> None:
    """Ask that the area of a chip's devices is no smaller than where its model was measured.

    Parameters
    ----------
    path
        Instance path of the chip.
    area
        Area of the drawn devices over the circuits', a ratio.
    least
        Least area at which the model was measured; larger devices deviate less.
    remedy
        As of `require_inside`.

    Raises
    ------
    ParameterError
        It is not above 0 and finite; or it is below, and no warning is asked for.
    """
    if not 0.0 < area < math.inf:
        raise ParameterError(f"{path}.area: {area:g} times the circuits', must be > 0 and finite")
    require_inside(f"{path}.area", area, (least, math.inf), "times the circuits'", remedy)
