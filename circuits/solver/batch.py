"""Batches over dies: a function of a circuit's machine, called once on every die, on several threads.

The testbench is lowered once, and a die changes only the coefficients of its transistors. The solver's
compiled loops run without Python's lock, so that threads share the cores. A sample depends on its die alone:
samples come in the order of the dies, and are the same for any number of workers. Where one fails, its sample
has the reason, and the others go on.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Generic, TypeVar

from circuits.errors import ParameterError
from circuits.lowering.kernel import Machine, on_die
from circuits.silicon.die import Die
from circuits.solver.operating_point import OperatingPoint, operating_point, solve_near

T = TypeVar("T")

_AHEAD = 4  # dies a worker that are handed out before they are asked for


@dataclass(frozen=True, slots=True)
class Sample(Generic[T]):
    """What a function returned on one die.

    Attributes
    ----------
    die : Die
        The die.
    value : object
        What was returned; None where the function failed.
    reason : str
        Why it failed; empty unless it did.
    """

    die: Die
    value: T | None
    reason: str = ""


def rest_near(machine: Machine, neighbour: OperatingPoint) -> OperatingPoint:
    """Rest state of a machine on one die, found from that on another: some ten times faster than without it.

    Where the state is lost on the way or is no longer stable, it is the one that is found without a start.
    """
    found = solve_near(machine, neighbour.voltage)
    return found if found is not None and found.stable else operating_point(machine)


def samples(
    function: Callable[[Machine], T], machine: Machine, dies: Iterable[Die], workers: int | None = None
) -> Iterator[Sample[T]]:
    """Samples in the order of `dies`, each as soon as it and those before it are there.

    function: called on several threads at once, each with a machine of its own. workers: number of threads,
    one for each core unless given. When the iterator is closed or interrupted, dies that were not begun are
    dropped.
    """
    count = os.cpu_count() or 1 if workers is None else workers
    if count < 1:
        raise ParameterError(f"workers: {count}, must be at least 1")
    return _samples(function, machine, dies, count)


def map_dies(
    function: Callable[[Machine], T],
    machine: Machine,
    dies: Iterable[Die],
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> list[Sample[T]]:
    """Call a function on many dies, and return all samples in the order of the dies.

    Parameters
    ----------
    function
        Called on several threads at once, each with a machine of its own.
    machine
        A lowered testbench; each die gets it as if it were lowered there.
    dies
        The dies.
    workers
        Number of threads; one for each core unless given.
    progress
        Called with the number of samples that are done.
    """
    done: list[Sample[T]] = []
    for sample in samples(function, machine, dies, workers):
        done.append(sample)
        if progress is not None:
            progress(len(done))
    return done


def _samples(
    function: Callable[[Machine], T], machine: Machine, dies: Iterable[Die], workers: int
) -> Iterator[Sample[T]]:
    executor = ThreadPoolExecutor(workers)
    waiting: deque[Future[Sample[T]]] = deque()
    try:
        for die in dies:
            waiting.append(executor.submit(_sample, function, machine, die))
            if len(waiting) >= _AHEAD * workers:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        executor.shutdown(cancel_futures=True)


def _sample(function: Callable[[Machine], T], machine: Machine, die: Die) -> Sample[T]:
    try:
        return Sample(die, function(on_die(machine, die)))
    except Exception as error:  # noqa: BLE001 - whatever a function raises on a die is that die's result
        return Sample(die, None, " ".join(str(error).split()) or type(error).__name__)
