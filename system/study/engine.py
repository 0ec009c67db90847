"""The engine of studies measures many dies, in chunks, and keeps each chunk in the study's folder.

A study is a campaign (`system.study.campaign`) whose keys are chunks of dies. The number of workers, the
order in which chunks end, interruptions and resumes therefore change no sample, and a rule that ends the
study early sees the chunks in order. A chunk's file is written whole or not at all. A file that cannot be
read is measured again, and the outcome says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from circuits.lowering.bias_moves import behind_bias
from circuits.silicon.die import Die
from system.options.block import read_die
from system.study.campaign import AHEAD, Workers, in_order, thread_count
from system.study.folder import keep_samples, open_folder
from system.study.manifest import Study
from system.study.plan import sampling
from system.study.table import Table, empty, join
from system.study.target import open_target
from system.study.waiting import Work, interrupts

_PIECES = 8  # of a chunk, shared by the threads, so that none waits long for the last one


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a study came to.

    Attributes
    ----------
    table : all samples, in the order of their dies and conditions.
    chunks_read : how many chunks were taken from the folder and not measured.
    chunks_redone : a line for each chunk that was measured again, since its file was broken.
    stopped : whether a rule ended the study before its last die.
    """

    table: Table
    chunks_read: int = 0
    chunks_redone: tuple[str, ...] = ()
    stopped: bool = False


@dataclass(frozen=True, slots=True)
class _Measure:
    """Measures chunks of a study, the samples of each in order."""

    study: Study

    @property
    def together(self) -> int:
        """How many dies it is best to measure at once."""
        return open_target(self.study.subject).together

    def __call__(self, dies: range) -> Table:
        return _measure_dies(self.study, dies)


def _measure_dies(study: Study, dies: range) -> Table:
    """Measure one chunk, its samples in order."""
    target = open_target(study.subject)
    quantities = tuple(q.name for q in target.quantities)
    drawn = list(dies_of(study, dies))
    where = [(die.number or 0, condition) for die in drawn for condition in study.conditions]
    if not where:
        return empty(quantities)
    found = target.measure_each(drawn, study.conditions)
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


def dies_of(study: Study, numbers: range) -> Iterator[Die]:
    """Give the dies with the given numbers; their deviations are drawn by the study's sampling plan.

    What is measured is opened only where the plan asks for the labels of its draws.
    """
    base = read_die(study.subject.silicon)
    plan = study.plan
    every = () if plan.method == "random" else open_target(study.subject).labels()
    labels = tuple(label for label in every if not behind_bias(label))  # which stay each die's own
    drawn = sampling(plan, labels, numbers.start, numbers.stop)
    for number in numbers:
        yield replace(base, number=number, sampling=drawn)


def run_study(
    study: Study,
    folder: Path | None = None,
    *,
    workers: Workers,
    resume: bool = False,
    stop: Callable[[Table], bool] | None = None,
    progress: Callable[[float], None] | None = None,
    command: Sequence[str] = (),
    part: Sequence[int] | None = None,
) -> Outcome:
    """Measure all samples of a study, or as many as `stop` asks for.

    Parameters
    ----------
    study
        What is measured, on which dies, under which conditions.
    folder
        Folder for the manifest, the chunks and the final table; nothing is kept where it is None.
    workers
        What measures the chunks: `on_threads`, or `system.study.cluster.on_cluster`.
    resume
        Whether to go on in a folder that has the study already; without it such a folder is refused.
    stop
        Function that is called after each chunk, in order, with the chunk's samples; True ends the study.
    progress
        Function that is told the share of the study that is done, 0 to 1.
    command
        Words of the command that asked for the study; the manifest keeps them.
    part
        Numbers of the chunks that are measured, in that order; all of them, from the first die on, unless
        given. Where some are missing no final table is written.

    Raises
    ------
    ParameterError
        The folder has another study, or this one and `resume` is not given, or another process is at work
        in it.
    DataError
        A file cannot be written; what was finished is kept.
    """
    if not study.plan.count > 0:
        return Outcome(empty([q.name for q in open_target(study.subject).quantities]))
    kept = nullcontext() if folder is None else open_folder(folder, study, resume=resume, command=command)
    tables: list[Table] = []
    every = study.chunks()
    stopped, chunks = False, every if part is None else [every[k] for k in part]
    with kept as files:
        with closing(in_order(_Measure(study), chunks, files, workers)) as measured:
            for _, table in measured:
                tables.append(table)
                if progress is not None:
                    progress(len(tables) / len(chunks))
                if stop is not None and stop(table):
                    stopped = len(tables) < len(chunks)
                    break
        whole = in_dies(tables)
        if files is None:
            return Outcome(whole, stopped=stopped)
        if len(chunks) == len(every):
            keep_samples(files, whole)
        return Outcome(whole, files.read, tuple(files.redone), stopped)


def in_dies(chunks: Sequence[Table]) -> Table:
    """Join the samples of chunks in the order of their dies."""
    return join(sorted(chunks, key=lambda table: int(table.die[0])))


@dataclass(frozen=True, slots=True)
class _Joined:
    """Pieces of a chunk, in order, as one work."""

    pieces: tuple[Work[Table], ...]

    def add_done_callback(self, fn: Callable[[Any], object], /) -> None:
        self._after(0, fn)

    def _after(self, k: int, fn: Callable[[Any], object]) -> None:
        """Tell of piece k, and then of those after it."""
        if k == len(self.pieces):
            fn(self)
        else:
            self.pieces[k].add_done_callback(lambda _: self._after(k + 1, fn))

    def result(self) -> Table:
        return join([piece.result() for piece in self.pieces])


@contextmanager
def on_threads(workers: int | None = None) -> Iterator[Workers]:
    """Give workers that measure chunks on threads of this process: `workers` of them, else one a core.

    The solver's kernels release Python's lock, so that threads measure at the same time. Raises
    `ParameterError` for a number of threads below 1 or above `MOST_WORKERS`.
    """
    threads = thread_count(workers)
    executor = ThreadPoolExecutor(threads)

    def submit(one: Callable[[range], Table], dies: range) -> Work[Table]:
        least = one.together if isinstance(one, _Measure) else 1
        length = len(dies) if threads == 1 else max(-(-len(dies) // _PIECES), least)
        starts = range(0, len(dies), max(length, 1))
        return _Joined(tuple(executor.submit(one, dies[k : k + length]) for k in starts))

    try:
        with interrupts() as asked:
            yield Workers(submit, AHEAD * threads, asked)
    finally:
        executor.shutdown(cancel_futures=True)
