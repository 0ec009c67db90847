"""Roots of many equations of one kind, found side by side by Newton's method between bounds.

Equations belong to places, such as neurons, each with as many points as the next. A team has `LANES` of them,
each in a lane of vectors, and all take a step together. A lane whose equation is solved takes the next point
of its place, or the next place, so that none waits for another; what a lane comes to does not depend on what
stands beside it.

    w, who, active, following = team_of(rows, points)
    while active > 0:
        for j in range(min(active, LANES)):
            ...  # the equation at w[Y + j], rising, with what it was given
            moved(w, j, f, f / slope)
        active, following = exchanged(w, who, rows, points, out, active, following, Y)

`points`, float64[numbers, places, points], has the first guess of each equation (no number where it begins
from its place's last root), its lower and upper bound, and from `START` on what the kernel wants of it, which
stands in w from row `GIVEN` on; `rows`, float64[numbers, places], what it wants of the place, which stands
behind. Rows of w are `LANES` long; `FIRST` to `FOURTH` are the kernel's own.
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled

ITERATIONS = 80
EXACT = 1e-12  # U_T, last update of a voltage
LANES = 64
START, GIVEN = 3, 8
Y, LOW, HIGH, LEFT, FIRST, SECOND, THIRD, FOURTH = (LANES * k for k in range(GIVEN))


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


@compiled(forceinline=True)
def bounded(w: F64, j: int, f: float, new: float) -> float:
    """A guess inside the bounds that f leaves of lane j, which are put."""
    low, high = closer(w[Y + j], f, w[LOW + j], w[HIGH + j])
    w[LOW + j], w[HIGH + j] = low, high
    return between(new, low, high)


@compiled(forceinline=True)
def settled(w: F64, j: int, new: float, near: bool) -> None:  # noqa: FBT001 - a kernel's
    """Put the next guess of lane j, which is its root where it is near the last one."""
    w[Y + j], w[LEFT + j] = new, 0.0 if near else w[LEFT + j] - 1.0


@compiled(_nrt=True)
def team_of(rows: F64, points: F64) -> tuple[F64, I64, int, int]:
    """Return the team with the first equations: w, place and point of each lane, how many, the next place."""
    numbers = GIVEN + points.shape[0] - START + rows.shape[0]
    w, who = np.zeros(numbers * LANES), np.zeros((2, LANES), np.int64)
    active = min(LANES, points.shape[1])
    for j in range(active):
        _take(w, who, rows, points, j, j)
    return w, who, active, active


@compiled()
def _take(w: F64, who: I64, rows: F64, points: F64, j: int, k: int) -> None:
    """Put the first point of place k into lane j."""
    who[0, j], who[1, j] = k, 0
    first = GIVEN + points.shape[0] - START
    for row in range(rows.shape[0]):
        w[(first + row) * LANES + j] = rows[row, k]
    _take_point(w, who, points, j)


@compiled()
def _take_point(w: F64, who: I64, points: F64, j: int) -> None:
    k, point = who[0, j], who[1, j]
    y = points[0, k, point]
    w[Y + j] = y if y == y else w[Y + j]  # noqa: PLR0124 - no number
    w[LOW + j], w[HIGH + j], w[LEFT + j] = points[1, k, point], points[2, k, point], ITERATIONS
    for row in range(START, points.shape[0]):
        w[(row + GIVEN - START) * LANES + j] = points[row, k, point]


@compiled()
def exchanged(
    w: F64, who: I64, rows: F64, points: F64, out: F64, active: int, following: int, found: int
) -> tuple[int, int]:
    """Put what is found into `out`, next equations into its lanes; how many there are, and the next place.

    found: row of w that has it; out: float64[places, points].
    """
    j = 0
    while j < active:
        if w[LEFT + j] > 0.0:
            j += 1
            continue
        out[who[0, j], who[1, j]] = w[found + j]
        who[1, j] += 1
        if who[1, j] < points.shape[2]:
            _take_point(w, who, points, j)
        elif following < points.shape[1]:
            _take(w, who, rows, points, j, following)
            following += 1
        else:
            active -= 1
            who[0, j], who[1, j] = who[0, active], who[1, active]
            for row in range(w.size // LANES):
                w[row * LANES + j] = w[row * LANES + active]
    return active, following
