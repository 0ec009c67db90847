"""Running a study: chunks of dies on threads or on a Dask cluster, kept on disk as they are finished.

A chunk depends on the study alone, so that workers, order, interruptions and resumes change nothing. Chunks
are taken in order, whatever the order in which they end, and a rule that stops early sees them so. At most
what is in work is lost when everything is killed: a chunk's file is there whole or not at all, and a file
that cannot be read is measured again and counted.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Event

import numpy as np

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.options.block import read_die
from system.study.folder import StudyFiles, keep_chunk, keep_samples, known_chunk, open_folder
from system.study.manifest import Study
from system.study.plan import sampling
from system.study.table import Table, empty, join
from system.study.target import Target, measure_safely, open_target
from system.study.waiting import Work, check, interrupts, outcome_of

AHEAD = 2  # chunks a worker that are handed out before they are asked for
MOST_WORKERS = 1024  # threads or processes; ours
_PIECES = 8  # of a chunk, shared by the threads, so that none waits long for the last one


Handed = tuple[Work[Table], ...]  # pieces of a chunk, in order
Submit = Callable[[Study, range], Handed]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a study came to.

    table: samples in order; chunks_read, chunks_redone: taken from disk, and measured again because their
    file was broken; stopped: whether a rule ended the study before its last die.
    """

    table: Table
    chunks_read: int
    chunks_redone: tuple[str, ...]
    stopped: bool


def measure_dies(study: Study, dies: range) -> Table:
    """Measure one chunk, its samples in order."""
    target = open_target(study.subject)
    quantities = tuple(q.name for q in target.quantities)
    found, where = [], []
    for die in dies_of(study, target, dies):
        for condition in study.conditions:
            found.append(measure_safely(target, die, condition))
            where.append((die.number or 0, condition))
    if not found:
        return empty(quantities)
    return Table(
        quantities,
        np.array([number for number, _ in where], dtype=np.int64),
        tuple(c.corner for _, c in where),
        np.array([c.temperature_c for _, c in where]),
        np.array([c.trial for _, c in where], dtype=np.int64),
        tuple(m.outcome for m in found),
        tuple(m.reason for m in found),
        np.array([m.values for m in found], dtype=np.float64).reshape(len(found), len(quantities)),
    )


def dies_of(study: Study, target: Target, numbers: range) -> Iterator[Die]:
    """The dies of some numbers, under the study's plan."""
    base = read_die(study.subject.silicon)
    plan = study.plan
    labels = () if plan.method == "random" else target.labels()
    drawn = sampling(plan, labels, numbers.start, numbers.stop)
    for number in numbers:
        yield replace(base, number=number, sampling=drawn)


def run_study(
    study: Study,
    folder: Path | None = None,
    *,
    submit: Submit,
    ahead: int = 1,
    resume: bool = False,
    stop: Callable[[Table], bool] | None = None,
    progress: Callable[[float], None] | None = None,
    command: Sequence[str] = (),
) -> Outcome:
    """Measure all samples of a study, or as many as `stop` asks for.

    Parameters
    ----------
    study
        What to measure.
    folder
        Where chunks, manifest and the final table go; nowhere unless given.
    submit, ahead
        How a chunk is handed out (see `on_threads`, `on_cluster`), and how many at once.
    resume
        Go on in a folder that has the study already; without it such a folder is refused.
    stop
        Asked after every chunk, in order, with its samples; True ends the study.
    progress
        Takes the share that is done.
    command
        Kept in the manifest.

    Raises
    ------
    ParameterError
        The folder has another study, or this one and `resume` is not given, or another process is at work
        in it.
    DataError
        A file cannot be written; what was finished is kept.
    """
    if not study.plan.count > 0:
        return Outcome(empty([q.name for q in open_target(study.subject).quantities]), 0, (), stopped=False)
    kept = nullcontext() if folder is None else open_folder(folder, study, resume=resume, command=command)
    tables: list[Table] = []
    read, redone, stopped = 0, [], False
    chunks = study.chunks()
    with kept as files, interrupts() as asked:
        with closing(_ordered(study, chunks, files, submit, ahead, asked)) as source:
            for dies, table, note in source:
                if note is None:
                    read += 1
                elif files is not None:
                    keep_chunk(files, dies, table)
                redone += [note] if note else []
                tables.append(table)
                if progress is not None:
                    progress(len(tables) / len(chunks))
                if stop is not None and stop(table):
                    stopped = len(tables) < len(chunks)
                    break
        whole = join(tables)
        if files is not None:
            keep_samples(files, whole)
    return Outcome(whole, read, tuple(redone), stopped)


def _ordered(
    study: Study,
    chunks: Sequence[range],
    files: StudyFiles | None,
    submit: Submit,
    ahead: int,
    asked: Event,
) -> Generator[tuple[range, Table, str | None], None, None]:
    """Chunks in order with a note: None if read, else why an old file was not taken, empty where none was."""
    waiting: deque[tuple[range, Table | Handed, str | None]] = deque()
    for dies in chunks:
        known, note = (None, "") if files is None else known_chunk(files, dies)
        waiting.append((dies, submit(study, dies) if known is None else known, note))
        if len(waiting) > ahead:
            yield _take(waiting.popleft(), asked)
    while waiting:
        yield _take(waiting.popleft(), asked)


def _take(entry: tuple[range, Table | Handed, str | None], asked: Event) -> tuple[range, Table, str | None]:
    """Wait for a chunk; raises `KeyboardInterrupt` soon after it was asked for."""
    dies, pending, note = entry
    if not isinstance(pending, Table):
        pending = join([outcome_of(piece, asked) for piece in pending])
    check(asked)
    return dies, pending, note


@contextmanager
def on_threads(workers: int | None = None) -> Iterator[tuple[Submit, int]]:
    """Hand chunks to threads of this process, all cores unless given; the solver lets them run at once."""
    threads = os.cpu_count() or 1 if workers is None else workers
    if not 1 <= threads <= MOST_WORKERS:
        raise ParameterError(f"--threads: {threads}, must be at least 1 and at most {MOST_WORKERS}")
    executor = ThreadPoolExecutor(threads)

    def submit(study: Study, dies: range) -> Handed:
        length = len(dies) if threads == 1 else -(-len(dies) // _PIECES)
        starts = range(0, len(dies), max(length, 1))
        return tuple(executor.submit(measure_dies, study, dies[k : k + length]) for k in starts)

    try:
        yield submit, AHEAD * threads
    finally:
        executor.shutdown(cancel_futures=True)
