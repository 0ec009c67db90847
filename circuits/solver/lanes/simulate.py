"""Transient runs of many machines of one structure, side by side in lanes.

`simulate_each(machines)` gives what `circuits.solver.transient.simulate` gives of each, in order. A machine
is a testbench on a die, at a temperature, with values of its parameters; machines go together where their
circuits have one structure (`circuits.solver.lanes.layout.structure_of`). Method and tolerances are the same,
so that answers differ by roundings, and by far less than the tolerance leaves (tested). What a lane gives of
a machine is the same to the bit, whatever other machines there are, in which order and on how many threads.

A run whose steps become too small in a lane is done again by itself, to give what it gives there. What a
graphics processor leaves, for want of room or of steps, goes into lanes on all cores. A circuit with a device
that has no form for lanes (an amplifier, a diode), or with sources of samples, is not for lanes (`fits`).
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from typing import TypeAlias, final

import numpy as np

from circuits.arrays import F64
from circuits.lowering.kernel import Machine
from circuits.solver.beginning import Beginning
from circuits.solver.lanes.layout import DONE, Found, jobs_of, moving_of, wiring
from circuits.solver.lanes.places import Place, Runs, runs_at
from circuits.solver.lanes.rest import beginnings
from circuits.solver.outcome import Outcome
from circuits.solver.swing import uncrossed
from circuits.solver.transient import DEFAULT_RTOL, MAX_STEPS, Result, Runner, Steps, simulate

_Begun: TypeAlias = tuple[Machine, Beginning]
TOGETHER = 512
"""Machines that are made ready at once for lanes, and the fewest for a graphics processor; ours."""
_MOST = 16384  # of them for a graphics processor
_LIKELY = 4096  # points of a run, by which their number is chosen there; ours
_HELD = 2 << 30  # bytes that their points may take; ours
_MOST_UNKNOWNS = 300  # beyond which what all lanes work with leaves the processor's caches; ours


def fits(machine: Machine) -> bool:
    """Whether runs of a machine can go in lanes: decided by its structure alone, whatever its die."""
    k = machine.kernel
    return (
        0 < k.unknowns <= _MOST_UNKNOWNS
        and k.amplifier_terminal.shape[1] == 0
        and k.diodes.saturation.size == 0
        and not any(machine.sampled)
        and math.isfinite(machine.testbench.stop)
    )


def simulate_each(
    machines: Iterable[Machine],
    *,
    rtol: float = DEFAULT_RTOL,
    record: tuple[str, ...] | None = None,
    place: Place = "cpu",
) -> Iterator[Result | Exception]:
    """What a run of each machine gives, in order: the result, or the error that it raises.

    Parameters
    ----------
    machines
        Lowered testbenches that are fit for lanes (`fits`), all of one structure.
    rtol
        Local error of a step, relative to the larger of |v| and 1 V.
    record
        Nodes to keep, by path; all unless given.
    place
        Where they run (`PLACES`). Without a graphics processor `gpu` raises ParameterError.
    """
    left = iter(machines)
    for first in left:
        nodes = len(first.names if record is None else record)
        many = min(_MOST, max(TOGETHER, _HELD // (8 * (1 + nodes) * _LIKELY)))
        group = [first, *islice(left, (many if place == "gpu" else TOGETHER) - 1)]
        yield from _Group(group, rtol, record, place).results()


def simulate_as_many(machine: Machine) -> Result:
    """What a run of a machine gives among many, to the bit: in lanes where it fits, else by itself.

    Raises whatever `simulate` does.
    """
    (found,) = simulate_each([machine]) if fits(machine) else (simulate(machine),)
    if isinstance(found, Exception):
        raise found
    return found


@final
class _Group:
    """Machines that run together."""

    def __init__(
        self, machines: Sequence[Machine], rtol: float, record: tuple[str, ...] | None, place: Place
    ) -> None:
        first, self._place, self._run = machines[0], place, runs_at(place)
        self._machines, self._rtol, self._record = machines, rtol, record
        self._nodes = first.names if record is None else record
        self._runner = Runner(first, self._nodes, rtol)
        self._kept = np.array([first.column_of(n) for n in self._nodes], dtype=np.int64)
        self._wiring = wiring(first, self._kept, self._runner.watched, moving_of(machines))

    def results(self) -> Iterator[Result | Exception]:
        """Results in the order of the machines."""
        begun = beginnings(self._machines, self._wiring, self._run)
        able = [(m, b) for m, b in zip(self._machines, begun, strict=True) if isinstance(b, Beginning)]
        runs = self._in_lanes(able) if self._place == "cpu" else iter(self._on_gpu(able))
        for each in begun:
            yield next(runs) if isinstance(each, Beginning) else each

    def _on_gpu(self, begun: Sequence[_Begun]) -> list[Result | Exception]:
        """Runs from where they begin; those that are not done there go into lanes, some on each core."""
        there = list(self._runs(begun, self._run))
        lost = [k for k, found in enumerate(there) if found is None]
        cores = os.cpu_count() or 1
        parts = [[begun[k] for k in lost[core::cores]] for core in range(cores)]
        found: list[Result | Exception | None] = list(there)
        with ThreadPoolExecutor(cores) as threads:
            for core, results in enumerate(threads.map(lambda part: list(self._in_lanes(part)), parts)):
                for k, result in zip(lost[core::cores], results, strict=True):
                    found[k] = result
        return [each for each in found if each is not None]

    def _in_lanes(self, begun: Sequence[_Begun]) -> Iterator[Result | Exception]:
        """Runs from where they begin; those that are not done in lanes are done by themselves."""
        for each, found in zip(begun, self._runs(begun, runs_at("cpu")), strict=True):
            yield self._alone(*each) if found is None else found

    def _runs(self, begun: Sequence[_Begun], run: Runs) -> Iterator[Result | None]:
        """Runs from where they begin, None for one that is not done there."""
        if not begun:
            return
        count = len(begun)
        jobs = jobs_of([m for m, _ in begun], [b.voltage for _, b in begun], self._rtol, MAX_STEPS)
        taken, next_one = _Taken(count), 0
        for found in run(self._wiring, jobs):
            taken.take(found)
            while next_one < count and found.state[next_one] >= DONE:
                parts = taken.of(next_one)
                if found.state[next_one] == DONE:
                    yield self._result(*begun[next_one], *parts, found, jobs.level[next_one, 0], next_one)
                else:
                    yield None
                next_one += 1
        yield from [None] * (count - next_one)

    def _result(
        self, machine: Machine, begun: Beginning, parts: Sequence[F64], spikes: Sequence[tuple[int, float]],
        found: Found, thresholds: F64, job: int,
    ) -> Result:  # fmt: skip
        size = 1 + sum(map(len, parts))
        time, voltage = np.zeros(size), np.empty((size, self._kept.size))
        voltage[0] = begun.voltage[self._kept]
        at = 1
        for part in parts:
            time[at : at + len(part)], voltage[at : at + len(part)] = part[:, 0], part[:, 1:]
            at += len(part)
        labels = self._runner.labels
        times = {name: np.sort([t for k, t in spikes if labels[k] == name]) for name in labels}
        return Result(
            machine, Outcome.DONE, time, voltage, self._nodes, times,
            Steps(*(int(c) for c in found.steps[job])), begun.point, begun.disturbance,
            uncrossed(labels, thresholds, found.extent[job]),
        )  # fmt: skip

    def _alone(self, machine: Machine, begun: Beginning) -> Result | Exception:
        try:
            return simulate(machine, rtol=self._rtol, record=self._record, point=begun.point)
        except Exception as error:  # noqa: BLE001 - whatever it raises is what its run gives
            return error


@final
class _Taken:
    """What runs have recorded so far, by job."""

    def __init__(self, count: int) -> None:
        self._points: list[list[F64]] = [[] for _ in range(count)]
        self._spikes: list[list[tuple[int, float]]] = [[] for _ in range(count)]

    def take(self, found: Found) -> None:
        """Take all that was written since the last time."""
        blocks, spikes = found.used.tolist()
        owners, filled = found.owner[:blocks].tolist(), found.filled[:blocks].tolist()
        for block, (owner, points) in enumerate(zip(owners, filled, strict=True)):
            self._points[owner].append(found.point[block, :points].copy())
        indices, times = found.spike_index[:spikes].tolist(), found.spike_time[:spikes].tolist()
        for job, *spike in zip(found.spike_job[:spikes].tolist(), indices, times, strict=True):
            self._spikes[job].append((spike[0], spike[1]))

    def of(self, job: int) -> tuple[list[F64], list[tuple[int, float]]]:
        """Points of a run that is over, and its spikes (position among the watched, s), which are let go."""
        found = self._points[job], self._spikes[job]
        self._points[job], self._spikes[job] = [], []
        return found
