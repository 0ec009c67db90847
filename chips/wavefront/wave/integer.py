"""Compiled wave on a grid whose delays are integer costs of the sending cells.

t_i = min_j (t_j + D_j). The delay belongs to the sender, so the first spike that reaches a cell is the one
that fires it: each cell enters the queue once, at t_j + D_j, and no entry ever moves. Buckets are linked
lists, one a time step, used round and round (R. B. Dial, Algorithm 360, Comm. ACM 12, 1969, without its
decrease of keys).

The grid is padded by a row above and below and by one column, which the end of one row shares with the
beginning of the next. One int32 a cell is its state: -D before it fires, t + D after, `BLOCKED` if it never
can. Pointers are read from that afterwards.
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64, I8, I32, I64
from circuits.compiled import compiled

BLOCKED = 2**31 - 1
HIGHEST_COST = 4095  # one bucket a time step
LONGEST = 2**31 - 1  # cells times highest cost: times are int32
REFUSED = -1  # a cost below 0 or above what is allowed
_BUCKETS = HIGHEST_COST + 1
_EMPTY = -1

_compiled = compiled()
_inlined = compiled(forceinline=True)


def work_size(rows: int, columns: int) -> int:
    """Return the length of the working space of `spread`, in int32."""
    return 2 * (rows + 2) * (columns + 1) + 4 + _BUCKETS


@_inlined
def padded_cell(cell: int, columns: int) -> int:
    """Return the number of a cell on the padded grid, from its number on the grid."""
    return cell + cell // columns + columns + 2


@_inlined
def padded_rows(grid: F64 | I32, r: int, stride: int) -> tuple[F64 | I32, F64 | I32, F64 | I32]:
    """Return the rows above, at and below row `r` of the grid, with the padding at both of their ends."""
    return (
        grid[r * stride : (r + 1) * stride + 1],
        grid[(r + 1) * stride : (r + 2) * stride + 1],
        grid[(r + 2) * stride : (r + 3) * stride + 1],
    )


@_inlined
def first_input(
    above: F64 | I32, same: F64 | I32, below: F64 | I32, c: int, t: float | np.int32
) -> tuple[np.int32, int]:
    """Return the lowest input whose spike came at `t`, -1 for none, and at how many inputs one did.

    above, same, below: when spikes of the cells of three rows arrive; c: the cell's place in them, less 1.
    """
    k, hits = np.int32(_EMPTY), 0
    for value, number in (
        (above[c], 7), (same[c], 6), (below[c], 5), (below[c + 1], 4),
        (below[c + 2], 3), (same[c + 2], 2), (above[c + 2], 1), (above[c + 1], 0),
    ):  # fmt: skip
        hit = value == t
        k = np.int32(number) if hit else k
        hits += hit
    return k, hits


@_compiled
def spread(costs: I32 | I64, work: I32, arrivals: F64, pointers: I8, start: int, goal: int) -> int:
    """Run a wave; returns the number of cells that two or more spikes reached first, or `REFUSED`.

    costs: int32 or int64[rows, columns], 0 for blocked; work: int32[work_size], scratch; arrivals: float64
    and pointers: int8, both [rows, columns], are filled; start and goal: cell numbers, the goal -1 for none.
    """
    rows, columns = costs.shape
    stride = columns + 1
    padded = (rows + 2) * stride + 2
    state, following, heads = work[:padded], work[padded : 2 * padded], work[2 * padded :]
    low, high = _prepare(costs, state)
    if low < 0 or high > min(HIGHEST_COST, LONGEST // costs.size):
        return REFUSED
    start = padded_cell(start, columns)
    goal = padded - 1 if goal < 0 else padded_cell(goal, columns)
    goal = padded - 1 if state[goal] == BLOCKED else goal
    _run(state, following, heads, stride, high, start, goal)
    return int(_read(costs, state, arrivals, pointers))


@_compiled
def _prepare(costs: I32 | I64, state: I32) -> tuple[int, int]:
    """Fill the state of a padded grid at rest; returns the lowest and the highest cost."""
    rows, columns = costs.shape
    stride = columns + 1
    low, high = np.int64(BLOCKED), np.int64(0)
    state[: stride + 1] = BLOCKED
    for r in range(rows):
        line = state[(r + 1) * stride + 1 : (r + 2) * stride + 1]
        for c in range(columns):
            cost = np.int64(costs[r, c])
            low, high = min(low, cost), max(high, cost)
            line[c] = -cost if cost > 0 else BLOCKED
        line[columns] = BLOCKED
    state[(rows + 1) * stride + 1 :] = BLOCKED
    state[-1] = -1  # a goal that never fires
    return int(low), int(high)


@_compiled
def _run(state: I32, following: I32, heads: I32, stride: int, high: int, start: int, goal: int) -> None:
    """Move from time step to time step until nothing is under way or the goal has fired."""
    mask = 1
    while mask < high:  # times under way span `high` steps, which need that many buckets and one
        mask = 2 * mask + 1
    heads[: mask + 1] = _EMPTY
    if state[start] >= 0:
        return
    state[start] = -state[start]
    following[start] = _EMPTY
    heads[state[start] & mask] = start
    under_way, now = 1, 0
    while under_way > 0 and state[goal] < 0:
        now += 1
        j = heads[now & mask]
        heads[now & mask] = _EMPTY
        while j != _EMPTY:
            under_way -= 1
            for step in (-stride, 1 - stride, 1, stride + 1, stride, stride - 1, -1, -stride - 1):
                i = np.uint64(j + step)  # unsigned: no test for an index counted from the end
                if state[i] < 0:
                    state[i] = now - state[i]
                    bucket = np.uint64(state[i] & mask)
                    following[i] = heads[bucket]
                    heads[bucket] = i
                    under_way += 1
            j = following[np.uint64(j)]


@_compiled
def _read(costs: I32 | I64, state: I32, arrivals: F64, pointers: I8) -> int:
    """Arrivals, and for each cell its lowest neighbour whose spike came then; returns the number of ties."""
    rows, columns = costs.shape
    stride = columns + 1
    ties = 0
    for r in range(rows):
        above, same, below = padded_rows(state, r, stride)
        for c in range(columns):
            fired = (same[c + 1] >= 0) & (costs[r, c] > 0)
            t = same[c + 1] - np.int32(costs[r, c]) if fired else np.int32(-BLOCKED)
            arrivals[r, c] = t if fired else np.inf
            k, hits = first_input(above, same, below, c, t)
            pointers[r, c] = k
            ties += hits > 1
    return ties
