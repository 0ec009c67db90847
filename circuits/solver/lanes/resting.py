"""How a lane finds a rest state: by the first two tries of `circuits.solver.operating_point.rest_state`.

These are Newton's method from the start, and then with a conductance to the start that is taken away decade
by decade.
"""

from __future__ import annotations

from circuits.compiled import compiled
from circuits.solver.lanes.layout import CHECKING, FAILED, RESTING, ROW, RUNNING, Found, Team, Wiring
from circuits.solver.operating_point import DECADES, MAX_REST_UPDATE, TOLERANCE

_ITERATIONS = 200  # of a solve


@compiled()
def look_for_rest(x: Team, lane: int) -> None:
    """Let a lane look for its rest state, from the voltages that it has."""
    t = x.control
    t[ROW.a, lane], t[ROW.b0, lane], t[ROW.devices, lane], t[ROW.largest_move, lane] = (
        0.0,
        0.0,
        1.0,
        MAX_REST_UPDATE,
    )
    t[ROW.iteration, lane], t[ROW.pull, lane] = 0.0, 0.0
    x.doing[lane] = RESTING


@compiled()
def rest_on(c: Wiring, x: Team, lane: int) -> int:
    """Go on after an iteration of a lane that looks for its rest state: `RUNNING`, or `FAILED` for good."""
    t = x.control
    broken = t[ROW.broken, lane] >= 0.5
    if t[ROW.update, lane] < TOLERANCE and not broken:
        _converged(x, lane)
    elif broken or t[ROW.iteration, lane] >= _ITERATIONS:
        if t[ROW.tries, lane] > 0.0:
            return FAILED
        for i in range(c.unknowns):
            x.v[i, lane] = x.guess[i, lane]
        t[ROW.iteration, lane], t[ROW.tries, lane], t[ROW.pull, lane] = 0.0, 1.0, DECADES[0]
    return RUNNING


@compiled()
def _converged(x: Team, lane: int) -> None:
    """A solve has converged: without a conductance it is the rest state, else the next decade is tried."""
    t = x.control
    t[ROW.iteration, lane] = 0.0
    if t[ROW.pull, lane] == 0.0:
        t[ROW.largest_move, lane] = 0.0
        x.doing[lane] = CHECKING
        return
    t[ROW.tries, lane] += 1.0
    k = int(t[ROW.tries, lane])
    t[ROW.pull, lane] = DECADES[k - 1] if k <= len(DECADES) else 0.0


@compiled()
def keep_rest(x: Team, found: Found, lane: int) -> None:
    """Keep a rest state and its Jacobian, which is not factored yet."""
    job = x.job[lane]
    for i in range(found.rest.shape[1]):
        found.rest[job, i] = x.v[i, lane]
    for e in range(found.jacobian.shape[1]):
        found.jacobian[job, e] = x.jacobian[e, lane]
