"""A neural field on ROLLS: of two inputs 20 % apart the stronger gets the only bump, on 19 of 20 dies.

No figure of a paper. Compared is which of two inputs the field on a chip chooses, over 20 dies. It has 128
neurons, each exciting itself and six neighbours on either side and inhibiting the rest by one level,
driven by Poisson events around neurons 32 and 96; the stronger side alternates from die to die. Each die is
calibrated first: one bias code, and at most two of every eight neurons dropped
(`chips.rolls.setups.populations`, numbers chosen on dies below 40). Rule: late in the run the mean rate
around the weaker input, and elsewhere, is a tenth of that around the stronger one at most. Dies from 1000 on,
both kinds of bias.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import cast

import numpy as np
from matplotlib.figure import Figure

from chips.rolls.calibration import calibrate
from chips.rolls.setups.populations import Bump, field_bump, field_task
from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS
from system.rule import at_least
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered
from system.verdict.null import nulls_of

FIRST_DIE, DIES = 1000, 20
KINDS: tuple[BiasKind, ...] = ("ideal", "gate")
SHARE = 0.95
PEAK = 50.0  # Hz, of a null's bump where ours has none; ours
NULLS = ("always chooses the same side", "tosses a coin", "chooses nothing")


def reproduce(progress: Progress, execution: Execution = ALONE, dies: int = DIES) -> Report:
    """Calibrate every die and let the field decide."""
    keys = [Numbered(kind, FIRST_DIE + k) for kind in KINDS for k in range(dies)]
    campaign = Campaign(EXPERIMENT.name, decide, Numbered, Bump, (version("noctule"), field_task()))
    found = execution.by_condition(campaign, keys, progress)
    nulls = nulls_of(rows, _nulls(found))
    return Report(rows(found), lambda figure: _draw(found, figure), _notes(found), nulls)


def _nulls(found: Mapping[str, Sequence[Bump]]) -> dict[str, dict[str, list[Bump]]]:
    """Fields with one bump on a side that the inputs do not decide, and one with none."""
    random = np.random.default_rng(FIRST_DIE)
    chosen: dict[str, Callable[[int], tuple[float, float]]] = {
        NULLS[0]: lambda k: (1.0, 0.0) if (FIRST_DIE + k) % 2 else (0.0, 1.0),
        NULLS[1]: lambda _: (1.0, 0.0) if random.integers(2) else (0.0, 1.0),
        NULLS[2]: lambda _: (0.0, 0.0),
    }
    return {
        name: {kind: [_bump(b, *sides(k)) for k, b in enumerate(bumps)] for kind, bumps in found.items()}
        for name, sides in chosen.items()
    }


def _bump(bump: Bump, stronger: float, weaker: float) -> Bump:
    """A field with the rate of a bump on these shares of its sides, and no spike elsewhere."""
    rate = max(bump.rates.max(), PEAK)
    return replace(bump, stronger=rate * stronger, weaker=rate * weaker, elsewhere=0.0)


def decide(key: Numbered) -> Bump:
    """Let the field of one die decide; the seed of its events is the die's number."""
    die, kind = key.number, cast(BiasKind, key.condition)
    silicon = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=die))
    return field_bump(calibrate(field_task(), silicon, kind), silicon, kind, die % 2, die)


def rows(found: Mapping[str, Sequence[Bump]]) -> tuple[Statement, ...]:
    """Make a statement a kind of bias about the share of dies with one bump at the stronger input."""
    made = []
    for kind, bumps in found.items():
        share = sum(b.right for b in bumps) / len(bumps)
        name = f"{kind}: share of dies with one bump, at the stronger input"
        made.append(Statement(name, SHARE, share, at_least(SHARE, "at least {limit:g}, 19 of 20")))
    return tuple(made)


def _notes(found: Mapping[str, Sequence[Bump]]) -> tuple[str, ...]:
    wrong = {
        kind: [FIRST_DIE + k for k, b in enumerate(bumps) if not b.right] for kind, bumps in found.items()
    }
    return tuple(f"{kind}: wrong on dies {w or 'none'}" for kind, w in wrong.items())


def _draw(found: Mapping[str, Sequence[Bump]], figure: Figure) -> None:
    axes = figure.subplots(1, len(found), sharey=True, squeeze=False)[0]
    for ax, (kind, bumps) in zip(axes, found.items(), strict=True):
        for k, bump in enumerate(bumps):
            ax.plot(bump.rates, color=COLOURS[(FIRST_DIE + k) % 2], alpha=0.4, linewidth=0.8)
        ax.set(title=f"{kind} biases", xlabel="neuron; blue: 32 stronger, orange: 96")
    axes[0].set_ylabel("rate late in the run, Hz")


EXPERIMENT = Experiment(
    "rolls-field",
    "ROLLS: a neural field chooses the stronger of two inputs",
    reproduce,
    {"dies": DIES},
    NULLS,
)
