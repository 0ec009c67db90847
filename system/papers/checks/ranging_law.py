"""The ranging chip's neuron under the full law, held against its transistors on unseen dies.

No figure of a paper. Dies A/1000 to A/1019 with mismatch and process variation, at -10, 27 and 60 degC, with
both kinds of bias: what the solver makes of the neuron's circuit under the full law of its process, and what
the behavioural model does. Compared are the class of the neuron (`circuits.blocks.sonar.tuning`) where the
model decides it, the time of inhibition, and, where the neuron works on both levels, its best delay. The
margins are those that every model of a chip is held to. No value is fitted.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from chips.measured.held_out import KINDS
from chips.ranging.model import model_of, neurons_on
from chips.ranging.response import UNDECIDED, tune
from circuits.bias import rebias
from circuits.blocks.sonar import rebound_neuron, tuning
from circuits.circuit import BiasKind
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report
from system.papers.checks.beside import ALIKE, NEAR, TIED, draw_errors, judged, largest_error, on_dies
from system.statement import Statement

DIES = range(1000, 1020)


@dataclass(frozen=True, slots=True)
class Beside:
    """One neuron on both levels: classes, inhibition and best delays (s), NaN where there is none."""

    kind: BiasKind
    temperature_c: float
    circuit: str
    model: str
    t_inh: tuple[float, float]
    best_delay: tuple[float, float]


def beside(kind: BiasKind, silicon: Silicon) -> Beside:
    """Return what both levels say of the neuron on a silicon; the circuit's is first."""
    neuron = rebias(rebound_neuron.build(), kind=kind)
    one = tuning.tune(tuning.tuning_machine(neuron, silicon))
    other = tune(neurons_on(model_of(neuron, silicon.process), silicon))
    return Beside(
        kind,
        silicon.temperature_c,
        one.outcome.value,
        other.classes[0],
        (one.t_inh, float(other.t_inh[0])),
        (one.best_delay, 0.5 * float(other.first[0] + other.last[0])),
    )


def compare(dies: Iterable[int], progress: Progress = lambda _: None) -> list[Beside]:
    """Return the neuron on every die at every temperature with every kind of bias, under the full law."""
    return on_dies(beside, dies, progress, KINDS)


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


def _largest(pairs: list[tuple[float, float]]) -> float:
    """Largest relative difference of those pairs that both levels have."""
    circuit, model = np.array([pair for pair in pairs if not np.isnan(pair).any()]).reshape(-1, 2).T
    return largest_error(circuit, model)


def run(progress: Progress) -> Report:
    """Compare both levels on all dies."""
    found = compare(DIES, progress)
    return Report(statements(found), lambda figure: draw(found, figure))


def draw(found: list[Beside], figure: Figure) -> None:
    """Draw the error of each inhibition over its length."""
    pairs = {kind: np.array([b.t_inh for b in found if b.kind == kind]) for kind in KINDS}
    draw_errors({kind: (each[:, 0], each[:, 1]) for kind, each in pairs.items()}, "inhibition", figure)


EXPERIMENT = Experiment(
    "ranging-law", "the ranging chip's neuron under the full law against its transistors", run
)
