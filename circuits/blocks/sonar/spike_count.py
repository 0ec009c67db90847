"""How often a rebound neuron spikes after one facilitating echo: once, or in a burst.

The best delay of the neuron is measured. Then a call and an echo that much later are run until a whole
rebound has passed without a spike; since the echo current only falls, none can follow. "The rebound chip can
be tuned to respond with one or multiple spikes to a facilitative stimulus" (Cheely & Horiuchi 2003, section
3): the biases do it, see `BIAS_SETS` of `circuits.blocks.sonar.rebound_neuron`. A neuron that does not work
has no count.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from circuits.blocks.sonar.tuning import TUNING_RTOL, NeuronClass, Tuning, event_pulse, rebound_bound, tune
from circuits.errors import SolverError
from circuits.lowering.kernel import Machine
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Runner

MOST = 1000  # spikes at which a neuron that goes on is cut off


@dataclass(frozen=True, slots=True)
class SpikeCount:
    """A neuron's tuning, and its spikes after a call and an echo at its best delay; NaN unless it works."""

    tuning: Tuning
    spikes: float = math.nan

    @property
    def outcome(self) -> str:
        """`one-spike` or `several-spikes` of a neuron that works, else its class."""
        if self.tuning.outcome is not NeuronClass.WORKS:
            return str(self.tuning.outcome.value)
        return {0.0: "none", 1.0: "one-spike"}.get(self.spikes, "several-spikes")


def count_spikes(machine: Machine, rtol: float = TUNING_RTOL) -> SpikeCount:
    """Spikes that an echo at its best delay makes in the neuron of a `tuning_machine`.

    Where the solver gives up, the class is `failed` and has the reason; nothing is raised.
    """
    tuning = tune(machine, rtol)
    if tuning.outcome is not NeuronClass.WORKS:
        return SpikeCount(tuning)
    try:
        return SpikeCount(tuning, _spikes(machine, tuning, rtol))
    except SolverError as error:
        return SpikeCount(Tuning(NeuronClass.FAILED, reason=str(error)))


def _spikes(machine: Machine, tuning: Tuning, rtol: float) -> int:
    runner = Runner(machine, (), rtol)
    quiet, delay = rebound_bound(machine), tuning.best_delay
    state = runner.begin(operating_point(machine))
    state, _ = runner.advance(state, delay, {"call": event_pulse(machine, 0.0)}, stop_at_event=False)
    # the tuning waits as long for the first spike
    until = tuning.t_inh + 2.0 * quiet
    state, segment = runner.advance(state, until, {"echo": event_pulse(machine, delay)})
    count = 0
    while segment.spikes and count < MOST:
        count += 1
        state, segment = runner.advance(state, state.now + quiet)
    return count
