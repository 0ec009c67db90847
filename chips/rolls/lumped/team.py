"""Roots of many equations of one kind, found side by side by Newton's method between bounds.

A team has `LANES` equations, each in a lane of vectors, and all take a step together. A lane whose equation
is solved takes the next one, so that none waits for another; what a lane comes to does not depend on what
stands beside it.

    w, who, active, following = team_of(given)
    while active > 0:
        for j in range(active):
            ...  # the equation at w[Y + j], rising, with what it was given
            moved(w, j, f, f / slope)
        active, following = exchanged(w, who, given, out, active, following)

`given` has a column an equation: first guess, lower and upper bound, and from row `START` on what the kernel
wants of it, which stands in w from row `GIVEN` on. Rows of w are `LANES` long.
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled

ITERATIONS = 80
EXACT = 1e-12  # U_T, last update of a voltage
LANES = 64
START, GIVEN = 3, 4
Y, LOW, HIGH, LEFT = (LANES * k for k in range(GIVEN))


@compiled(forceinline=True)
def closer(y: float, f: float, low: float, high: float) -> tuple[float, float]:
    """Bounds of the root of a rising f, closer by what f is at y, which is between them."""
    return (low, y) if f > 0.0 else (y, high)


@compiled(forceinline=True)
def between(new: float, low: float, high: float) -> float:
    """A guess that is between its bounds, else their middle."""
    return new if low < new < high else 0.5 * (low + high)


@compiled(forceinline=True)
def not_beyond(new: float, low: float, high: float) -> float:
    """A guess that is between its bounds or one of them, else their middle."""
    return new if low <= new <= high else 0.5 * (low + high)


@compiled(forceinline=True)
def moved(w: F64, j: int, f: float, step: float) -> None:
    """Take a step from w[Y + j] down, or to the middle of the bounds that f leaves where it is outside."""
    low, high = closer(w[Y + j], f, w[LOW + j], w[HIGH + j])
    _put(w, j, between(w[Y + j] - step, low, high), low, high)


@compiled(forceinline=True)
def moved_to_end(w: F64, j: int, f: float, step: float) -> None:
    """The same where a root may be at a bound."""
    low, high = closer(w[Y + j], f, w[LOW + j], w[HIGH + j])
    _put(w, j, not_beyond(w[Y + j] - step, low, high), low, high)


@compiled(forceinline=True)
def _put(w: F64, j: int, new: float, low: float, high: float) -> None:
    """Put the next guess of lane j and its bounds; the last one stays where a step is below EXACT."""
    near = abs(new - w[Y + j]) < EXACT
    w[Y + j] = w[Y + j] if near else new
    w[LOW + j], w[HIGH + j] = low, high
    w[LEFT + j] = 0.0 if near else w[LEFT + j] - 1.0


@compiled(_nrt=True)
def team_of(given: F64) -> tuple[F64, I64, int, int]:
    """Return the team with the first equations: w, the number of each lane's, how many, and which is next."""
    w, who = np.zeros((given.shape[0] + GIVEN - START) * LANES), np.zeros(LANES, np.int64)
    active = min(LANES, given.shape[1])
    for j in range(active):
        _take(w, who, given, j, j)
    return w, who, active, active


@compiled()
def _take(w: F64, who: I64, given: F64, j: int, k: int) -> None:
    """Put equation k into lane j."""
    who[j] = k
    w[Y + j], w[LOW + j], w[HIGH + j], w[LEFT + j] = given[0, k], given[1, k], given[2, k], ITERATIONS
    for row in range(START, given.shape[0]):
        w[(row + GIVEN - START) * LANES + j] = given[row, k]


@compiled()
def exchanged(w: F64, who: I64, given: F64, out: F64, active: int, following: int) -> tuple[int, int]:
    """Put what is found into `out`, next equations into its lanes; how many there are, and which is next."""
    j = 0
    while j < active:
        if w[LEFT + j] > 0.0:
            j += 1
            continue
        out[who[j]] = w[Y + j]
        if following < given.shape[1]:
            _take(w, who, given, j, following)
            following += 1
            continue
        active -= 1
        who[j] = who[active]
        for row in range(w.size // LANES):
            w[row * LANES + j] = w[row * LANES + active]
    return active, following
