"""Tuning of a rebound neuron: its best delay, and the class of what it does.

An echo at a delay after the call facilitates when the neuron fires. The best delay is the middle of the
facilitating interval, whose edges are bisected to 10 us. A neuron has a best delay only when it works: when
it is silent at rest, after a call without an echo, and after an echo without a call. Anything else is a class
of its own, which is a result too and is never dropped.

The search asks an engine (`Trials`), so that another simulator can be asked the same. The one of the solver
runs the call once; every echo goes on from a state that was kept shortly before it.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import final

import numpy as np

from circuits.arrays import F64
from circuits.bias import die_current, saturation_current
from circuits.blocks.sonar.rebound_neuron import NOMINAL_RELEASE
from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, Driven, Polyline
from circuits.errors import SolverError
from circuits.event import LENGTH, pulse, pulse_line
from circuits.lowering.kernel import Machine, to_kernel
from circuits.lowering.supply import half_supply
from circuits.silicon.silicon import Silicon
from circuits.solver.beginning import beginning
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Runner, State
from circuits.testbench import Testbench

RESOLUTION = 10e-6  # s, of the edges
TUNING_RTOL = 1e-5  # ours: at 1e-4 edges of nearly grazing neurons move by 50 us, and some change their class
LONGEST_INHIBITION = 2.0  # s; a neuron still inhibited then counts as never
CALLED = 20e-6  # s, by when the call's pulse is over
_REST = 20e-3  # s, watched for spikes without any stimulus
_SCAN = 24  # delays tried before the edges are bisected
_KEPT = 16  # states kept on the way through the interval


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
    """Tuning of a neuron. Times are in s, and NaN where they are not defined.

    first, last: edges of the facilitating interval. t_inh: from the call to the release of the inhibition.
    t_reb: from there to the peak of v_mem after a call alone. reason: why a sample failed, empty unless it
    did.
    """

    outcome: NeuronClass
    first: float = math.nan
    last: float = math.nan
    t_inh: float = math.nan
    t_reb: float = math.nan
    reason: str = ""

    @property
    def best_delay(self) -> float:
        """Middle of the facilitating interval, s."""
        return 0.5 * (self.first + self.last)

    @property
    def width(self) -> float:
        """Length of the facilitating interval, s."""
        return self.last - self.first


def tuning_machine(neuron: Circuit, silicon: Silicon) -> Machine:
    """The neuron on its silicon, with call and echo driven from outside while a run goes on."""
    sources = (
        Source("vdd", "vdd", Constant(silicon.process.v_dd)),
        Source("call", "call", Driven(0.0)),
        Source("echo", "echo", Driven(0.0)),
    )
    return to_kernel(Testbench("rebound neuron", neuron, sources, math.inf, watch=("spike",)), silicon)


def tune(machine: Machine, rtol: float = TUNING_RTOL) -> Tuning:
    """Class, best delay and release of the neuron of a `tuning_machine`.

    Where the solver gives up, the class is `failed` and has the reason; nothing is raised.
    """
    try:
        return search(_SolverTrials(machine, rtol))
    except SolverError as error:
        return Tuning(NeuronClass.FAILED, reason=str(error))


def beside_edge(machine: Machine, tuning: Tuning, edge: float, side: float, away: float) -> Machine:
    """The neuron of a `tuning_machine` with a call at 0, and an echo beside an edge of what facilitates.

    side: 1 for an echo that is later by `away` (s), -1 for an earlier one.
    """
    delay, v_dd = edge + side * away, machine.silicon.process.v_dd
    supply = machine.testbench.sources[0]
    pulses = (Source(name, name, pulse((at,), v_dd)) for name, at in (("call", 0.0), ("echo", delay)))
    stop = tuning.t_inh + 2.0 * rebound_bound(machine)
    return to_kernel(
        replace(machine.testbench, sources=(supply, *pulses), stop=max(stop, delay + LENGTH)), machine.silicon
    )


@dataclass(frozen=True, slots=True)
class Call:
    """What a run after a call at time 0 without an echo shows, s; `latest`: when the rebound is over."""

    fires: bool
    t_inh: float
    t_reb: float
    latest: float


class Trials(ABC):
    """What the search asks of an engine: whether a neuron on a die, at rest at time 0, fires in a run."""

    @abstractmethod
    def fires_at_rest(self, until: float) -> bool:
        """Whether the rest state is unstable, or a spike comes without any stimulus before `until` (s)."""

    @abstractmethod
    def after_call(self) -> Call | None:
        """Run the call alone until the rebound is over; None where the inhibition does not end."""

    @abstractmethod
    def fires_after_echo(self, until: float) -> bool:
        """Whether an echo at time 0 without a call makes a spike before `until` (s)."""

    @abstractmethod
    def fires_after_both(self, delay: float, until: float) -> bool:
        """Whether an echo `delay` after the call makes a spike between it and `until` (s)."""


def search(trials: Trials) -> Tuning:
    """Class and best delay of a neuron by the answers of an engine, whichever it is."""
    if trials.fires_at_rest(_REST):
        return Tuning(NeuronClass.REST_FIRES)
    call = trials.after_call()
    if call is None:
        return Tuning(NeuronClass.NEVER)
    if call.fires:
        return Tuning(NeuronClass.CALL_ALONE, t_inh=call.t_inh, t_reb=call.t_reb)
    if trials.fires_after_echo(call.t_reb + _REST):
        return Tuning(NeuronClass.ECHO_ALONE, t_inh=call.t_inh, t_reb=call.t_reb)
    edges = _interval(trials, call)
    if edges is None:
        return Tuning(NeuronClass.NEVER, t_inh=call.t_inh, t_reb=call.t_reb)
    return Tuning(NeuronClass.WORKS, *edges, call.t_inh, call.t_reb)


@final
class _SolverTrials(Trials):
    """The solver as an engine; echoes after a call go on from states that were kept on its way."""

    def __init__(self, machine: Machine, rtol: float) -> None:
        """Find the rest state; `SolverError` where there is none."""
        self._runner = Runner(machine, ("inhibition.b", "v_mem"), rtol)
        self._rest = operating_point(machine)
        # of a rest that is not stable the class tells, which needs no warning
        self._start = self._runner.enter(beginning(machine, point=self._rest))
        self._states: list[State] = []

    def fires_at_rest(self, until: float) -> bool:
        """As the base class says."""
        return not self._rest.stable or self._fires(self._start, until, {})

    def after_call(self) -> Call | None:
        """As the base class says; keeps the states that echoes go on from."""
        t_inh = self._release()
        if math.isnan(t_inh):
            return None
        # a second pass over the stretch in which echoes can matter, keeping states on the way
        latest = t_inh + rebound_bound(self._runner.machine)
        state = self._called()
        self._states, spikes, peak = [state], 0, (-math.inf, t_inh)
        for until in np.linspace(0.0, latest, _KEPT + 1)[1:]:
            if until <= state.now:
                continue
            state, segment = self._runner.advance(state, float(until), stop_at_event=False)
            spikes += len(segment.spikes)
            peak = max(peak, later_peak(segment.time, segment.voltage[:, 1], t_inh))
            self._states.append(state)
        return Call(spikes > 0, t_inh, peak[1] - t_inh, latest)

    def fires_after_echo(self, until: float) -> bool:
        """As the base class says."""
        return self._fires(self._start, until, {"echo": event_pulse(self._runner.machine, 0.0)})

    def fires_after_both(self, delay: float, until: float) -> bool:
        """As the base class says; `after_call` comes first, and without an echo there is no spike."""
        times = [s.now for s in self._states]
        state = self._states[max(bisect_right(times, delay) - 1, 0)]
        return self._fires(state, until, {"echo": event_pulse(self._runner.machine, delay)})

    def _called(self) -> State:
        """State 20 us after the call began."""
        inputs = {"call": event_pulse(self._runner.machine, 0.0)}
        return self._runner.advance(self._start, CALLED, inputs, stop_at_event=False)[0]

    def _release(self) -> float:
        """t_inh, s; NaN where the inhibition does not end."""
        state, horizon, t_inh = self._called(), NOMINAL_RELEASE, math.nan
        while math.isnan(t_inh) and state.now < LONGEST_INHIBITION:
            state, segment = self._runner.advance(state, horizon, stop_at_event=False)
            t_inh = release(self._runner.machine, segment.time, segment.voltage[:, 0])
            horizon *= 2.0
        return t_inh

    def _fires(self, state: State, until: float, inputs: dict[str, Polyline]) -> bool:
        return bool(self._runner.advance(state, until, inputs)[1].spikes)


def event_pulse(machine: Machine, start: float) -> Polyline:
    """An event at `start` (s) as a polyline, on the supply of a machine's process."""
    return pulse_line(start, machine.silicon.process.v_dd)


def release(machine: Machine, time: F64, gate: F64) -> float:
    """First time (s) at which the inhibition's gate is below half the supply; NaN without one."""
    low = np.flatnonzero(gate < half_supply(machine))
    return float(time[low[0]]) if low.size else math.nan


def later_peak(time: F64, v_mem: F64, t_inh: float) -> tuple[float, float]:
    """Highest v_mem (V) after the release, and its time (s); minus infinity where all is before."""
    after = time > t_inh
    if not after.any():
        return -math.inf, t_inh
    k = int(np.argmax(np.where(after, v_mem, -np.inf)))
    return float(v_mem[k]), float(time[k])


def rebound_bound(machine: Machine) -> float:
    """A time after the release by which the rebound is over, s: C_r V_dd / I_rtau.

    The current is the nominal device's, or the die's own where that is smaller: its rebound lasts longer.
    """
    circuit, silicon = machine.testbench.circuit, machine.silicon
    capacitor = next(g for g in machine.flat.groups if g.device.name == "c_r")
    bias = circuit.bias("i_rtau")
    current = min(float(saturation_current(circuit, bias, silicon)), die_current(circuit, bias, silicon))
    return float(capacitor.parameters["capacitance"][0]) * silicon.process.v_dd / current


def _interval(trials: Trials, call: Call) -> tuple[float, float] | None:
    """Edges of the facilitating interval; None where no delay of the scan facilitates."""
    span = call.latest - call.t_inh
    until = call.latest + span

    def fires(delay: float) -> bool:
        return trials.fires_after_both(delay, until)

    low = max(call.t_inh - span, 30e-6)
    for points in (_SCAN, 4 * _SCAN):
        delays = np.linspace(low, call.latest, points).tolist()
        first = next((k for k, delay in enumerate(delays) if fires(delay)), None)
        if first is not None:
            silent = next((k for k in range(first + 1, points) if not fires(delays[k])), points)
            left = delays[first - 1] if first > 0 else low
            right = delays[silent] if silent < points else call.latest
            return _edge(fires, left, delays[first]), _edge(fires, right, delays[silent - 1])
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
