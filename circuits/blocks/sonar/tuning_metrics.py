"""Metrics of a rebound neuron's tuning, all of which come from one `tune` but for the number of spikes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from operator import attrgetter

from circuits.blocks.metric import Edge, Metric
from circuits.blocks.sonar.rebound_neuron import AFTER_RELEASE, CALL_TIME, NOMINAL_RELEASE
from circuits.blocks.sonar.spike_count import SpikeCount, count_spikes
from circuits.blocks.sonar.tuning import RESOLUTION, NeuronClass, Tuning, beside_edge, tune, tuning_machine
from circuits.event import LENGTH
from circuits.lowering.kernel import Machine


def shown(tuning: Tuning) -> Mapping[str, float | None]:
    """Knobs of the testbench that show a tuning: the pulses by which the class of the neuron was decided.

    A neuron that works has an echo at its best delay, and one that never fires has it at the peak of its
    rebound.
    """
    call = None if tuning.outcome in _WITHOUT_CALL else 1.0
    echo = None if tuning.outcome in _WITHOUT_ECHO else 1.0
    if call is None or not math.isfinite(tuning.t_inh):
        return {"call": call, "echo": echo}
    rebound = tuning.t_inh + tuning.t_reb
    delay = tuning.best_delay if tuning.outcome is NeuronClass.WORKS else rebound
    end = CALL_TIME + max(NOMINAL_RELEASE, rebound, delay) + AFTER_RELEASE + tuning.t_reb
    return {"call": call, "echo": echo, "delay": delay, "duration": end}


_WITHOUT_CALL = (NeuronClass.REST_FIRES, NeuronClass.ECHO_ALONE)
_WITHOUT_ECHO = (NeuronClass.REST_FIRES, NeuronClass.CALL_ALONE)


def _outcome(tuning: Tuning) -> str:
    return tuning.outcome.value


def _metric(name: str, unit: str, summary: str, value: Callable[[Tuning], float] | None) -> Metric:
    reason: Callable[[Tuning], str] = attrgetter("reason")
    circuits = ("rebound_neuron",)
    return Metric(name, unit, summary, circuits, tuning_machine, tune, _outcome, reason, value, shown=shown)


def _edges(of_first: float, of_last: float) -> Callable[[Machine, Tuning], list[Edge]]:
    """Both edges of the facilitating interval with their weights in a metric; none of a neuron without it."""

    def edges(machine: Machine, tuning: Tuning) -> list[Edge]:
        if tuning.outcome is not NeuronClass.WORKS:
            return []
        first = partial(beside_edge, machine, tuning, tuning.first, -1.0)
        last = partial(beside_edge, machine, tuning, tuning.last, 1.0)
        begins = (max(at + LENGTH, tuning.t_inh) for at in (tuning.first, tuning.last))
        return [
            Edge(beside, RESOLUTION, "echo", "spike", "v_ax", begin, weight)
            for beside, begin, weight in zip((first, last), begins, (of_first, of_last), strict=True)
        ]

    return edges


BEST_DELAY = replace(
    _metric("best_delay", "s", "midpoint of the facilitating interval", attrgetter("best_delay")),
    edges=_edges(0.5, 0.5),
)
WIDTH = replace(
    _metric("width", "s", "length of the facilitating interval", attrgetter("width")), edges=_edges(-1.0, 1.0)
)
T_INH = _metric("t_inh", "s", "from the call to the release of the inhibition", attrgetter("t_inh"))
T_REB = _metric("t_reb", "s", "from the release to the peak of v_mem", attrgetter("t_reb"))
CLASS = _metric("class", "", "what the neuron does: works, call-alone, ...", None)


def _count_shown(count: SpikeCount) -> Mapping[str, float | None]:
    return shown(count.tuning)


def _count_outcome(count: SpikeCount) -> str:
    return count.outcome


SPIKES_PER_ECHO = Metric(
    "spikes_per_echo",
    "",
    "spikes after a call and an echo at the best delay",
    ("rebound_neuron",),
    tuning_machine,
    count_spikes,
    _count_outcome,
    attrgetter("tuning.reason"),
    attrgetter("spikes"),
    shown=_count_shown,
)
