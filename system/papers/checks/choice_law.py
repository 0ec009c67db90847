"""The selection and the head's neurons under the full law, held against their transistors on unseen dies.

No figure of a paper. Dies A/1100 to A/1183 with mismatch and process variation, at -10, 27 and 60 degC, with
gates and with the bias generator: what the solver makes of the circuits under the full law of their process,
and what the behavioural models do. Of the selection two random profiles each (`chips.selection.measure`):
who wins within a millisecond, where the model does not call it a tie, and when. Of the head a neuron with a
draw of inputs of both sides, and a level unit on ramps of two slopes (`chips.lso.errors`): how many spikes,
when, and whether the unit hears. The model says where it does not know: of a count where a spike comes within
`chips.lso.model.SPIKE_ERROR` of the end of its steps, of a unit that rests within `REST_ERROR` of what it
needs. The margins are those that every model of a chip is held to. No value is fitted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chips.lso.errors import RAMPS, inputs, level_delays, neuron_spikes
from chips.lso.measure import AT, FROM, LEVELS
from chips.lso.model import REST_ERROR, SIDES, head_on, is_count_certain
from chips.selection.measure import UNDECIDED, measure_pairs
from chips.selection.model import MARGIN
from circuits.arrays import F64
from system.papers.checks.beside import ALIKE, NEAR, TIED, Condition, Times, compared, judged, largest_error
from system.statement import Statement

FIRST = 1100  # of the dies: those before were looked at while the head's model was made
PROFILES = 2  # a die, temperature and kind


@dataclass(frozen=True, slots=True)
class Decision:
    """A decision of the selection on both levels, the circuit's first.

    winners: -1 where none has won at the deadline; times: s, float64[2]; margin: of the model.
    """

    winners: tuple[int, int]
    times: F64
    margin: float

    @property
    def same(self) -> bool:
        """Whether both levels have one winner, or none."""
        return self.winners[0] == self.winners[1]


@dataclass(frozen=True, slots=True)
class Beside:
    """Decisions, and a neuron and a level unit of the head, on both levels, the circuit's number first.

    counts: spikes of the neuron; spikes: their times since the first input, s, float64[spikes, 2]; delays: of
    the level unit on both ramps, s, float64[ramps, 2], NaN in the circuit for no spike; hears: whether the
    model lets it spike; count_known, hearing_known: whether the model is certain of the count, and of that.
    """

    decisions: tuple[Decision, ...]
    counts: tuple[int, int]
    spikes: F64
    delays: F64
    hears: bool
    count_known: bool
    hearing_known: bool


def beside(at: Condition) -> Beside:
    """Return decisions and the head's parts at a condition, whose die also chooses their places."""
    pairs = measure_pairs((at.die,), PROFILES, at.temperature_c, made_in=at.silicon.process, kind=at.kind)
    head, place = head_on(at.silicon, at.kind), (at.die % SIDES, at.die % LEVELS)
    given = inputs(at.die)
    model, circuit = neuron_spikes(head, at.silicon, at.kind, place[0], given)
    both = min(circuit.size, model.size)
    spikes = np.stack([circuit[:both], model[:both]], axis=-1) - AT
    delays = np.array([level_delays(head, at.silicon, at.kind, place, slope)[::-1] for slope in RAMPS])
    return Beside(
        tuple(
            Decision((p.solved, p.modelled), _known(np.array([p.solved_time, p.modelled_time])), p.margin)
            for p in pairs
        ),
        (circuit.size, model.size),
        spikes,
        _known(delays),
        bool(head.rest[place] < -FROM),
        is_count_certain(head, place[0], given),
        bool(abs(head.rest[place] + FROM) > REST_ERROR),
    )


def _known(times: F64) -> F64:
    """Times with NaN for what never comes."""
    return np.where(np.isfinite(times), times, np.nan)


def statements(found: list[Beside]) -> tuple[Statement, ...]:
    """Return how far the models are off, a row a margin."""
    decisions = [d for each in found for d in each.decisions]
    certain = [d for d in decisions if d.margin > MARGIN]
    same = [d for d in certain if d.same]
    delays = [pair for each in found for pair in each.delays if np.isfinite(pair[0]) and each.hears]
    known = [each for each in found if each.hearing_known]
    hears = [np.isfinite(theirs) == each.hears for each in known for theirs, _ in each.delays]
    counts = [each.counts[0] == each.counts[1] for each in found if each.count_known]
    return judged(
        (
            ("winner_share", len(same) / len(certain), ALIKE),
            ("tie_share", 1.0 - len(certain) / len(decisions), TIED),
            ("decision_error_max", _largest([d.times for d in same if d.winners[0] != UNDECIDED]), NEAR),
            ("count_share", float(np.mean(counts)), ALIKE),
            ("count_undecided_share", 1.0 - len(counts) / len(found), TIED),
            ("spike_error_max", _largest([t for each in found for t in each.spikes]), NEAR),
            ("hears_share", float(np.mean(hears)), ALIKE),
            ("hears_undecided_share", 1.0 - len(known) / len(found), TIED),
            ("level_error_max", _largest(delays), NEAR),
        )
    )


def _largest(pairs: list[F64]) -> float:
    """Largest relative difference of pairs of times, s."""
    return largest_error(*_columns(pairs))


def _columns(pairs: list[F64]) -> tuple[F64, F64]:
    circuit, model = np.array(pairs).reshape(-1, 2).T
    return circuit, model


def times(found: list[Beside]) -> Times:
    """Return those of each decision, spike and level unit."""
    decisions = [d.times for each in found for d in each.decisions if d.same and d.winners[0] != UNDECIDED]
    spikes = [t for each in found for t in each.spikes]
    delays = [t for each in found for t in each.delays if np.isfinite(t[0])]
    named = {"decisions": decisions, "spikes of neurons": spikes, "level units": delays}
    return {name: _columns(pairs) for name, pairs in named.items()}


EXPERIMENT = compared(
    "choice-law",
    "selection and head's neurons under the full law against their transistors",
    beside,
    Beside,
    ("winner_take_all", "lso_neuron"),
    statements,
    times,
    first=FIRST,
)
