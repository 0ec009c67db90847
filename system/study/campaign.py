"""Campaigns of experiments: many long runs, each by its key, on processes if asked for, and kept in a file.

A run depends on its key alone. Runs are taken in the order of their keys, whatever the order in which they
end, and each is a line of JSON in the file as soon as it is taken: the file is the same to the byte from any
number of workers, an interrupted campaign loses what is in work at most, and a key that the file has is not
run again.

The first line names the campaign and a mark of all numbers that its runs depend on; a file with another one
is refused (`system.study.campaign_file`).
"""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Callable, Generator, Iterable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import Any

from system.study.campaign_file import CampaignFile, Found, Key, open_runs
from system.study.waiting import Work, outcome_of

One = Callable[[Key], Found]


@dataclass(frozen=True, slots=True)
class _Run:
    """A run that is made where it is asked for."""

    one: One
    key: Key

    def add_done_callback(self, fn: Callable[[Any], object], /) -> None:
        fn(self)

    def result(self) -> Found:
        return self.one(self.key)


# How a run is handed out, how many at once, and an event that an interruption sets.
Hands = tuple[Callable[[One, Key], Work[Found]], int, Event]


def here() -> AbstractContextManager[Hands]:
    """One run at a time, in this process."""
    return nullcontext((_Run, 0, Event()))


@dataclass(frozen=True, slots=True)
class Campaign:
    """Where runs are kept, and who makes them (`here`, or `system.study.cluster.workers_of`).

    file: nowhere unless given; resume: go on with a file that is there, which is refused otherwise.
    """

    file: Path | None = None
    resume: bool = False
    hands: Callable[[], AbstractContextManager[Hands]] = here

    def runs(
        self, name: str, numbers: Iterable[object], one: One, keys: Iterable[Key]
    ) -> Generator[Found, None, None]:
        """Results of keys, in their order; an endless sequence of keys is asked for as far as needed.

        Parameters
        ----------
        name, numbers
            Of the campaign; what its runs depend on besides their keys, by `repr`.
        one
            A function of a module, which other processes can find; what it returns is JSON's.
        keys
            What to run.

        Raises
        ------
        ParameterError
            The file is there and `resume` is not given, or it is not this campaign's own.
        DataError
            The file cannot be read or written.
        """
        header = _header(name, numbers)
        kept = nullcontext() if self.file is None else open_runs(self.file, header, resume=self.resume)
        with kept as file, self.hands() as (submit, ahead, asked):
            waiting: deque[tuple[Key, Found | Work[Found]]] = deque()
            for key in keys:
                known = None if file is None else file.find(key)
                waiting.append((key, submit(one, key) if known is None else known))
                if len(waiting) > ahead:
                    yield _taken(*waiting.popleft(), file, asked)
            while waiting:
                yield _taken(*waiting.popleft(), file, asked)


def _taken(key: Key, pending: Found | Work[Found], file: CampaignFile | None, asked: Event) -> Found:
    """Wait for a run and keep it; raises `KeyboardInterrupt` soon after it was asked for."""
    if isinstance(pending, dict):
        return pending
    found = outcome_of(pending, asked)
    if file is not None:
        file.keep(key, found)
    return found


ALONE = Campaign()


def _header(name: str, numbers: Iterable[object]) -> Found:
    text = "\n".join(repr(x) for x in numbers)
    return {"campaign": name, "mark": hashlib.sha256(text.encode()).hexdigest()[:16]}
