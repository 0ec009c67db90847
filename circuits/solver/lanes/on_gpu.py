"""Runs of one circuit on a graphics processor, a run a thread, as `circuits.solver.lanes.run` does in lanes.

The kernel is the same, worked out for the circuit (`circuits.programs.specialised`): method, steps and
tolerances are those of the lanes, and answers differ by roundings.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, cast, final

import numpy as np

from circuits.arrays import F64, I64
from circuits.devices.channel_lanes import bent, channel_affected, channel_plain
from circuits.programs import gpu
from circuits.programs.ordered import ordered
from circuits.programs.program import Argument, Memory, Program, Shared
from circuits.programs.specialised import specialise
from circuits.solver.lanes.law import flow
from circuits.solver.lanes.layout import DONE, FAILED, Found, Jobs, Team, Wiring, new_team
from circuits.solver.lanes.run import run, take

_MOST_STEPS = 16384
"""Steps of a run beyond which it is left to the processor, where one takes a thirtieth of the time; ours."""
_MEMORY = 4 << 30  # bytes of all points; ours
_BLOCKS, _POINTS, _SPIKES = 32, 256, 256  # that a thread has room for, the spikes of each watched node; ours
_PROGRAMS: dict[bytes, gpu.GpuProgram] = {}
_FUNCTIONS = (channel_plain, channel_affected, bent, flow)
"""Kernels of which a program has one: written out for each device they would not fit where code is kept."""
_KEPT = 64  # programs
_OF_JOBS = ("coefficient", "charge", "conductance", "level")
_VOLTAGES = ("v", "v0", "v1", "v2", "guess")
_RATES = ("rate", "slope", "extra")


@dataclass(frozen=True, slots=True)
class Room:
    """What a thread has to write into: blocks of points, points a block, spikes."""

    blocks: int
    points: int
    spikes: int

    @classmethod
    def of(cls, w: Wiring, jobs: Jobs) -> Room:
        """The room of jobs."""
        spikes = 1 if jobs.resting else _SPIKES * max(1, w.watch.size)
        return cls(_BLOCKS, _POINTS, spikes) if jobs.recording else cls(0, 0, spikes)

    def threads(self, w: Wiring) -> int:
        """For how many threads there is memory."""
        return max(32, _MEMORY // (8 * max(1, self.private(w)["point"])))

    def private(self, w: Wiring) -> dict[str, int]:
        """Sizes of what each thread has for itself, by name."""
        blocks = dict.fromkeys(("filled", "owner"), self.blocks)
        spikes = dict.fromkeys(("spike_time", "spike_index", "spike_job"), self.spikes)
        return {**blocks, **spikes, "used": 2, "point": self.blocks * self.points * (1 + w.recorded.size)}


class Worked(NamedTuple):
    """A program, the numbers that all runs share, and which elements of each array of `Jobs` do not.

    own: places in the flat array of a run.
    """

    program: gpu.GpuProgram
    constants: F64
    own: Mapping[str, I64]


def worked_out(w: Wiring, jobs: Jobs, room: Room) -> Worked:
    """The program of runs of a circuit, with room for what they record where `jobs.recording` says so."""
    layout = _Layout(w, jobs, room)
    key = layout.key()
    if key not in _PROGRAMS:
        _PROGRAMS[key] = gpu.compiled_program(layout.program(), room.private(w), len(layout.same))
        while len(_PROGRAMS) > _KEPT:
            del _PROGRAMS[next(iter(_PROGRAMS))]
    return Worked(_PROGRAMS[key], np.array(layout.same), layout.own)


def run_on_gpu(w: Wiring, jobs: Jobs) -> Iterator[Found]:
    """Do jobs on a graphics processor; gives what they have left each time that threads have no more room.

    A run for which a thread has not room enough stays waiting. Raises ParameterError where there is no
    graphics processor.
    """
    yield from Batch(w, jobs, len(jobs.start)).all_found()


@final
class Batch:
    """Runs of one circuit on the device.

    jobs: what the runs have in common, and which numbers differ among them. count: how many there are. given:
    arrays of all runs, on the device or not, by the name of the field of `Jobs`; of those of `Worked.own` as
    their own elements, [count, own]. The rest is that of `jobs`. most: steps at which a run fails, where
    jobs do not say fewer.
    """

    def __init__(
        self, w: Wiring, jobs: Jobs, count: int, given: Mapping[str, Any] | None = None, *,
        most: int = _MOST_STEPS,
    ) -> None:  # fmt: skip
        self._cp, self._w, self._jobs, self._count = gpu.cupy(), w, jobs, count
        self.most = min(jobs.most, float(most))
        room = Room.of(w, jobs)
        self.threads = min(gpu.threads(count), room.threads(w))
        self.worked = worked_out(w, jobs, room)
        self.arrays = self._inputs(given or {}) | self._outputs(room)

    def all_found(self, meanwhile: Callable[[], object] = tuple) -> Iterator[Found]:
        """Do all runs; what they have left each time that threads have no more room.

        meanwhile: is called once while the device has the first of them.
        """
        left, before = np.arange(self._count), self._count + 1
        while (
            0 < left.size < before
        ):  # not fewer: each of these leaves a thread no room, even where it is alone
            self.launch(left)
            if before > self._count:
                meanwhile()
            found = self.found()
            yield found
            before, left = left.size, np.flatnonzero((found.state != DONE) & (found.state != FAILED))

    def launch(self, order: I64) -> None:
        """Have threads do the runs of `order`, until these are over or there is no more room."""
        jobs = self._jobs
        self.arrays["used"][:] = 0
        numbers = {"stop": jobs.stop, "rtol": jobs.rtol, "most": self.most}
        self.worked.program.launch(
            self.arrays, numbers, self.worked.constants, order, self._count, self.threads
        )

    def _inputs(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """What programs read, on the device."""
        jobs, found = self._jobs, {}
        for name, places in self.worked.own.items():
            own = given.get(name)
            flat = getattr(jobs, name).reshape(len(jobs.start), -1)[:, places] if own is None else own
            found[f"jobs_{name}"] = self._each(flat)
        for name in ("curvature", "start", "line"):
            found[name] = self._each(given.get(name, getattr(jobs, name)))
        shared = ("line_start", "line_time", "line_value")
        return found | {name: gpu.on_device(getattr(jobs, name)) for name in shared}

    def _each(self, array: Any) -> Any:
        """An array of all runs, on the device, run after run; of fewer each has the first one's."""
        on_device = gpu.on_device(array)
        if len(on_device) == self._count:
            return on_device
        return self._cp.zeros((self._count, *on_device.shape[1:]), on_device.dtype) + on_device[:1]

    def _outputs(self, room: Room) -> dict[str, Any]:
        """Where programs write, on the device."""
        w, count, threads = self._w, self._count, self.threads
        whole = {
            "state": (count,), "filled": (threads, room.blocks), "owner": (threads, room.blocks),
            "spike_index": (threads, room.spikes), "spike_job": (threads, room.spikes), "used": (threads, 2),
        }  # fmt: skip
        real = {
            "rest": (count, w.columns), "jacobian_at_rest": (count, w.factor.entries), "steps": (count, 3),
            "lowest_highest": (count, 2, w.watch.size), "spike_time": (threads, room.spikes),
            "point": (threads, room.blocks, room.points, 1 + w.recorded.size),
        }  # fmt: skip
        found = {name: self._cp.zeros(shape, self._cp.int64) for name, shape in whole.items()}
        return found | {name: self._cp.zeros(shape, self._cp.float64) for name, shape in real.items()}

    def found(self) -> Found:
        """What runs have left, with points and spikes of those that are over, thread after thread."""
        state = self.arrays["state"].get()
        over = gpu.on_device((state == DONE) | (state == FAILED))
        blocks, spikes = (self._of(over, name, k) for k, name in enumerate(("owner", "spike_job")))
        of_run = (self.arrays[k].get() for k in ("rest", "jacobian_at_rest", "steps", "lowest_highest"))
        of_block = (self.arrays[k][blocks].get() for k in ("point", "filled", "owner"))
        of_spike = (self.arrays[k][spikes].get() for k in ("spike_time", "spike_index", "spike_job"))
        used = np.array([blocks[0].size, spikes[0].size])
        return Found._make((state, *of_run, *of_block, *of_spike, used))

    def _of(self, over: Any, owner: str, column: int) -> Any:
        """Which blocks, or spikes, of all threads are of runs that are over."""
        cp, owners = self._cp, self.arrays[owner]
        there = cp.arange(owners.shape[1])[None, :] < self.arrays["used"][:, column, None]
        return cp.nonzero(there & over[cp.where(there, owners, 0)])


@final
class _Layout:
    """Where a thread has what."""

    def __init__(self, w: Wiring, jobs: Jobs, room: Room) -> None:
        self._w, self._jobs, self._room = w, jobs, room
        self.same: list[float] = []
        self.own: dict[str, I64] = {}
        self._team, self._of_jobs = self._places()

    def key(self) -> bytes:
        """What tells programs apart: structure, room, and which numbers are whose."""
        held = [(m.name, m.shape, sorted(m.held)) for m in self._team if isinstance(m, Memory)]
        text = repr((self._jobs.resting, self._jobs.recording, self._room, held)).encode()
        return hashlib.sha256(text + _bytes_of(self._w)).digest()

    def program(self) -> Program:
        """The program."""
        w, jobs, room = self._w, self._jobs, self._room
        shared = {name: Shared(name, (-1,)) for name in ("curvature", "line_time", "line_value")}
        shared |= {
            "start": Shared("start", (-1, w.columns)), "line": Shared("line", (-1,), whole=True),
            "line_start": Shared("line_start", (-1, jobs.line_start.shape[1]), whole=True), **self._of_jobs,
        }  # fmt: skip
        numbers = {name: Argument(name) for name in ("stop", "rtol", "most")}
        jobs_of, found_of = cast("Any", Jobs), cast("Any", Found)  # of what stands for arrays here
        known = jobs_of(**shared, **numbers, resting=jobs.resting, recording=jobs.recording)
        found = found_of(
            Shared("state", (-1,), whole=True), Shared("rest", (-1, w.columns)),
            Shared("jacobian_at_rest", (-1, w.factor.entries)), Shared("steps", (-1, 3)),
            Shared("lowest_highest", (-1, 2, w.watch.size)),
            Shared("point", (room.blocks, room.points, 1 + w.recorded.size)),
            Shared("filled", (room.blocks,), whole=True), Shared("owner", (room.blocks,), whole=True),
            Shared("spike_time", (room.spikes,)), Shared("spike_index", (room.spikes,), whole=True),
            Shared("spike_job", (room.spikes,), whole=True), Shared("used", (2,), whole=True),
        )  # fmt: skip
        kernel, called, kept = cast("Any", run), cast("Any", {take: "take"}), cast("Any", _FUNCTIONS)
        return ordered(specialise(kernel, w, known, self._team, found, calls=called, functions=kept))

    def _places(self) -> tuple[Team, dict[str, Shared]]:
        """Working memory of a thread, and the arrays of jobs that it is filled from."""
        jobs, team = self._jobs, new_team(self._w, 1)
        fields: dict[str, Any] = {
            name: Memory(name, (array.shape[0], 1), whole=array.dtype.kind == "i")
            for name, array in team._asdict().items()
            if array.ndim == 2
        }
        fields |= {name: Memory(name, (1,), whole=True) for name in ("doing", "job", "block")}
        queue: dict[int, ast.expr] = {0: ast.Constant(0), 1: ast.Name("runs", ast.Load())}
        fields["queue"] = Memory("queue", (2,), whole=True, held=queue)
        of_jobs: dict[str, Shared] = {}
        for name in _OF_JOBS:
            array = getattr(jobs, name)
            held, own = self._held(array)
            fields[name] = Memory(name, (held.size + own.size, 1), held=self._numbers(array[0].ravel(), held))
            place: dict[int, Any] = {**fields[name].held, **{int(k): i for i, k in enumerate(own)}}
            of_jobs[name], self.own[name] = Shared(f"jobs_{name}", (-1, *array.shape[1:]), place=place), own
        fields |= self._sources()
        return Team(**fields), of_jobs

    def _sources(self) -> dict[str, Memory]:
        """Voltages of sources that do not move: numbers where all runs have the same, and at rest."""
        w, jobs = self._w, self._jobs
        still = np.setdiff1d(np.arange(w.unknowns, w.columns), w.unknowns + w.moving)
        alike = still[(jobs.start[:, still] == jobs.start[:1, still]).all(axis=0)]
        numbers = self._numbers(jobs.start[0], alike)
        found = {name: Memory(name, (w.columns, 1), held=numbers) for name in _VOLTAGES}
        rest = {int(k): ast.Constant(0.0) for k in still}
        return found | {name: Memory(name, (w.columns, 1), held=rest) for name in _RATES}

    def _held(self, array: F64) -> tuple[I64, I64]:
        """Elements that all jobs share, and those that they have for themselves."""
        flat = array.reshape(len(array), -1)
        alike = (flat == flat[:1]).all(axis=0)
        return np.flatnonzero(alike), np.flatnonzero(~alike)

    def _numbers(self, values: F64, places: I64) -> dict[int, ast.expr]:
        found: dict[int, ast.expr] = {}
        for k in places.tolist():
            found[k] = ast.Subscript(ast.Name("same", ast.Load()), ast.Constant(len(self.same)), ast.Load())
            self.same.append(float(values[k]))
        return found


def _bytes_of(tree: Any) -> bytes:
    """The contents of named tuples of arrays and numbers."""
    if isinstance(tree, tuple):
        return b"".join(map(_bytes_of, tree))
    return tree.tobytes() + repr(tree.shape).encode() if isinstance(tree, np.ndarray) else repr(tree).encode()
