"""The way in of one client: its events are checked, and wait for their time in a queue of limited length.

Nothing is lost silently: what does not wait is counted under the code that says why. Times of events must not
fall; an event with a time below 0 is for as soon as may be. In a fast run no event may be before the chip's
time; at real pace one that is late is taken at once, and counted.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np

from circuits.arrays import I64, Bools
from system.stream.record import Code, Counts

ROOM = 2**18  # events that wait; ours
FARTHEST = 3_600_000_000  # us that an event may be ahead of the chip; ours
Takes = Callable[[I64], Bools]


class Inlet:
    """Events of one client that wait.

    takes : whether each of some addresses can be taken; counts : of the client, which go on here.
    last : time that has been told, us: no event before it will come; waiting : how many events wait.
    ended : whether the client said that no more will come.
    remarks : what to say of the first event of each kind that was not taken.
    """

    def __init__(self, takes: Takes, counts: Counts) -> None:
        self.takes, self.counts = takes, counts
        self.last = self.waiting = 0
        self.ended = False
        self.remarks: list[str] = []
        self._queue: deque[I64] = deque()

    @property
    def full(self) -> bool:
        """Whether no more event has room."""
        return self.waiting >= ROOM

    def begin(self, now: int) -> None:
        """Begin at the chip's time, us, before which no event may be."""
        self.last = max(self.last, now)

    def take(self, rows: I64, now: int) -> None:
        """Take records, int64[m, 2], at the chip's time `now`, us."""
        if self.ended or not len(rows):
            return
        end = np.flatnonzero(rows[:, 1] == Code.END)
        rows = rows[: end[0]] if end.size else rows
        times, addresses = rows[:, 0], rows[:, 1]
        events = addresses >= 0
        soon = events & (times < 0)
        known = self._known(addresses, events)
        good = known & self._near(times, events & known, now)
        floor = np.maximum.accumulate(np.concatenate(([self.last], np.where(good, times, self.last))))
        before, self.last = floor[:-1], int(floor[-1])
        fallen = good & events & ~soon & (times < before)
        if fallen.any():
            k = int(fallen.argmax())
            self._count(
                Code.BACKWARDS, fallen, f"event at {times[k]} us, after {before[k]} us; send in order"
            )
        kept = good & events & ~fallen
        self._wait(np.column_stack((np.maximum(np.where(soon, now, times), before), addresses))[kept])
        if end.size:
            self.end()

    def end(self) -> None:
        """Wait for no more events; the last of them is to be taken too."""
        self.last += bool(self._queue) and self._queue[-1][-1, 0] == self.last
        self.ended = True

    def limit(self, until: int, most: int) -> int:
        """Return a time up to `until`, us, before which no more than `most` events wait, if times let it."""
        for rows in self._queue:
            if most < len(rows):
                time, first = int(rows[most, 0]), int(self._queue[0][0, 0])
                return min(until, max(time, first + 1))
            most -= len(rows)
        return until

    def due(self, until: int, now: int, most: int = ROOM) -> I64:
        """Take out at most so many events before `until`, us, int64[m, 2]; none is then before `now`, us."""
        out = []
        while self._queue and most and self._queue[0][0, 0] < until:
            rows = self._queue.popleft()
            split = min(int(np.searchsorted(rows[:, 0], until)), most)
            out.append(rows[:split])
            most -= split
            if split < len(rows):
                self._queue.appendleft(rows[split:])
                break
        if not out:
            return np.empty((0, 2), dtype=np.int64)
        rows = np.concatenate(out)
        self.waiting -= len(rows)
        self.counts[Code.TAKEN] += len(rows)
        self.counts[Code.LATE] += int(np.count_nonzero(rows[:, 0] < now))
        rows[:, 0] = np.maximum(rows[:, 0], now)
        return rows

    def leave(self) -> None:
        """Let go of what waits."""
        self.counts[Code.LEFT] += self.waiting
        self.waiting, self.ended = 0, True
        self._queue.clear()

    def refuse(self, rows: I64, why: str) -> None:
        """Count all events of records, int64[m, 2], as refused."""
        self._count(Code.REFUSED, rows[:, 1] >= 0, why)
        self.ended = self.ended or bool((rows[:, 1] == Code.END).any())

    def _known(self, addresses: I64, events: Bools) -> Bools:
        known: Bools = (addresses == Code.TIME) | (events & self.takes(addresses))
        if not known.all():
            wrong = addresses[~known][0]
            self._count(Code.UNKNOWN, ~known, f"address {wrong}, not on the chip; see its addresses")
        return known

    def _near(self, times: I64, events: Bools, now: int) -> Bools:
        """Whether times are not too far ahead; events: those that count."""
        near: Bools = times <= now + FARTHEST
        if not near.all():
            why = f"time {times[~near][0]} us, must be within an hour of the chip's, {now} us; send later"
            self._count(Code.FAR, events & ~near, why)
        return near

    def _wait(self, rows: I64) -> None:
        room = max(ROOM - self.waiting, 0)
        self.counts[Code.DROPPED_IN] += max(len(rows) - room, 0)
        rows = rows[:room]
        if len(rows):
            self._queue.append(rows)
            self.waiting += len(rows)

    def _count(self, code: Code, which: Bools, why: str) -> None:
        found = int(np.count_nonzero(which))
        if found and not self.counts[code]:
            self.remarks.append(why)
        self.counts[code] += found
