"""Calibration of ROLLS chips: eight populations at 20, 50 and 100 Hz on 50 dies, and what temperature does.

No figure of a paper. Compared with their targets are the mean rates of the populations, each kind of bias for
itself. Codes of three weight biases are searched on each die at 27 degC and at most four neurons a population
are dropped (`chips.rolls.calibration`, `chips.rolls.setups.populations`); the rates are then measured in
another run, twice as long and with the events at another phase. Rule: mean rate within 10 % of the target for
95 % of the pairs of population and die, for each kind of bias. Dies from 1000 on. Then ten of the chips run
at other temperatures with the codes found at 27 degC: by how much the mean rates move is reported, without a
rule.

A first version brought means and not middles of populations to the target: 96.5 % of the pairs were within
10 % with ideal biases, and 94.8 % with fixed gates, on the same dies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import cast

import numpy as np
from matplotlib.figure import Figure

from chips.rolls.calibration import calibrate
from chips.rolls.setups.populations import population_errors, populations_task
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS
from system.rule import at_least, unjudged
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered

FIRST_DIE, DIES, DRIFTING = 1000, 50, 10
KINDS: tuple[BiasKind, ...] = ("ideal", "gate")
TEMPERATURES = (17.0, 22.0, 27.0, 32.0, 37.0)  # degC
WITHIN, SHARE = 0.1, 0.95


@dataclass(frozen=True, slots=True)
class Calibrated:
    """Errors of the populations of one die, or of all dies of one kind of bias.

    errors: at 27 degC, float64[8], of all dies float64[dies, 8]. drift: at `TEMPERATURES`, float64[degC, 8],
    none where it was not asked for; of the dies that have some float64[dies, degC, 8]. dropped: neurons that
    were left out.
    """

    errors: F64
    drift: F64
    dropped: int


@dataclass(frozen=True, slots=True)
class Calibrations:
    """Calibrates the die of a key's number with the kind of biases of its condition.

    drifting: how many of the first dies run at other temperatures too.
    """

    drifting: int

    def __call__(self, key: Numbered) -> Calibrated:
        """Calibrate once."""
        task, kind = populations_task(), cast(BiasKind, key.condition)
        silicon = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=key.number))
        calibration = calibrate(task, silicon, kind)
        dropped = sum(len(gone) for gone in calibration.blacklist.values())
        errors = np.array(list(population_errors(task, calibration, silicon, kind).values()))
        if key.number >= FIRST_DIE + self.drifting:
            return Calibrated(errors, np.empty(0), dropped)
        moved = [replace(silicon, temperature_c=t) for t in TEMPERATURES]
        drift = [list(population_errors(task, calibration, s, kind, 1.0).values()) for s in moved]
        return Calibrated(errors, np.array(drift), dropped)


def reproduce(
    progress: Progress, execution: Execution = ALONE, dies: int = DIES, drifting: int = DRIFTING
) -> Report:
    """Calibrate every die with both kinds of bias."""
    keys = [Numbered(kind, FIRST_DIE + k) for kind in KINDS for k in range(dies)]
    numbers = (version("noctule"), populations_task(), TEMPERATURES, drifting)
    campaign = Campaign(EXPERIMENT.name, Calibrations(drifting), Numbered, Calibrated, numbers)
    by_kind = execution.by_condition(campaign, keys, progress)
    found = {kind: summed(each) for kind, each in by_kind.items()}
    return Report(rows(found), lambda figure: _draw(found, figure), _notes(found))


def summed(dies: Sequence[Calibrated]) -> Calibrated:
    """Of one kind of bias."""
    drift = np.array([each.drift for each in dies if each.drift.size])
    return Calibrated(np.array([each.errors for each in dies]), drift, sum(each.dropped for each in dies))


def rows(found: Mapping[str, Calibrated]) -> tuple[Statement, ...]:
    """Make the statements about populations within 10 %, and about rates at other temperatures."""
    made = []
    for kind, f in found.items():
        share = float(np.mean(np.abs(f.errors) <= WITHIN))
        name = f"{kind}: share of population-die pairs within 10 %"
        made.append(Statement(name, SHARE, share, at_least(SHARE)))
        for k, t in enumerate(TEMPERATURES):
            if t != 27.0 and f.drift.size:
                ratio = float(np.mean(1.0 + f.drift[:, k]))
                name = f"{kind}: mean rate at {t:g} degC over its target"
                made.append(Statement(name, None, ratio, unjudged("reported")))
    return tuple(made)


def _notes(found: Mapping[str, Calibrated]) -> tuple[str, ...]:
    return tuple(
        f"{kind}: {f.dropped / f.errors.size:.2f} neurons of 16 dropped a population; worst"
        f" {100 * np.abs(f.errors).max():.0f} %, median {100 * np.median(np.abs(f.errors)):.1f} % off"
        for kind, f in found.items()
    )


def _draw(found: Mapping[str, Calibrated], figure: Figure) -> None:
    left, right = figure.subplots(1, 2)
    for k, (kind, f) in enumerate(found.items()):
        left.hist(
            100 * f.errors.ravel(), bins=np.arange(-60.5, 61.0, 1.0).tolist(), color=COLOURS[k], alpha=0.6,
            label=kind,
        )  # fmt: skip
        if f.drift.size:
            mean = 1.0 + f.drift.mean(axis=2)
            right.plot(TEMPERATURES, mean.T, color=COLOURS[k], alpha=0.3, linewidth=0.8)
            right.plot(TEMPERATURES, mean.mean(axis=0), color=COLOURS[k], label=kind)
    left.set(xlabel="mean rate less its target, %", ylabel="populations", yscale="log")
    right.set(xlabel="temperature, degC", ylabel="mean rate over its target", yscale="log")
    left.legend()


EXPERIMENT = Experiment(
    "rolls-calibration",
    "ROLLS: eight populations at three rates on 50 dies, and their drift",
    reproduce,
    {"dies": DIES},
)
