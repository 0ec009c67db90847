"""Compiled wave on a grid whose delays are real numbers that belong to the sending cells.

t_i = min_j (t_j + D_j), by buckets of spikes under way. A bucket is narrower than the smallest delay, so
that no cell which fires in it sends a spike into the same bucket; all of its deliveries are made first, and
then the cells that they reached hold their final times and send in their turn. Each cell enters the queue
once.

The grid is padded as `chips.wavefront.wave.integer` says. Times of cells that may still fire are inf, of
blocked cells and of the padding -inf, so that one comparison decides whether a spike counts.
"""

from __future__ import annotations

import numpy as np

from chips.wavefront.wave.integer import first_input, padded_cell, padded_rows
from circuits.arrays import F64, I8, I32
from circuits.compiled import compiled

BUCKETS = 2**12  # at most, round and round
WIDEST = 4_000.0  # largest delay over the smallest
NARROWER = 1.001  # than the smallest delay: rounding of t / width, below 1e12, is less than that
REFUSED, TOO_WIDE = -1, -2
_EMPTY = -1

_compiled = compiled()


@_compiled
def spread(delays: F64, times: F64, work: I32, arrivals: F64, pointers: I8, start: int, goal: int) -> int:
    """Run a wave; returns the number of ties, `REFUSED` (a delay not above 0) or `TOO_WIDE` (their range).

    delays: float64[rows, columns], inf for blocked; times: float64[2, padded] and work: int32[padded +
    BUCKETS], scratch, padded = (rows + 2) (columns + 1) + 2; the others as in
    `chips.wavefront.wave.integer.spread`.
    """
    columns = delays.shape[1]
    stride = columns + 1
    padded = times.shape[1]
    fired, lines = times[0], times[1]
    low, high = _prepare(delays, fired, lines)
    if not low > 0.0:
        return REFUSED
    if high > WIDEST * low:
        return TOO_WIDE
    start = padded_cell(start, columns)
    goal = padded - 1 if goal < 0 else padded_cell(goal, columns)
    goal = padded - 1 if fired[goal] < 0.0 else goal
    if fired[start] > 0.0:
        _run(times, work, stride, NARROWER / low, high, start, goal)
    return int(_read(fired, lines, arrivals, pointers, fired[goal]))


@_compiled
def _prepare(delays: F64, fired: F64, lines: F64) -> tuple[float, float]:
    """Fill a padded grid at rest; returns the smallest and the largest delay, NaN and 0 if one is wrong."""
    rows, columns = delays.shape
    stride = columns + 1
    low, high, wrong = np.inf, 0.0, 0
    fired[:] = -np.inf
    lines[:] = -np.inf
    for r in range(rows):
        for c in range(columns):
            delay = delays[r, c]
            i = (r + 1) * stride + c + 1
            lines[i] = -delay
            wrong += not delay > 0.0
            low = min(low, delay)
            if delay < np.inf:
                high = max(high, delay)
                fired[i] = np.inf
    fired[-1] = np.inf  # a goal that never fires
    return (np.nan, 0.0) if wrong > 0 else (low, high)


@_compiled
def _run(times: F64, work: I32, stride: int, scale: float, high: float, start: int, goal: int) -> None:
    """Move from bucket to bucket; the first of `times` becomes t, the second, at first -D, becomes t + D."""
    fired, lines = times[0], times[1]
    following, heads = work[: fired.size], work[fired.size :]
    mask = 1
    while mask <= high * scale + 1.0:
        mask = 2 * mask + 1
    heads[: mask + 1] = _EMPTY
    fired[start] = 0.0
    following[start] = _EMPTY
    fresh, under_way, now = np.int64(start), 0, -1
    while True:
        while fresh != _EMPTY:
            i = np.uint64(fresh)
            fresh = np.int64(following[i])
            lines[i] = fired[i] - lines[i]
            bucket = np.uint64(np.int64(lines[i] * scale) & mask)
            following[i] = heads[bucket]
            heads[bucket] = i
            under_way += 1
        if under_way == 0 or fired[goal] < np.inf:
            return
        now += 1
        j = np.int64(heads[np.uint64(now & mask)])
        heads[np.uint64(now & mask)] = _EMPTY
        while j != _EMPTY:
            under_way -= 1
            arrival = lines[np.uint64(j)]
            for step in (-stride, 1 - stride, 1, stride + 1, stride, stride - 1, -1, -stride - 1):
                k = np.uint64(j + step)
                if arrival < fired[k]:
                    if fired[k] == np.inf:
                        following[k] = fresh
                        fresh = np.int64(k)
                    fired[k] = arrival
            j = np.int64(following[np.uint64(j)])


@_compiled
def _read(fired: F64, lines: F64, arrivals: F64, pointers: I8, last: float) -> int:
    """Arrivals up to `last`, and the lowest neighbour whose spike came then; returns the number of ties."""
    rows, columns = arrivals.shape
    stride = columns + 1
    ties = 0
    for r in range(rows):
        above, same, below = padded_rows(lines, r, stride)
        own = fired[(r + 1) * stride : (r + 2) * stride + 1]
        for c in range(columns):
            there = (own[c + 1] >= 0.0) & (own[c + 1] <= last) & (own[c + 1] < np.inf)
            t = own[c + 1] if there else np.nan
            arrivals[r, c] = t if there else np.inf
            k, hits = first_input(above, same, below, c, t)
            pointers[r, c] = k
            ties += hits > 1
    return ties
