"""Best delay and outcome class of a rebound neuron, measured by the solver.

An echo `d` after the call facilitates when the neuron fires. The best delay is the midpoint of the
facilitating interval, its edges bisected to 10 us. A neuron has a best delay only when it works: when it is
silent at rest, after a call without an echo and after an echo without a call. Anything else is a class of its
own and a result, never dropped.

The call is run once; every echo resumes from a state kept shortly before it.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from circuits.bias import saturation_current
from circuits.blocks.rebound_neuron import NOMINAL_RELEASE
from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, Driven, Polyline
from circuits.errors import SolverError
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon import Silicon
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.transient import Runner, State
from circuits.testbench import Testbench

RESOLUTION = 10e-6  # s, of the edges
TUNING_RTOL = 1e-5  # ours: at 1e-4 edges of nearly grazing neurons move by 50 us, and some change their class
LONGEST_INHIBITION = 2.0  # s; a neuron still inhibited then counts as never
_REST = 20e-3  # s, watched for spikes without any stimulus
_SCAN = 24  # delays tried before the edges are bisected
_KEPT = 64  # states kept on the way through the interval


class NeuronClass(Enum):
    """What a neuron does; each value is the word on the command line."""

    WORKS = "works"
    CALL_ALONE = "call-alone"
    ECHO_ALONE = "echo-alone"
    NEVER = "never"
    REST_FIRES = "rest-fires"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Tuning:
    """Tuning of one neuron. Times in s; NaN where not defined. `reason`: why a sample failed.

    first, last: edges of the facilitating interval; t_inh: from the call to the release of the inhibition;
    t_reb: from there to the peak of v_mem after a call alone.
    """

    outcome: NeuronClass
    first: float = math.nan
    last: float = math.nan
    t_inh: float = math.nan
    t_reb: float = math.nan
    reason: str = ""

    @property
    def best_delay(self) -> float:
        """Midpoint of the facilitating interval, s."""
        return 0.5 * (self.first + self.last)

    @property
    def width(self) -> float:
        """Length of the facilitating interval, s."""
        return self.last - self.first


def tuning_machine(neuron: Circuit, silicon: Silicon) -> Machine:
    """The neuron with call and echo driven from outside."""
    sources = (
        Source("vdd", "vdd", Constant(silicon.process.v_dd)),
        Source("call", "call", Driven(0.0)),
        Source("echo", "echo", Driven(0.0)),
    )
    return to_kernel(Testbench("rebound neuron", neuron, sources, math.inf, watch=("spike",)), silicon)


def tune(machine: Machine, rtol: float = TUNING_RTOL) -> Tuning:
    """Class, best delay and release of the neuron of a `tuning_machine`.

    A solve that gives up makes the class `failed`, with the reason; it raises nothing.
    """
    try:
        return _tune(machine, rtol)
    except SolverError as error:
        return Tuning(NeuronClass.FAILED, reason=str(error))


def _tune(machine: Machine, rtol: float) -> Tuning:
    runner = Runner(machine, ("inhibition.b", "v_mem"), rtol)
    rest = operating_point(machine)
    if not rest.stable or _fires(runner, runner.begin(rest), _REST, {}):
        return Tuning(NeuronClass.REST_FIRES)
    call = _after_call(runner, rest)
    if call is None:
        return Tuning(NeuronClass.NEVER)
    if call.fires:
        return Tuning(NeuronClass.CALL_ALONE, t_inh=call.t_inh, t_reb=call.t_reb)
    if _fires(runner, runner.begin(rest), call.t_reb + _REST, {"echo": _pulse(machine, 0.0)}):
        return Tuning(NeuronClass.ECHO_ALONE, t_inh=call.t_inh, t_reb=call.t_reb)
    edges = _interval(runner, call)
    if edges is None:
        return Tuning(NeuronClass.NEVER, t_inh=call.t_inh, t_reb=call.t_reb)
    return Tuning(NeuronClass.WORKS, *edges, call.t_inh, call.t_reb)


@dataclass(frozen=True, slots=True)
class _Call:
    """The run after a call without an echo, and states on its way."""

    fires: bool
    t_inh: float
    t_reb: float
    earliest: float
    latest: float
    states: tuple[State, ...]


def _pulse(machine: Machine, start: float) -> Polyline:
    """A full-supply pulse of 10 us with 0.1 us edges."""
    v_dd = machine.silicon.process.v_dd
    return start + np.array([0.0, 0.1e-6, 10.1e-6, 10.2e-6]), np.array([0.0, v_dd, v_dd, 0.0])


def _fires(runner: Runner, state: State, until: float, inputs: dict[str, Polyline]) -> bool:
    """Whether a spike comes before `until` (s)."""
    return bool(runner.advance(state, until, inputs)[1].spikes)


def _after_call(runner: Runner, rest: OperatingPoint) -> _Call | None:
    """Run the call alone; None where the inhibition does not end."""
    machine = runner.machine
    half = 0.5 * machine.silicon.process.v_dd
    start = runner.begin(rest)
    inputs = {"call": _pulse(machine, 0.0)}
    state, _ = runner.advance(start, 20e-6, inputs, stop_at_event=False)
    horizon, t_inh = NOMINAL_RELEASE, math.nan
    while math.isnan(t_inh):
        if state.now >= LONGEST_INHIBITION:
            return None
        state, segment = runner.advance(state, horizon, stop_at_event=False)
        low = np.flatnonzero(segment.voltage[:, 0] < half)
        t_inh = float(segment.time[low[0]]) if low.size else math.nan
        horizon *= 2.0
    # a second pass over the stretch in which echoes can matter, keeping states on the way
    earliest, latest = 0.0, t_inh + _rebound_bound(runner)
    state, _ = runner.advance(start, 20e-6, inputs, stop_at_event=False)
    states, spikes, peak = [state], 0, (-math.inf, t_inh)
    for until in np.linspace(earliest, latest, _KEPT + 1)[1:]:
        if until <= state.now:
            continue
        state, segment = runner.advance(state, float(until), stop_at_event=False)
        spikes += len(segment.spikes)
        after = segment.time > t_inh
        if after.any():
            k = int(np.argmax(np.where(after, segment.voltage[:, 1], -np.inf)))
            peak = max(peak, (float(segment.voltage[k, 1]), float(segment.time[k])))
        states.append(state)
    return _Call(spikes > 0, t_inh, peak[1] - t_inh, earliest, latest, tuple(states))


def _rebound_bound(runner: Runner) -> float:
    """A time after the release by which the rebound is over, s: C_r V_dd / I_rtau at this temperature."""
    machine = runner.machine
    circuit, silicon = machine.testbench.circuit, machine.silicon
    capacitor = next(g for g in machine.flat.groups if g.device.name == "c_r")
    current = saturation_current(circuit, circuit.bias("i_rtau"), silicon)
    return float(capacitor.parameters["capacitance"][0]) * silicon.process.v_dd / float(current)


def _interval(runner: Runner, call: _Call) -> tuple[float, float] | None:
    """Edges of the facilitating interval; None where no delay of the scan facilitates."""
    machine = runner.machine
    times = [s.now for s in call.states]
    until = call.latest + (call.latest - call.t_inh)

    def fires(delay: float) -> bool:
        state = call.states[max(bisect_right(times, delay) - 1, 0)]
        if delay > state.now:
            state, _ = runner.advance(state, delay)
        return _fires(runner, state, until, {"echo": _pulse(machine, delay)})

    span = call.latest - call.t_inh
    low = max(call.t_inh - span, 30e-6)
    for points in (_SCAN, 4 * _SCAN):
        delays = np.linspace(low, call.latest, points)
        hits = [fires(float(d)) for d in delays]
        if any(hits):
            first = hits.index(True)
            last = first + (hits[first:].index(False) if False in hits[first:] else len(hits) - first) - 1
            left = float(delays[first - 1]) if first > 0 else low
            right = float(delays[last + 1]) if last + 1 < len(delays) else call.latest
            return _edge(fires, left, float(delays[first])), _edge(fires, right, float(delays[last]))
    return None


def _edge(fires: Callable[[float], bool], outside: float, inside: float) -> float:
    """Bisect between a delay that does not facilitate and one that does, s."""
    while abs(outside - inside) > RESOLUTION:
        middle = 0.5 * (outside + inside)
        if fires(middle):
            inside = middle
        else:
            outside = middle
    return 0.5 * (outside + inside)
