"""The selection and the head's neurons under the full law, held against their transistors on unseen dies.

No figure of a paper. Dies A/1000 to A/1019 with mismatch and process variation, at -10, 27 and 60 degC, with
gates and with the bias generator: what the solver makes of the circuits under the full law of their process,
and what the behavioural models do. Of the selection two random profiles each (`chips.selection.measure`):
who wins within a millisecond, where the model does not call it a tie, and when. Of the head a neuron with a
draw of inputs of both sides, and a level unit on ramps of two slopes (`chips.lso.errors`): how many spikes,
when, and whether the unit hears. The margins are those that every model of a chip is held to. No value is
fitted.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from chips.lso.errors import AT, RAMPS, inputs, level_delays, neuron_spikes
from chips.lso.measure import FROM, LEVELS
from chips.lso.model import SIDES, head_on
from chips.selection.measure import UNDECIDED, Pair, measure_pairs
from chips.selection.model import MARGIN
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report
from system.papers.checks.beside import ALIKE, NEAR, TIED, draw_errors, judged, largest_error, on_dies
from system.statement import Statement

DIES = range(1000, 1020)
PROFILES = 2  # a die, temperature and kind

Times = list[tuple[float, float]]


@dataclass(frozen=True, slots=True)
class Heard:
    """A neuron and a level unit of the head on both levels, the circuit's number first.

    counts: spikes of the neuron; spikes: their times since the first input, s; delays: of the level unit on
    both ramps, s, inf in the circuit for no spike; hears: whether the model lets it spike.
    """

    counts: tuple[int, int]
    spikes: Times
    delays: Times
    hears: bool


def heard(kind: BiasKind, silicon: Silicon) -> Heard:
    """Return what both levels say of the head's parts on a die, whose number also chooses their places."""
    number = silicon.die.number or 0
    head, side, unit = head_on(silicon, kind), number % SIDES, number % LEVELS
    model, circuit = neuron_spikes(head, silicon, kind, side, inputs(number))
    spikes = [(float(a - AT), float(b - AT)) for a, b in zip(circuit, model, strict=False)]
    pairs = (level_delays(head, silicon, kind, (side, unit), slope) for slope in RAMPS)
    delays = [(theirs, ours) for ours, theirs in pairs]
    return Heard((circuit.size, model.size), spikes, delays, bool(head.rest[side, unit] < -FROM))


def beside(kind: BiasKind, silicon: Silicon) -> tuple[list[Pair], Heard]:
    """Return decisions and the head's parts on a silicon."""
    dies, celsius = (silicon.die.number or 0,), silicon.temperature_c
    pairs = measure_pairs(dies, PROFILES, celsius, made_in=silicon.process, kind=kind)
    return pairs, heard(kind, silicon)


def compare(dies: Iterable[int], progress: Progress = lambda _: None) -> tuple[list[Pair], list[Heard]]:
    """Return decisions and the head's parts on every die at every temperature with both kinds of bias."""
    pairs, found = zip(*on_dies(beside, dies, progress), strict=True)
    return [pair for each in pairs for pair in each], list(found)


def statements(pairs: list[Pair], found: list[Heard]) -> tuple[Statement, ...]:
    """Return how far the models are off, a row a margin."""
    certain = [p for p in pairs if p.margin > MARGIN]
    same = [p for p in certain if p.solved == p.modelled]
    times = [(p.solved_time, p.modelled_time) for p in same if p.solved != UNDECIDED]
    delays = [pair for each in found for pair in each.delays if np.isfinite(pair[0]) and each.hears]
    hears = [np.isfinite(theirs) == each.hears for each in found for theirs, _ in each.delays]
    counts = [a == b for a, b in (each.counts for each in found)]
    return judged(
        (
            ("winner_share", len(same) / len(certain), ALIKE),
            ("tie_share", 1.0 - len(certain) / len(pairs), TIED),
            ("decision_error_max", _largest(times), NEAR),
            ("count_share", float(np.mean(counts)), ALIKE),
            ("spike_error_max", _largest([t for h in found for t in h.spikes]), NEAR),
            ("hears_share", float(np.mean(hears)), ALIKE),
            ("level_error_max", _largest(delays), NEAR),
        )
    )


def _largest(pairs: Times) -> float:
    """Largest relative difference of pairs of times, s."""
    return largest_error(*_columns(pairs))


def _columns(pairs: Times) -> tuple[F64, F64]:
    circuit, model = np.array(pairs).reshape(-1, 2).T
    return circuit, model


def run(progress: Progress) -> Report:
    """Compare both levels on all dies."""
    found = compare(DIES, progress)
    return Report(statements(*found), lambda figure: draw(*found, figure))


def draw(pairs: list[Pair], found: list[Heard], figure: Figure) -> None:
    """Draw the error of each decision, spike and level unit over its time."""
    decided = [(p.solved_time, p.modelled_time) for p in pairs if p.solved == p.modelled != UNDECIDED]
    spikes = [t for h in found for t in h.spikes]
    delays = [t for h in found for t in h.delays if np.isfinite(t[0])]
    named = {"decisions": decided, "spikes of neurons": spikes, "level units": delays}
    draw_errors({name: _columns(times) for name, times in named.items()}, "time", figure)


EXPERIMENT = Experiment(
    "choice-law", "selection and head's neurons under the full law against their transistors", run
)
