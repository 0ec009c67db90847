"""Campaign: many runs, each by its key, that any process can make and a file keeps.

Every study of dies and every experiment that takes longer than two minutes is one. What holds for all:

- **Key.** It names a run, as ("chip", 1006) does a model and a forest. A run depends on its key and on the
  campaign's numbers alone, never on another run, on order, or on who makes it. Keys may be endless; more of
  them lengthen what is kept.
- **Result.** Plain data, of a type that `system.files.document` can hold a file against.
- **Order.** Results come in the order of their keys, whatever the order in which runs end, so that what
  follows from them, and the file, is the same to the byte for any number of workers.
- **Store.** A result is kept as soon as its turn comes, and a key that the store has is not run again. What
  is killed loses what is in work at most. Campaigns of experiments have a file with a line of JSON a run
  (`system.study.campaign_file`), studies of dies a folder with a table a chunk (`system.study.folder`).
- **Mark.** A digest of the numbers stands in the store; a store of other numbers is refused, never mixed.
- **Workers.** This process (`here`), threads (`system.study.engine`), or processes, here or on a Dask
  cluster (`system.study.cluster`). A run whose process dies is made again.

    campaign = Campaign("coins", toss, Numbered, Side, (WEIGHT,))
    sides = execution.by_condition(campaign, [Numbered("fair", k) for k in range(count)], progress)
"""

from __future__ import annotations

import hashlib
import os
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from circuits.errors import ParameterError
from system.study.campaign_file import CampaignFile, open_runs
from system.study.waiting import Work, outcome_of

Key = TypeVar("Key")
Result = TypeVar("Result")
AnyKey_contra = TypeVar("AnyKey_contra", contravariant=True)

# How a run is handed out: it takes what makes runs, and a key.
Submit = Callable[[Callable[[Any], Any], Any], Work[Any]]
AHEAD = 2  # runs a worker that are handed out before they are asked for
MOST_WORKERS = 1024  # threads or processes; ours


def thread_count(asked: int | None) -> int:
    """Return how many threads were asked for, one a core for None.

    Raises `ParameterError` for a number below 1 or above `MOST_WORKERS`.
    """
    threads = os.cpu_count() or 1 if asked is None else asked
    if not 1 <= threads <= MOST_WORKERS:
        raise ParameterError(f"threads: {threads}, must be at least 1 and at most {MOST_WORKERS}")
    return threads


class Numbered(NamedTuple):
    """The usual key: a condition, and the number of a seed or of a die."""

    condition: str
    number: int


@dataclass(frozen=True, slots=True)
class Campaign(Generic[Key, Result]):
    """What is run, and what it depends on.

    name: of the campaign, which its file carries; one: makes the run of a key, a function of a module or an
    instance of a class of one, so that other processes find it; key, result: their types; numbers: what a
    result depends on besides its key, by `repr`.
    """

    name: str
    one: Callable[[Key], Result]
    key: type[Key]
    result: type[Result]
    numbers: tuple[object, ...] = ()

    @property
    def mark(self) -> str:
        """Digest of the numbers: 16 hexadecimal digits."""
        text = "\n".join(repr(x) for x in self.numbers)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


class Store(Protocol[AnyKey_contra, Result]):
    """Where results are kept."""

    def find(self, key: AnyKey_contra) -> Result | None:
        """The result of a key, None where there is none yet."""

    def keep(self, key: AnyKey_contra, result: Result) -> None:
        """Add a result, which outlives the process from then on."""


@dataclass(frozen=True, slots=True)
class Workers:
    """Who makes runs.

    submit: hands one out; ahead: how many are handed out beyond the one that is waited for; asked: is set
    where an interruption was asked for.
    """

    submit: Submit
    ahead: int
    asked: Event


@dataclass(frozen=True, slots=True)
class _Promise(Generic[Key, Result]):
    """A run that is made where it is asked for."""

    one: Callable[[Key], Result]
    key: Key

    def add_done_callback(self, fn: Callable[[Any], object], /) -> None:
        fn(self)

    def result(self) -> Result:
        return self.one(self.key)


@dataclass(frozen=True, slots=True)
class _Kept(Generic[Result]):
    """A result that the store has."""

    known: Result

    def add_done_callback(self, fn: Callable[[Any], object], /) -> None:
        fn(self)

    def result(self) -> Result:
        return self.known


def here() -> AbstractContextManager[Workers]:
    """One run at a time, in this process."""
    return nullcontext(Workers(_Promise, 0, Event()))


def in_order(
    one: Callable[[Key], Result], keys: Iterable[Key], store: Store[Key, Result] | None, workers: Workers
) -> Generator[tuple[Key, Result], None, None]:
    """Keys with their results, in order: from the store, or made by workers and kept.

    Raises `KeyboardInterrupt` soon after one was asked for, and what a run or the store raises.
    """
    waiting: deque[tuple[Key, Work[Result]]] = deque()
    for key in keys:
        known = None if store is None else store.find(key)
        waiting.append((key, workers.submit(one, key) if known is None else _Kept(known)))
        if len(waiting) > workers.ahead:
            yield _taken(*waiting.popleft(), store, workers.asked)
    while waiting:
        yield _taken(*waiting.popleft(), store, workers.asked)


def _taken(
    key: Key, work: Work[Result], store: Store[Key, Result] | None, asked: Event
) -> tuple[Key, Result]:
    """Wait for a run, and keep it unless it is."""
    result = outcome_of(work, asked)
    if store is not None and not isinstance(work, _Kept):
        store.keep(key, result)
    return key, result


@dataclass(frozen=True, slots=True)
class Runs(Generic[Key, Result]):
    """A campaign while its store is open: may be asked for runs several times, as earlier ones decide."""

    one: Callable[[Key], Result]
    store: CampaignFile[Key, Result] | None
    workers: Workers

    def of(self, keys: Iterable[Key]) -> Generator[Result, None, None]:
        """Results of keys, in their order; an endless sequence of keys is asked for as far as needed."""
        for _, result in in_order(self.one, keys, self.store, self.workers):
            yield result


@dataclass(frozen=True, slots=True)
class Execution:
    """Where a campaign's runs are kept, and who makes them.

    file: nowhere unless given; resume: go on with a file that is there, which is refused otherwise; workers:
    `here`, or `system.study.cluster.on_cluster` with its arguments.
    """

    file: Path | None = None
    resume: bool = False
    workers: Callable[[], AbstractContextManager[Workers]] = here

    @contextmanager
    def open(self, campaign: Campaign[Key, Result]) -> Iterator[Runs[Key, Result]]:
        """Begin a campaign, or go on with it.

        Raises
        ------
        ParameterError
            The file is there and `resume` is not given, or it is not this campaign's own.
        DataError
            The file cannot be read or written.
        """
        header = {"campaign": campaign.name, "mark": campaign.mark}
        kept = (
            nullcontext()
            if self.file is None
            else open_runs(self.file, header, campaign.key, campaign.result, resume=self.resume)
        )
        with kept as store, self.workers() as workers:
            yield Runs(campaign.one, store, workers)

    def results(self, campaign: Campaign[Key, Result], keys: Iterable[Key]) -> Generator[Result, None, None]:
        """Results of keys, in their order; as `open` with one question."""
        with self.open(campaign) as runs:
            yield from runs.of(keys)

    def by_condition(
        self,
        campaign: Campaign[Numbered, Result],
        keys: Sequence[Numbered],
        progress: Callable[[float], object],
    ) -> dict[str, list[Result]]:
        """All results of keys by their conditions; `progress` takes the share that is done."""
        found: dict[str, list[Result]] = {condition: [] for condition, _ in keys}
        with closing(self.results(campaign, keys)) as results:
            for done, ((condition, _), result) in enumerate(zip(keys, results, strict=True), 1):
                found[condition].append(result)
                progress(done / len(keys))
        return found


ALONE = Execution()
