"""Campaigns of experiments: many long runs, each by its key, on processes if asked for, and kept in a file.

A run depends on its key alone. Runs are taken in the order of their keys, whatever the order in which they
end, and each is a line of JSON in the file as soon as it is taken: the file is the same to the byte from any
number of workers, an interrupted campaign loses what is in work at most, and a key that the file has is not
run again.

The first line names the campaign and a mark of all numbers that its runs depend on; a file with another one
is refused. Half a last line, of a process that was killed while it wrote, is cut off.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections import deque
from collections.abc import Callable, Generator, Iterable
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import Any, Protocol

from circuits.errors import DataError, ParameterError

Key = tuple[str, int]  # condition, and seed or die
Found = dict[str, Any]  # of a run, in JSON's own types
One = Callable[[Key], Found]
_PATIENCE = 0.2  # s, after which a wait looks whether it was interrupted


class Pending(Protocol):
    """A run that was handed out."""

    def result(self, timeout: float | None = None) -> Found:
        """Wait for it, `TimeoutError` after so many seconds."""


@dataclass(frozen=True, slots=True)
class _Run:
    """A run that is made where it is asked for."""

    one: One
    key: Key

    def result(self, timeout: float | None = None) -> Found:
        return self.one(self.key)


# How a run is handed out, how many at once, and an event that an interruption sets.
Hands = tuple[Callable[[One, Key], Pending], int, Event]


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
            The file is there and `resume` is not given, or it is of another campaign or other numbers.
        DataError
            The file cannot be read or written.
        """
        known = {} if self.file is None else _begun(self.file, _header(name, numbers), resume=self.resume)
        with self.hands() as (submit, ahead, asked):
            waiting: deque[tuple[Key, Found | Pending]] = deque()
            for key in keys:
                waiting.append((key, known[key] if key in known else submit(one, key)))
                if len(waiting) > ahead:
                    yield self._taken(*waiting.popleft(), asked)
            while waiting:
                yield self._taken(*waiting.popleft(), asked)

    def _taken(self, key: Key, pending: Found | Pending, asked: Event) -> Found:
        """Wait for a run and keep it; raises `KeyboardInterrupt` soon after it was asked for."""
        if isinstance(pending, dict):
            return pending
        found: Found | None = None
        while found is None:
            with suppress(TimeoutError):
                found = pending.result(_PATIENCE)
            if asked.is_set():
                raise KeyboardInterrupt
        if self.file is not None:
            _append(self.file, {"key": key, "found": found})
        return found


ALONE = Campaign()


def _header(name: str, numbers: Iterable[object]) -> Found:
    text = "\n".join(repr(x) for x in numbers)
    return {"campaign": name, "mark": hashlib.sha256(text.encode()).hexdigest()[:16]}


def _begun(path: Path, header: Found, *, resume: bool) -> dict[Key, Found]:
    """Runs that a file has, which is begun where there is none."""
    if not path.exists():
        if resume:
            raise ParameterError(f"--resume: {path} is not there, nothing to go on with; leave it out")
        _append(path, header)
        return {}
    if not resume:
        raise ParameterError(f"--output: {path} is there; add --resume to go on with it, or name another")
    lines = _whole_lines(path)
    if not lines:
        _append(path, header)
        return {}
    if _parsed(path, 0, lines[0]) != header:
        raise ParameterError(
            f"--resume: {path} has another campaign, or one with other numbers; name another file"
        )
    found: dict[Key, Found] = {}
    for k, line in enumerate(lines[1:], 1):
        row = _parsed(path, k, line)
        try:
            condition, number = row["key"]
            found[str(condition), int(number)] = dict(row["found"])
        except (KeyError, TypeError, ValueError):
            raise DataError(f"{path}: line {k + 1}, must have a key and what was found") from None
    return found


def _whole_lines(path: Path) -> list[str]:
    """Lines of a file, which loses what follows the last one's end."""
    try:
        data = path.read_bytes()
        whole = data[: data.rfind(b"\n") + 1]
        if whole != data:
            os.truncate(path, len(whole))
        return whole.decode().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: cannot be read, {error}; name another file") from None


def _parsed(path: Path, k: int, line: str) -> Found:
    with suppress(ValueError):
        row = json.loads(line)
        if isinstance(row, dict):
            return row
    raise DataError(f"{path}: line {k + 1} is broken; delete it, or name another file")


def _append(path: Path, row: Found) -> None:
    try:
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise DataError(f"{path}: cannot be written, {error.strerror}; name another file") from None
