"""Metrics of a rebound neuron's tuning; all but the number of spikes come from one `tune`."""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter

from circuits.blocks.metric import Metric
from circuits.blocks.spike_count import SpikeCount, count_spikes
from circuits.blocks.tuning import Tuning, tune, tuning_machine


def _outcome(tuning: Tuning) -> str:
    return tuning.outcome.value


def _metric(name: str, unit: str, summary: str, value: Callable[[Tuning], float] | None) -> Metric:
    reason: Callable[[Tuning], str] = attrgetter("reason")
    return Metric(name, unit, summary, ("rebound_neuron",), tuning_machine, tune, _outcome, reason, value)


BEST_DELAY = _metric("best_delay", "s", "midpoint of the facilitating interval", attrgetter("best_delay"))
WIDTH = _metric("width", "s", "length of the facilitating interval", attrgetter("width"))
T_INH = _metric("t_inh", "s", "from the call to the release of the inhibition", attrgetter("t_inh"))
T_REB = _metric("t_reb", "s", "from the release to the peak of v_mem", attrgetter("t_reb"))
CLASS = _metric("class", "", "what the neuron does: works, call-alone, ...", None)


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
)
