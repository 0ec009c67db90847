"""Compiled pieces of a network's run on a chip under the law with second-order effects.

* A filter keeps by its time constant at its own s, and its output is read from its curve.
* What a line gives is read from a shape that all lines share, times the line's slopes.
* What draws from a membrane rises as the membrane does, so that with u its voltage and g the rise

      du/dt = (J - leak) speed - g (u - 1/2),    g = speed (rise + mirrored J_mirrored)

  which stands still for a step and is solved exactly.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from chips.nef.whole.filter import LOWEST, STEPS
from chips.nef.whole.line import LOWEST as FARTHEST
from chips.nef.whole.line import STEPS as LINE_STEPS
from circuits.arrays import F64
from circuits.compiled import compiled

_LEAST = 1e-9  # of s, from which its logarithm is taken
_SMALL = 1e-4  # of g t, below which a series is exact to 1e-9
_inlined = compiled(forceinline=True)


class Bends(NamedTuple):
    """What the law bends in a network on a chip.

    output, keep: log of a filter's output, full scales, and what a step leaves of it, over ln s,
    float64[lanes, points]; shape: of lines, float64[points]; rise: of the leak, thresholds,
    float64[neurons]; mirrored: of a mirrored current, a share; draws: working space, what mirrors draw,
    thresholds, then how it rises, 1/s, float64[neurons].
    """

    output: F64
    keep: F64
    shape: F64
    rise: F64
    mirrored: float
    draws: F64


@_inlined
def read(row: F64, x: float) -> float:
    """Return a table at position x, in points, by lines; its ends beyond them."""
    x = min(max(x, 0.0), row.size - 1.0)
    i = min(int(x), row.size - 2)
    return float(row[i] + (x - i) * (row[i + 1] - row[i]))


@_inlined
def position(s: float) -> float:
    """Return where a filter's s is in its curves, in points."""
    return (math.log(max(s, _LEAST)) - LOWEST) * STEPS


@_inlined
def bent(shape: F64, apart: float) -> float:
    """Return what lines give of a sum that is so far from their reference, over their slope."""
    return read(shape, (apart - FARTHEST) * LINE_STEPS)


@_inlined
def add_bent(current: F64, sunk: F64, row: F64, x: float) -> None:
    """Add a row times a number of at least 0 to currents, and what of it mirrors draw."""
    for i in range(current.size):
        more = x * row[i]
        current[i] += more
        sunk[i] -= min(more, 0.0)


@_inlined
def risen_little(slope: float, g: float, time: float) -> float:
    """Return what `risen` does where g t is at most 1, without a branch or a call.

    Of the approximation of Pade with seven terms each above and below, whose odd and even ones are B and A,

        (1 - e^-x) / x = 2 B / (A + x B)
    """
    x = g * time
    y = x * x
    a = 17297280.0 + y * (1995840.0 + y * (25200.0 + 56.0 * y))
    b = 8648640.0 + y * (277200.0 + y * (1512.0 + y))
    return slope * time * (2.0 * b / (a + x * b))


@_inlined
def risen(slope: float, g: float, time: float) -> float:
    """Return how far a membrane goes in a time, s, that begins with a slope, 1/s."""
    x = g * time
    if x < _SMALL:
        return slope * time * (1.0 - 0.5 * x)
    return -slope * math.expm1(-x) / g


@_inlined
def since(slope: float, g: float, height: float) -> float:
    """Return when a membrane was `height` below where it is, s; slope: there, 1/s, above 0."""
    x = g * height / slope
    if abs(x) < _SMALL:
        return height / slope * (1.0 - 0.5 * x)
    return math.log1p(x) / g


@_inlined
def until(slope: float, g: float) -> float:
    """Return the time from reset to threshold, s, that begins with a slope, 1/s, or inf."""
    return since(slope, -g, 1.0) if slope > g else math.inf
