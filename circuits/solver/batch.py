"""Batches over dies: a function of a circuit's machine, called once on every die, on several threads.

The testbench is lowered once, and a die changes only the coefficients of its transistors. The solver's
compiled loops run without Python's lock, so that threads share the cores. A sample depends on its die alone:
samples come in the order of the dies, and are the same for any number of workers. Where one fails, its sample
has the reason, and the others go on.

Where the function is `simulate`, or a `partial` of it with other tolerances or nodes to record, the dies of a
worker run together in lanes (`circuits.solver.lanes`), which takes a fraction of the time.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sized
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import Any, Generic, TypeVar

from circuits.errors import ParameterError
from circuits.lowering.kernel import Machine, on_die
from circuits.lowering.on_dies import on_dies
from circuits.silicon.die import Die
from circuits.solver.lanes.simulate import fits, simulate_each
from circuits.solver.operating_point import OperatingPoint, operating_point, solve_near
from circuits.solver.transient import simulate

T = TypeVar("T")

_AHEAD = 4  # dies a worker that are handed out before they are asked for
_TOGETHER = (64, 512)  # least and most dies that a worker takes into lanes at once; ours
_KEPT = 8192  # nodes of all of them that are recorded, so that their waveforms fit into memory; ours


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
    """Rest state where a run begins on one die, from that on another: some ten times faster than without it.

    Where the state is lost on the way or is no longer stable, it is the one that is found without a start.
    """
    found = solve_near(machine, neighbour.voltage, 0.0)
    return found if found is not None and found.stable else operating_point(machine, time=0.0)


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
    options = _lane_options(function)
    if options is None or not fits(machine):
        return _in_order((partial(_one, function, machine, die) for die in dies), count, _AHEAD * count)
    each, size = partial(_together, options, machine), _group_size(options, machine, dies, count)
    return _in_order((partial(each, group) for group in _groups(dies, size)), count, count)


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


def _in_order(
    works: Iterable[Callable[[], list[Sample[T]]]], workers: int, ahead: int
) -> Iterator[Sample[T]]:
    """Samples of works that threads do, in the order of the works; ahead: how many are handed out before."""
    executor = ThreadPoolExecutor(workers)
    waiting: deque[Future[list[Sample[T]]]] = deque()
    try:
        for work in works:
            waiting.append(executor.submit(work))
            if len(waiting) >= ahead:
                yield from waiting.popleft().result()
        while waiting:
            yield from waiting.popleft().result()
    finally:
        executor.shutdown(cancel_futures=True)


def _one(function: Callable[[Machine], T], machine: Machine, die: Die) -> list[Sample[T]]:
    try:
        return [Sample(die, function(on_die(machine, die)))]
    except Exception as error:  # noqa: BLE001 - whatever a function raises on a die is that die's result
        return [_failed(die, error)]


def _failed(die: Die, error: Exception) -> Sample[Any]:
    return Sample(die, None, " ".join(str(error).split()) or type(error).__name__)


def _lane_options(function: Callable[..., Any]) -> dict[str, Any] | None:
    """What `simulate` is asked beside the machine, None where lanes cannot do what the function does."""
    if function is simulate:
        return {}
    if not (isinstance(function, partial) and function.func is simulate) or function.args:
        return None
    options = dict(function.keywords)
    return options if options.keys() <= {"rtol", "record"} else None


def _group_size(options: dict[str, Any], machine: Machine, dies: Iterable[Die], workers: int) -> int:
    """How many dies a worker takes at once: many, so that few lanes are idle while the last ones end."""
    nodes = machine.names if options.get("record") is None else options["record"]
    least, most = _TOGETHER
    size = min(most, max(least, _KEPT // (1 + len(nodes))))
    return min(size, -(-len(dies) // workers) or 1) if isinstance(dies, Sized) else size


def _groups(dies: Iterable[Die], size: int) -> Iterator[list[Die]]:
    left = iter(dies)
    while group := list(islice(left, size)):
        yield group


def _together(options: dict[str, Any], machine: Machine, dies: list[Die]) -> list[Sample[Any]]:
    """Runs of dies in lanes."""
    try:
        found = zip(dies, simulate_each(on_dies(machine, dies), **options), strict=True)
        return [_failed(d, x) if isinstance(x, Exception) else Sample(d, x) for d, x in found]
    except Exception:  # noqa: BLE001 - of one of them, which is told of each by itself
        return [sample for die in dies for sample in _one(partial(simulate, **options), machine, die)]
