"""Measurements that a known process and die would have made, on the bench of the real ones.

What is not known is drawn from what is thought of it before, so that a fit of these measurements can be held
against the truth: where it is sure to 95 %, it should be right in 95 of 100 dies.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.extraction.coach.bench import Bench
from circuits.extraction.coach.conditions import Condition
from circuits.extraction.coach.joint import fit
from circuits.extraction.coach.models import MODELS, measured, unknowns_of
from circuits.extraction.coach.table import Table
from circuits.extraction.coach.unknown import Posterior, Theta, before
from circuits.silicon.die import Die, standard_normals
from circuits.silicon.process import Process

Data = Mapping[str, tuple[Condition, Table]]
_PLACE = (("synthetic", ()),)


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """A fit of measurements that known numbers made.

    die: number of the die. truth: the numbers, in the order of the posterior's unknowns, float64[n].
    posterior: what the fit says of them.
    """

    die: int
    truth: F64
    posterior: Posterior

    def score(self) -> F64:
        """How far each number is off, in its standard deviations, float64[n]."""
        return (self.posterior.mean - self.truth) / self.posterior.sd


def known_fit(
    data: Data, conditions: Mapping[str, Condition], base: Process, die: int, drawn: Collection[str] = ()
) -> Known:
    """Draw a die, make its measurements where the real ones were made, and fit them alone.

    Parameters
    ----------
    data
        The real measurements, of which what was set is taken.
    conditions
        What was set at all measurements.
    base
        The process about which numbers are drawn.
    die
        Number of the die, by which draws are keyed.
    drawn
        Unknowns that are drawn; all others are at their means. All unless given.

    Raises
    ------
    DataError
        The fit fails.
    """
    prior = before(unknowns_of(conditions, base))
    keyed, paths = Die("A", die), [((name, ()),) for name in prior.names]
    normals = standard_normals(keyed, _PLACE, paths, "unknown")
    moved = np.array([not drawn or name in drawn for name in prior.names])
    truth = prior.mean + np.where(moved, normals, 0.0) * prior.sd
    bench = Bench(Theta(dict(zip(prior.names, truth.tolist(), strict=True))), base)
    made = {name: (each[0], _made(bench, keyed, *each)) for name, each in data.items()}
    found = fit(measured(made), prior, base, rounds=1)
    return Known(die, truth, found.posterior)


def _made(bench: Bench, die: Die, condition: Condition, table: Table) -> Table:
    """What the bench would read, with its noise."""
    model = MODELS[condition.circuit]
    clean = model.predict(bench, condition, table)
    spread = model.noise(condition, clean)
    read = {}
    for column, value in clean.items():
        path = ((condition.name, ()), (column, (value.size,)))
        read[column] = value + spread[column] * standard_normals(die, _PLACE, [path], "reading")
    return Table({**table, **read})
