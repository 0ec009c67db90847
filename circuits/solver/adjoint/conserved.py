"""What an adjoint run has to conserve, and what of it fast edges lose.

While sources stand still, a circuit's equations do not know the time. A run whose state is shifted along its
own way by a time then measures the same earlier, whatever the state: with y what a measure changes by with
the charges at a time, and q' how fast these change,

    H = y q'

is the same at all times between a measure and the last move of a source; of the time of an event it is -1.
The derivatives of a run with its steps as they were keep H up to the error of the steps. A fast edge has
charges that change by orders of magnitude faster than those that outlast it, so that small errors of the one
are large ones of the other, and what came before an edge is told by a share too small or too large. By that
share H differs before and after the edge.
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64, I64
from circuits.lowering.kernel import Kernel
from circuits.solver.adjoint.way import Way

_BEGUN = 2  # rows after a source has moved, from which on rates are of second order


def lost_share(k: Kernel, way: Way, slopes: F64, moved: F64) -> float:
    """Return what share of H the time of an event loses while sources stand still, from a run's begin on.

    slopes : float64[rows, unknowns], of the time by the voltages; moved : of it, as of
    `circuits.solver.adjoint.backwards.backwards`, float64[rows, unknowns].
    """
    asked = np.flatnonzero(slopes.any(axis=1))
    last = int(asked[0]) - 1 if asked.size else 0
    ends = [(first + _BEGUN, min(end, last)) for first, end in _still(way, k.unknowns)]
    kept = np.array([_conserved(k, way, moved, row) for both in ends if both[0] < both[1] for row in both])
    if not kept.size or not kept.any():
        return 0.0
    return float(np.abs(kept[1::2] - kept[::2]).sum() / np.abs(kept).max())


def _still(way: Way, unknowns: int) -> list[tuple[int, int]]:
    """First and last rows of the stretches in which no source moves."""
    stands = np.zeros(way.time.size + 1, np.bool_)
    stands[1:-1] = (np.diff(way.voltage[:, unknowns:], axis=0) == 0.0).all(axis=1)
    edges: I64 = np.flatnonzero(np.diff(stands))
    return [(int(a) + 1, int(b)) for a, b in edges.reshape(-1, 2)]


def _conserved(k: Kernel, way: Way, moved: F64, row: int) -> float:
    """H at a row, by what the rows after it have of the charges at it and at the one before."""
    share = way.share
    before = share[row + 2, 2] * moved[row + 2] if row + 2 < way.time.size else np.zeros(k.unknowns)
    owed = _charges(k, share[row + 1, 1] * moved[row + 1] + before)
    earlier = _charges(k, share[row + 1, 2] * moved[row + 1])
    return -float(owed @ _rate(way, row, k.unknowns) + earlier @ _rate(way, row - 1, k.unknowns))


def _rate(way: Way, row: int, unknowns: int) -> F64:
    """How fast the voltages change at a row, V/s."""
    return np.asarray(way.share[row] @ way.voltage[row - 2 : row + 1][::-1, :unknowns])


def _charges(k: Kernel, moved: F64) -> F64:
    """What a measure has by charges, from what it has by currents of each node."""
    found = np.zeros(k.unknowns)
    for row in np.flatnonzero(moved):
        own = slice(k.charge.start[row], k.charge.start[row + 1])
        inside = k.charge.column[own] < k.unknowns
        found[k.charge.column[own][inside]] += k.charge.value[own][inside] * moved[row]
    return found
