"""Compiled wave on any graph, each of whose axons has a delay of its own.

A cell waits twice: until its time is final, and then until its first spike arrives somewhere. Both queues
have buckets narrower than the smallest delay. In a bucket that is due all spikes are delivered first; then
the cells whose times lie in it are final, because no spike of theirs arrives before the next bucket. A cell
that a later delivery reaches earlier moves, so buckets are lists linked in both directions. With axons of a
cell that are nearly equal this is seldom.

Where the delays span more than `WIDEST` there would be too many buckets, and a binary heap takes their place;
entries that an earlier spike has overtaken are skipped when they come up.
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64, I8, I32, I64, Bools
from circuits.compiled import compiled

BUCKETS = 2**12  # at most, round and round
WIDEST = 4_000.0  # largest delay over the smallest, with buckets
NARROWER = 1.001  # than the smallest delay: rounding of t / width, below 1e12, is less than that
REFUSED, TOO_WIDE = -1, -2
_EMPTY = -1
_INFINITY = 0x7FF0000000000000  # bits of inf
_TIED = -2  # minus the lowest input, while the wave runs

_compiled = compiled()


@_compiled
def spread_dies(
    axons: tuple[I64, I32, I8], delays: F64, blocked: Bools, found: tuple[F64, I8, I64], work: I32,
    ends: tuple[int, int],
) -> bool:  # fmt: skip
    """Run a wave on each of several dies; returns whether all of them were run.

    axons: offsets int64[n + 1], targets int32[e] and inputs int8[e]; delays: float64[dies, e], inf for no
    axon; blocked: bool[n]; found: arrivals float64[dies, n], pointers int8[dies, n] and ties int64[dies]
    are filled, a number of ties being `REFUSED` where a delay is not above 0 and `TOO_WIDE` where there
    would be too many buckets; work: int32[2 n + 2 BUCKETS], scratch; ends: start and
    goal, the goal -1 for none.
    """
    all_run = True
    for die in range(found[2].size):
        arrivals, pointers = found[0][die], found[1][die]
        edges = (axons[0], axons[1], axons[2], delays[die])
        low, high = _extent(delays[die])
        found[2][die] = TOO_WIDE if low > 0.0 else REFUSED
        if low > 0.0 and high <= WIDEST * low:
            start, goal = _prepare(blocked, arrivals, pointers, ends)
            if start >= 0:
                _run(edges, arrivals, pointers, work, (low, high), (start, goal))
            found[2][die] = _cut(arrivals, pointers, goal)
        all_run = all_run and found[2][die] >= 0
    return all_run


@_compiled
def spread_by_heap(
    edges: tuple[I64, I32, I8, F64], blocked: Bools, arrivals: F64, pointers: I8, heap: I32, keys: F64,
    ends: tuple[int, int],
) -> int:  # fmt: skip
    """The same with a binary heap on one die; heap: int32[e + 1] and keys: float64[e + 1], scratch."""
    start, goal = _prepare(blocked, arrivals, pointers, ends)
    if start >= 0:
        _run_heap(edges, arrivals, pointers, heap, keys, (start, goal))
    return int(_cut(arrivals, pointers, goal))


@_compiled
def _extent(delays: F64) -> tuple[float, float]:
    """Smallest delay and largest below inf; NaN and 0 if one is not above 0.

    Of the bits as integers: in the order of the numbers where these are above 0, and quickly compared.
    """
    low, high, highest = np.int64(_INFINITY), np.int64(0), np.int64(0)
    bits = delays.view(np.int64)
    for e in range(bits.size):
        low, highest = min(low, bits[e]), max(highest, bits[e])
        high = max(high, bits[e] if bits[e] < _INFINITY else np.int64(0))
    if low <= 0 or highest > _INFINITY:
        return np.nan, 0.0
    return np.int64(low).view(np.float64), np.int64(high).view(np.float64)


@_compiled
def _lead(j: np.uint64, offsets: I64, delays: F64) -> float:
    """Smallest delay of a cell's axons, inf where it has none."""
    least = np.inf
    for edge in range(offsets[j], offsets[j + np.uint64(1)]):
        least = min(least, delays[np.uint64(edge)])
    return least


@_compiled
def _prepare(blocked: Bools, arrivals: F64, pointers: I8, ends: tuple[int, int]) -> tuple[int, int]:
    """All cells at rest; returns start and goal, -1 where there is none or it is blocked."""
    for i in range(arrivals.size):
        arrivals[i] = -np.inf if blocked[i] else np.inf
        pointers[i] = _EMPTY
    start, goal = ends
    return (-1 if blocked[start] else start), (-1 if goal < 0 or blocked[goal] else goal)


@_compiled
def _run(
    edges: tuple[I64, I32, I8, F64], arrivals: F64, pointers: I8, work: I32, extent: tuple[float, float],
    ends: tuple[int, int],
) -> None:  # fmt: skip
    """Move from bucket to bucket until none is filled or the goal's time is final."""
    n, scale = arrivals.size, NARROWER / extent[0]
    mask = 1
    while mask <= extent[1] * scale + 1.0:
        mask = 2 * mask + 1
    links, heads = work[: 2 * n].reshape(n, 2), work[2 * n :]
    sending, settling = heads[: mask + 1], heads[mask + 1 : 2 * mask + 2]
    heads[: 2 * mask + 2] = _EMPTY
    start, goal = ends
    arrivals[start] = 0.0
    _link(np.uint64(start), np.uint64(0), links, settling)
    waiting, now = 1, 0
    while waiting > 0:
        due = np.uint64(now & mask)
        j = np.int64(sending[due])
        sending[due] = _EMPTY
        while j != _EMPTY:
            waiting += _send(np.uint64(j), edges, arrivals, pointers, links, scale, mask, settling) - 1
            j = np.int64(links[np.uint64(j), 0])
        j = np.int64(settling[due])
        settling[due] = _EMPTY
        while j != _EMPTY:
            i = np.uint64(j)
            j = np.int64(links[i, 0])
            waiting -= 1
            lead = _lead(i, edges[0], edges[3])
            if lead < np.inf:
                waiting += 1
                _link(i, np.uint64(np.int64((arrivals[i] + lead) * scale) & mask), links, sending)
        if goal >= 0 and arrivals[goal] * scale < now + 1.0:
            return
        now += 1


@_compiled
def _send(
    j: np.uint64, edges: tuple[I64, I32, I8, F64], arrivals: F64, pointers: I8, links: I32, scale: float,
    mask: int, settling: I32,
) -> int:  # fmt: skip
    """Deliver the spikes of cell j; returns how many cells have been reached for the first time."""
    offsets, targets, inputs, delays = edges
    reached, sent = 0, arrivals[j]
    for edge in range(offsets[j], offsets[j + np.uint64(1)]):
        e = np.uint64(edge)
        i, time = np.uint64(targets[e]), sent + delays[e]
        old = arrivals[i]
        if time > old:
            continue
        if time == old:
            if time < np.inf:
                pointers[i] = _together(pointers[i], inputs[e])
            continue
        bucket = np.int64(time * scale)
        if old == np.inf:
            reached += 1
            _link(i, np.uint64(bucket & mask), links, settling)
        elif np.int64(old * scale) != bucket:
            _unlink(i, np.uint64(np.int64(old * scale) & mask), links, settling)
            _link(i, np.uint64(bucket & mask), links, settling)
        arrivals[i], pointers[i] = time, inputs[e]
    return reached


@_compiled
def _together(pointer: int, which: int) -> int:
    """Pointer of a cell that a spike at another input reaches at the same time; -2 - k marks a tie."""
    lowest = min(pointer if pointer >= 0 else _TIED - pointer, which)
    return _TIED - lowest


@_compiled
def _link(i: np.uint64, bucket: np.uint64, links: I32, heads: I32) -> None:
    first = heads[bucket]
    links[i, 0], links[i, 1] = first, _EMPTY
    if first != _EMPTY:
        links[np.uint64(first), 1] = i
    heads[bucket] = i


@_compiled
def _unlink(i: np.uint64, bucket: np.uint64, links: I32, heads: I32) -> None:
    after, before = links[i, 0], links[i, 1]
    if before == _EMPTY:
        heads[bucket] = after
    else:
        links[np.uint64(before), 0] = after
    if after != _EMPTY:
        links[np.uint64(after), 1] = before


@_compiled
def _run_heap(
    edges: tuple[I64, I32, I8, F64], arrivals: F64, pointers: I8, heap: I32, keys: F64, ends: tuple[int, int]
) -> None:
    """Take the earliest cell until none waits or it comes after the goal."""
    offsets, targets, inputs, delays = edges
    start, goal = ends
    arrivals[start] = 0.0
    heap[0], keys[0] = start, 0.0
    size = 1
    while size > 0:
        j, now = heap[0], keys[0]
        size -= 1
        _sift_down(heap, keys, size)
        if goal >= 0 and now > arrivals[goal]:
            return
        if now > arrivals[j]:
            continue
        for e in range(offsets[j], offsets[j + 1]):
            i, time = targets[e], now + delays[e]
            if time < arrivals[i]:
                arrivals[i], pointers[i] = time, inputs[e]
                _sift_up(heap, keys, size, i, time)
                size += 1
            elif time == arrivals[i] and time < np.inf:
                pointers[i] = _together(pointers[i], inputs[e])


@_compiled
def _sift_up(heap: I32, keys: F64, k: int, cell: int, key: float) -> None:
    """Add an entry at the end, k, and move it up."""
    while k > 0 and keys[(k - 1) // 2] > key:
        heap[k], keys[k] = heap[(k - 1) // 2], keys[(k - 1) // 2]
        k = (k - 1) // 2
    heap[k], keys[k] = cell, key


@_compiled
def _sift_down(heap: I32, keys: F64, size: int) -> None:
    """Put the entry at `size`, the last, in the place of the first, and move it down."""
    cell, key = heap[size], keys[size]
    k = 0
    while 2 * k + 1 < size:
        child = 2 * k + 1
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        heap[k], keys[k] = heap[child], keys[child]
        k = child
    heap[k], keys[k] = cell, key


@_compiled
def _cut(arrivals: F64, pointers: I8, goal: int) -> int:
    """Forget what comes after the goal's spike; returns the number of ties."""
    last = np.inf if goal < 0 else arrivals[goal]
    ties = 0
    for i in range(arrivals.size):
        there = (arrivals[i] >= 0.0) & (arrivals[i] <= last) & (arrivals[i] < np.inf)
        pointer = np.int64(pointers[i])
        tied = there & (pointer <= _TIED)
        ties += tied
        pointer = _TIED - pointer if tied else pointer
        pointers[i] = pointer if there else _EMPTY
        arrivals[i] = arrivals[i] if there else np.inf
    return ties
