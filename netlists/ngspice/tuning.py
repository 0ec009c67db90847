"""Best delay and outcome class of a rebound neuron, measured by ngspice.

The search is the solver's own (`circuits.blocks.sonar.tuning`), asked of another engine: the same questions,
the same delays, the same bisection. ngspice keeps no states to go on from, so every question is a run from
the operating point on, which the first run finds and the others get as `.nodeset`. It does not tell a stable
rest state from an unstable one either: that one word is our own eigenvalue test, at ngspice's rest state; the
watch for spikes at rest is a run.

Trapezoidal integration: on die 1000 it puts the spike after an echo at the best delay within 0.1 us at reltol
1e-4, where gear is 0.7 us off at 1e-5 and a fifth of the step.
"""

from __future__ import annotations

import math
from typing import final

import numpy as np

from circuits.blocks.sonar.rebound_neuron import NOMINAL_RELEASE
from circuits.blocks.sonar.tuning import (
    CALLED,
    LONGEST_INHIBITION,
    Call,
    Trials,
    Tuning,
    event_pulse,
    later_peak,
    rebound_bound,
    release,
    tuning_machine,
)
from circuits.circuit import GROUND, Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, PiecewiseLinear, Waveform
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from netlists.ngspice import engine

RELTOL = 1e-4  # ours: with it edges stay within 10 us of those at a tenth of it
LARGEST_STEP = 50e-6  # s, ours: between events a neuron moves slowly, and reltol sets the steps
DEADLINE = 120.0  # s, wall clock, for one run


def edges_hold(trials: NgspiceTrials, tuning: Tuning, margin: float) -> bool:
    """Whether a neuron fires `margin` (s) within both edges of a tuning, and not so far outside."""
    until = tuning.t_inh + 2.0 * trials.span
    inside = (tuning.first + margin, tuning.last - margin)
    outside = (tuning.first - margin, tuning.last + margin)
    return all(trials.fires_after_both(d, until) for d in inside) and not any(
        trials.fires_after_both(d, until) for d in outside
    )


@final
class NgspiceTrials(Trials):
    """Trials by ngspice, each a run from the operating point.

    `runs` counts them; `span`: how long a rebound can last after the release, s.
    """

    def __init__(
        self,
        neuron: Circuit,
        silicon: Silicon,
        reltol: float = RELTOL,
        tmax: float = LARGEST_STEP,
    ) -> None:
        """Lower the neuron; nothing runs yet.

        neuron, silicon: as for `circuits.blocks.sonar.tuning.tuning_machine`. reltol, tmax: ngspice's
        relative tolerance and largest step (s). Any trial raises `SimulatorError` where ngspice is missing,
        gives up or is too slow.
        """
        self._machine = tuning_machine(neuron, silicon)
        self._reltol, self._tmax = reltol, tmax
        self._start: dict[str, float] = {}
        self.span = rebound_bound(self._machine)
        self.runs = 0

    def fires_at_rest(self, until: float) -> bool:
        """As the base class says."""
        result = self._run(until)
        return not result.operating_point.stable or _fires(result, 0.0)

    def after_call(self) -> Call | None:
        """As the base class says."""
        span = self.span
        horizon = NOMINAL_RELEASE + span
        while True:
            result = self._run(horizon, call=0.0)
            called = result.time > CALLED
            time = result.time[called]
            t_inh = release(self._machine, time, result["inhibition.b"][called])
            if math.isnan(t_inh) and horizon >= LONGEST_INHIBITION:
                return None
            if t_inh + span <= horizon:
                break
            horizon = 2.0 * horizon if math.isnan(t_inh) else t_inh + span
        latest = t_inh + span
        rebound = time <= latest
        peak = later_peak(time[rebound], result["v_mem"][called][rebound], t_inh)
        fires = any(times[times <= latest].size for times in result.spikes.values())
        return Call(fires, t_inh, peak[1] - t_inh, latest)

    def fires_after_echo(self, until: float) -> bool:
        """As the base class says."""
        return _fires(self._run(until, echo=0.0), 0.0)

    def fires_after_both(self, delay: float, until: float) -> bool:
        """As the base class says."""
        return _fires(self._run(until, call=0.0, echo=delay), delay)

    def _run(self, stop: float, call: float | None = None, echo: float | None = None) -> Result:
        """Run from rest to `stop` (s) with a pulse at each time given (s)."""
        machine = self._machine
        sources = (
            Source("vdd", "vdd", Constant(machine.silicon.process.v_dd)),
            Source("call", "call", self._pulse(call)),
            Source("echo", "echo", self._pulse(echo)),
        )
        circuit = machine.testbench.circuit
        bench = Testbench("rebound neuron", circuit, sources, stop, ("spike",), self._start)
        result = engine.simulate(
            bench, machine.silicon, reltol=self._reltol, tmax=self._tmax, method="trap", deadline_s=DEADLINE
        )
        self.runs += 1
        self._start = {n: v for n, v in result.operating_point.voltages().items() if n != GROUND}
        return result

    def _pulse(self, start: float | None) -> Waveform:
        if start is None:
            return Constant(0.0)
        time, voltage = event_pulse(self._machine, start)
        return PiecewiseLinear(tuple(time.tolist()), tuple(voltage.tolist()))


def _fires(result: Result, after: float) -> bool:
    """Whether a spike comes after a time (s)."""
    return any(bool(np.any(times >= after)) for times in result.spikes.values())
