"""A page that is written anew while the work goes on that it tells of."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar, final

EVERY = 5  # s between two pages at least, and after which an unfinished one is read again; ours
SHARE = 0.05  # of the time that pages may take; ours

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Going:
    """Work that is not finished.

    refresh : s after which its page is to read itself again; 0 for one that nobody goes on with now.
    """

    refresh: int

    @property
    def said(self) -> str:
        """What its page says of that."""
        if self.refresh:
            return f"This page reads itself again every {self.refresh} s."
        return "It was interrupted, and can go on."


@final
class Growing(Generic[T]):
    """Writes a page of what was found so far, now and then.

    write : writes the page of what it is given; the second argument is after how many seconds the page is to
        read itself again, 0 for never. first : s before the first page. clock : gives the time, s.
    """

    def __init__(
        self,
        write: Callable[[T, int], object],
        first: float = EVERY,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Nothing is written yet."""
        self._write, self._clock = write, clock
        self._due = clock() + first
        self._last: T | None = None

    def __call__(self, found: T) -> None:
        """Tell what was found so far."""
        self._last = found
        begin = self._clock()
        if begin < self._due:
            return
        self._write(found, EVERY)
        end = self._clock()
        self._due = end + max(EVERY, (end - begin) / SHARE)

    def leave(self) -> None:
        """Write the page of what was found before the work was interrupted, which waits for nothing."""
        if self._last is not None:
            self._write(self._last, 0)
