"""The latency chip under the full law, held against the transistors of its parts on unseen dies.

No figure of a paper. Dies A/1000 to A/1083 with mismatch and process variation, at -10, 27 and 60 degC, with
fixed gates and with the bias generator: what the solver makes of the chip's parts at their places under the
full law of their process, and what the behavioural model does. Compared are whether a unit's detector spikes
just inside and outside its window, and times: of a tap, of an integrating neuron with two inputs, of INH
after a reset and after an event, of a first-layer cell with a charge and an inhibition. The margins are those
that every model of a chip is held to. No value is fitted.

Told beside, and not judged: units whose INH has later periods that are shorter than its first, because its
spike leaves part of the membrane's charge. The model's are all the first; a unit answers alike as long as
they are shorter than the block that each spike begins.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from chips.latency.chip import LatencyChip
from chips.latency.errors import decisions_at, times_at, usual_design
from chips.latency.kernel import MARGIN
from chips.latency.model import usual_biases
from circuits.arrays import F64
from system.papers.checks.beside import ALIKE, NEAR, TIED, TIME_SHARE, Condition, Times, compared, judged
from system.rule import unjudged
from system.statement import Statement

TIMES = ("tap", "integrating", "release", "hold", "race")


@dataclass(frozen=True, slots=True)
class Beside:
    """Parts of a chip on both levels, the model's first.

    times: name and both times (s) of each quantity; detected: whether a detector spiked, at each lag;
    undecided: whether the model is too near a tie to say.
    """

    temperature_c: float
    times: tuple[tuple[str, float, float], ...]
    detected: tuple[tuple[bool, bool], ...]
    undecided: bool


def beside(at: Condition) -> Beside:
    """Return both levels of a memory and of a unit, which follow from the die's number."""
    design = usual_design()
    chip = LatencyChip(design, usual_biases(design, at.kind, at.silicon.process), at.silicon)
    p, u = at.die % design.paths, at.die % design.taps
    return Beside(
        at.temperature_c,
        tuple(times_at(chip, p, u)),
        tuple(decisions_at(chip, p, u)),
        _undecided(chip, p, u),
    )


def _undecided(chip: LatencyChip, p: int, u: int) -> bool:
    """Whether what one input gives, or two, is nearly what the detector takes away."""
    tap, _, spoken = chip.lumped.seen[p, u]
    return any(abs(math.log(x / chip.lumped.taken[p, u])) < MARGIN for x in (tap, tap + spoken))


def statements(found: list[Beside]) -> tuple[Statement, ...]:
    """Return how far the model is off, a row a margin."""
    decided = [pair for b in found if not b.undecided for pair in b.detected]
    same = sum(ours == theirs for ours, theirs in decided) / len(decided)
    return judged([
        ("detection_share", same, ALIKE),
        ("undecided_share", sum(b.undecided for b in found) / len(found), TIED),
        *((f"{name}_error_max", float(np.abs(errors(found, name)).max()), NEAR)
          for name in TIMES),
        ("short_period_share", float((errors(found, "tonic") > TIME_SHARE).mean()),
         unjudged("units whose later periods are shorter than the first")),
    ])  # fmt: skip


def errors(found: list[Beside], name: str) -> F64:
    """Return the relative errors of a quantity, float64[parts]."""
    theirs, ours = pairs_of(found, name)
    return ours / theirs - 1.0


def pairs_of(found: list[Beside], name: str) -> tuple[F64, F64]:
    """Return a quantity of the circuit and of the model, s, float64[parts] each."""
    theirs, ours = np.array([pair for b in found for own, *pair in b.times if own == name])[:, ::-1].T
    return theirs, ours


def times(found: list[Beside]) -> Times:
    """Return each time by its name."""
    return {name: pairs_of(found, name) for name in TIMES}


EXPERIMENT = compared(
    "latency-law",
    "the latency chip under the full law against its transistors",
    beside,
    Beside,
    ("latency_chip",),
    statements,
    times,
)
