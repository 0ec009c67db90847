"""The ranging chip's neuron under the full law, held against its transistors on unseen dies.

No figure of a paper. Dies A/1000 to A/1083 with mismatch and process variation, at -10, 27 and 60 degC, with
fixed gates and with the bias generator: what the solver makes of the neuron's circuit under the full law of
its process, and what the behavioural model does. Compared are the class of the neuron
(`circuits.blocks.sonar.tuning`) where the model decides it, the time of inhibition, and, where the neuron
works on both levels, its best delay. The margins are those that every model of a chip is held to. No value is
fitted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chips.ranging.model import model_of, neurons_on
from chips.ranging.response import UNDECIDED, tune
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.sonar import rebound_neuron, tuning
from circuits.circuit import BiasKind
from system.papers.checks.beside import ALIKE, NEAR, TIED, Condition, Times, compared, judged, largest_error
from system.statement import Statement


@dataclass(frozen=True, slots=True)
class Beside:
    """One neuron on both levels: classes, inhibition and best delays, s, float64[2], NaN without one."""

    kind: BiasKind
    temperature_c: float
    circuit: str
    model: str
    t_inh: F64
    best_delay: F64


def beside(at: Condition) -> Beside:
    """Return what both levels say of the neuron at a condition; the circuit's is first."""
    silicon, neuron = at.silicon, rebias(rebound_neuron.build(), kind=at.kind)
    one = tuning.tune(tuning.tuning_machine(neuron, silicon))
    other = tune(neurons_on(model_of(neuron, silicon.process), silicon))
    return Beside(
        at.kind,
        at.temperature_c,
        one.outcome.value,
        other.classes[0],
        np.array([one.t_inh, other.t_inh[0]]),
        np.array([one.best_delay, 0.5 * (other.first[0] + other.last[0])]),
    )


def statements(found: list[Beside]) -> tuple[Statement, ...]:
    """Return how far the model is off, a row a margin."""
    decided = [b for b in found if b.model != UNDECIDED]
    same = sum(b.circuit == b.model for b in decided) / len(decided)
    inhibition = _largest([b.t_inh for b in found])
    delay = _largest([b.best_delay for b in decided if b.circuit == b.model == "works"])
    return judged(
        (
            ("class_share", same, ALIKE),
            ("undecided_share", 1.0 - len(decided) / len(found), TIED),
            ("t_inh_error_max", inhibition, NEAR),
            ("best_delay_error_max", delay, NEAR),
        )
    )


def _largest(pairs: list[F64]) -> float:
    """Largest relative difference of those pairs that both levels have."""
    circuit, model = np.array([pair for pair in pairs if not np.isnan(pair).any()]).reshape(-1, 2).T
    return largest_error(circuit, model)


def inhibitions(found: list[Beside]) -> Times:
    """Return how long each inhibition is, by the kind of bias."""
    kinds = dict.fromkeys(b.kind for b in found)
    pairs = {kind: np.array([b.t_inh for b in found if b.kind == kind]) for kind in kinds}
    return {kind: (each[:, 0], each[:, 1]) for kind, each in pairs.items()}


EXPERIMENT = compared(
    "ranging-law",
    "the ranging chip's neuron under the full law against its transistors",
    beside,
    Beside,
    ("rebound_neuron",),
    statements,
    inhibitions,
)
