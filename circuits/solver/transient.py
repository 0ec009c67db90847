"""Transient runs: simulate a testbench, or advance a machine step by step with new stimuli.

`advance(machine, state, until, inputs)` obeys the run contract: it returns at its first output event
with the state at that moment, and goes on from there with whatever the inputs are then.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.devices.source import Polyline, vertices
from circuits.errors import ParameterError, SolverError, unknown_name
from circuits.lowering.kernel import Machine, Sources, pack_sources, to_kernel
from circuits.lowering.supply import spike_levels
from circuits.silicon.silicon import Silicon
from circuits.solver import integrate as core
from circuits.solver.beginning import Beginning, Disturbance, Disturbed, beginning
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.outcome import Outcome
from circuits.solver.swing import Swing, uncrossed
from circuits.testbench import Testbench

# ours: 99 % of the rebound neuron's spikes on 2,600 dies are within 1 us of the converged ones, and the worst
# is 1.5 us off, at 2.1 times the CPU of 2e-5: there 7.5 and 12 us (benchmarks/spike_time_tolerance.py)
DEFAULT_RTOL = 5e-7
MAX_STEPS = 10_000_000
_CHUNK = 4096

_OUTCOMES = {
    core.DONE: Outcome.DONE,
    core.EVENT: Outcome.EVENT,
    core.STEP_TOO_SMALL: Outcome.STEP_TOO_SMALL,
    core.TOO_MANY_STEPS: Outcome.TOO_MANY_STEPS,
}


@dataclass(frozen=True, slots=True)
class State:
    """All that a run carries from one call to the next, as plain arrays, so that it can be pickled.

    Attributes
    ----------
    time : array
        The last three points, newest first, float64[3], s.
    voltage : array
        The voltage vector at these points, float64[3, columns], V.
    rate : array
        Its derivative at the last restart, float64[columns], V/s.
    step : array
        Length of the next step, float64[1], s; 0 asks for a restart.
    points : array
        Number of valid points since the last restart, int64[1].
    armed : array
        Whether each watched node is below the level at which it is looked for spikes again, bool[watched].
    counts : array
        Steps accepted, steps rejected and iterations so far, int64[3].
    lines : tuple of (array, array)
        Polyline of each source: times (s) and values (V or A), float64[T] each.
    """

    time: F64
    voltage: F64
    rate: F64
    step: F64
    points: I64
    armed: Bools
    counts: I64
    lines: tuple[Polyline, ...]

    @property
    def now(self) -> float:
        """The time that the run has reached, s."""
        return float(self.time[0])


class Steps(NamedTuple):
    """How many steps a run accepted and rejected, and how many iterations of Newton's method it took."""

    accepted: int
    rejected: int
    iterations: int


@dataclass(frozen=True, slots=True)
class Result:
    """Waveforms and spikes of a run; `result[path]` is the waveform of a node, float64[T], V.

    Attributes
    ----------
    machine, outcome : Machine, Outcome
        The testbench on its silicon, and how the run ended.
    time : array
        Times of the points, float64[T], s.
    voltage : array
        Voltages of the recorded nodes, float64[T, nodes], V.
    nodes : tuple of str
        Paths of the nodes, in the order of `voltage`.
    spikes : mapping of str to array
        Times at which each watched port rose through its threshold, float64[n], s.
    steps : Steps
        How many steps the solver made.
    operating_point : OperatingPoint
        The rest state that the run began from.
    disturbance : Disturbance or None
        What took the run away from a rest state that is not stable, if anything did.
    uncrossed : mapping of str to Swing
        Watched nodes that swing without crossing their threshold, so that they have no spikes.
    """

    machine: Machine
    outcome: Outcome
    time: F64
    voltage: F64 = field(repr=False)
    nodes: tuple[str, ...] = field(repr=False)
    spikes: Mapping[str, F64]
    steps: Steps
    operating_point: OperatingPoint
    disturbance: Disturbance | None = None
    uncrossed: Mapping[str, Swing] = field(default_factory=dict)

    def __getitem__(self, node: str) -> F64:
        """Waveform of a node, float64[T], V."""
        try:
            return np.asarray(self.voltage[:, self.nodes.index(node)])
        except ValueError:
            raise unknown_name("node", node, self.nodes) from None


@dataclass(frozen=True, slots=True)
class Segment:
    """What one call of `advance` returned: points after the start, and spikes (port, s) in order of time.

    extent: float64[2, watched], V, the lowest and highest voltages of the watched nodes, start included.
    """

    time: F64
    voltage: F64
    spikes: tuple[tuple[str, float], ...]
    outcome: Outcome
    extent: F64


class Runner:
    """A machine with its working memory, which one thread advances step by step; its states are values.

    Spikes are rises of the testbench's watched ports through `thresholds`: half of their circuit's supply, or
    what the port states.

    Parameters
    ----------
    machine
        A lowered testbench (`to_kernel`).
    record
        Nodes, by path, whose voltages are kept at every accepted point.
    rtol
        Local error of a step, relative to the larger of |v| and 1 V.

    Raises
    ------
    ParameterError
        `rtol` is not within 1e-9 to 1e-2.
    """

    def __init__(self, machine: Machine, record: tuple[str, ...] = (), rtol: float = DEFAULT_RTOL) -> None:
        """Allocate scratch for `machine`; raises `ParameterError` unless 1e-9 <= rtol <= 1e-2."""
        if not 1e-9 <= rtol <= 1e-2:
            raise ParameterError(f"rtol: {rtol:g}, must be within 1e-9 to 1e-2; {DEFAULT_RTOL:g} is usual")
        self.machine, self.record, self.rtol = machine, record, rtol
        self.watch_names = machine.testbench.watch
        watched = [n for w in self.watch_names for n in machine.flat.watched_nodes(w)]
        self.labels = [machine.names[n] for n in watched]
        self.watched = machine.column[watched].astype(np.int64)
        self._levels = spike_levels(machine)
        self._recorded = len(record)
        columns = np.array([machine.column_of(n) for n in record], dtype=np.int64)
        self._packed = (machine.polylines, machine.sources())
        self._scratch = core.new_scratch(machine.kernel, self._packed[1])
        self._recorder = core.new_recorder(
            np.concatenate([columns, self.watched]), self.watched, self._levels, _CHUNK,
            2 * max(_CHUNK, self.watched.size),
        )  # fmt: skip

    @property
    def thresholds(self) -> F64:
        """The voltage that a spike rises through at each watched node, float64[watched], V."""
        return np.asarray(self._levels[0].copy())

    def begin(self, point: OperatingPoint, time: float = 0.0) -> State:
        """State at `time` s from the rest state `point`, as the testbench says that its runs begin.

        Warns (`Disturbed`) where a state that is not stable is left.
        """
        begun = beginning(self.machine, point=point, time=time)
        if begun.disturbance is not None:
            warnings.warn(f"{self.machine.testbench.title}: {begun.disturbance}", Disturbed, stacklevel=2)
        return self.enter(begun, time)

    def enter(self, start: Beginning, time: float = 0.0) -> State:
        """The state at `time` (s) of a run that begins as `start` says."""
        v = start.voltage
        armed = v[self.watched] < self._levels[0]
        return State(
            np.full(3, time), np.stack([v, v, v]), np.zeros(v.size), np.zeros(1), np.ones(1, dtype=np.int64),
            armed, np.zeros(3, dtype=np.int64), self.machine.polylines,
        )  # fmt: skip

    def advance(
        self,
        state: State,
        until: float,
        inputs: Mapping[str, Polyline] | None = None,
        *,
        stop_at_event: bool = True,
        max_steps: int = MAX_STEPS,
    ) -> tuple[State, Segment]:
        """Advance to a time, or to the first event.

        Parameters
        ----------
        state
            Where the run stands.
        until
            Time to advance to, s.
        inputs
            New polylines (time s, value V or A, float64[T] each) by source name, in force from now on. They
            go on from the source's present value: a jump restarts the solver and passes no charge through
            capacitances.
        stop_at_event
            Whether the first spike of a watched port ends the call.
        max_steps
            Number of steps of this call at most, rejected ones included.

        Raises
        ------
        ParameterError
            `until` is no time, or comes before the state's time.
        SolverError
            The solver gives up; the text names the time and the remedy.
        """
        title = self.machine.testbench.title
        if math.isnan(until):
            raise ParameterError(f"{title}: until {until:g} s, must be a time")
        lines = self._with_inputs(state, inputs)
        before = int(state.counts[0] + state.counts[1])
        sources = self._pack(lines)
        history = core.History(
            state.time.copy(), state.voltage.copy(), state.rate.copy(), state.step.copy(),
            state.points.copy(), state.armed.copy(), state.counts.copy(),
        )  # fmt: skip
        scratch = self._scratch._replace(cursor=sources.start[:-1].copy())
        r, kept = self._recorder, self._recorded
        times, volts, spikes = [], [], []
        seen = state.voltage[0][self.watched]
        extent = np.array([seen, seen])
        code = core.BUFFER_FULL
        while code == core.BUFFER_FULL:
            r.filled[:] = 0
            left = max_steps - (int(history.counts[0] + history.counts[1]) - before)
            goal = core.Goal(float(until), float(self.rtol), left, bool(stop_at_event))
            code = core.integrate(self.machine.kernel, sources, history, goal, r, scratch)
            times.append(r.time[: r.filled[0]].copy())
            volts.append(r.voltage[: r.filled[0], :kept].copy())
            core.widen(r, kept, extent)
            found = range(int(r.filled[1]))
            spikes += [(self.labels[r.spike_index[p]], float(r.spike_time[p])) for p in found]
        outcome = _OUTCOMES[code]
        if outcome in (Outcome.STEP_TOO_SMALL, Outcome.TOO_MANY_STEPS):
            name = outcome.name.lower().replace("_", " ")
            raise SolverError(f"{title}: {name} at {history.time[0]:.9g} s; {outcome.value}")
        ordered = tuple(sorted(spikes, key=lambda s: (s[1], s[0])))
        return State(*history, lines), Segment(
            np.concatenate(times), np.concatenate(volts), ordered, outcome, extent
        )

    def _pack(self, lines: tuple[Polyline, ...]) -> Sources:
        """Sources in the solver's form, packed anew only when the polylines are others than the last."""
        if lines is not self._packed[0]:
            self._packed = (lines, pack_sources(lines, self.machine.sampled))
        return self._packed[1]

    def _with_inputs(self, state: State, inputs: Mapping[str, Polyline] | None) -> tuple[Polyline, ...]:
        if not inputs:
            return state.lines
        lines = list(state.lines)
        for name, line in inputs.items():
            if name not in self.machine.source_names:
                raise unknown_name("source", name, self.machine.source_names)
            lines[self.machine.source_names.index(name)] = vertices(name, *line)
        return tuple(lines)


def simulate(
    target: Testbench | Machine,
    silicon: Silicon | None = None,
    *,
    rtol: float = DEFAULT_RTOL,
    start: Mapping[str, float] | None = None,
    record: tuple[str, ...] | None = None,
    point: OperatingPoint | None = None,
    at_rest: bool = False,
) -> Result:
    """Run a testbench, from where it says that its runs begin, to its stop time.

    Parameters
    ----------
    target
        The testbench, or one that is lowered already.
    silicon
        Process, temperature and die: the nominal process at 27 degC unless given; of no effect on a lowered
        testbench.
    rtol
        Local error of a step, relative to the larger of |v| and 1 V.
    start
        A guess at the rest state, V by node path.
    record
        Nodes to keep, by path; all unless given.
    point
        The rest state to begin in; solved for unless given.
    at_rest
        Whether to stay in a rest state that is not stable, whatever the testbench says.

    Raises
    ------
    SolverError
        The solver gives up.
    ParameterError
        The testbench has no end, or a value breaks its rule.
    """
    machine = target if isinstance(target, Machine) else to_kernel(target, silicon)
    if at_rest:
        machine = replace(machine, testbench=replace(machine.testbench, begin="at_rest"))
    begun = beginning(machine, start=start, point=point)
    nodes = machine.names if record is None else record
    runner = Runner(machine, nodes, rtol)
    state = runner.enter(begun)
    first = state.voltage[0][[machine.column_of(n) for n in nodes]]
    state, segment = runner.advance(state, machine.testbench.stop, stop_at_event=False)
    spikes = {n: np.array([t for name, t in segment.spikes if name == n]) for n in runner.labels}
    return Result(
        machine, segment.outcome, np.concatenate([[0.0], segment.time]),
        np.vstack([first, segment.voltage]), nodes, spikes, Steps(*(int(c) for c in state.counts)),
        begun.point, begun.disturbance, uncrossed(runner.labels, runner.thresholds, segment.extent),
    )  # fmt: skip
