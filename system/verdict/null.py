"""Nulls: what a robot that knows nothing, or data that mean nothing, scores by the rules of an experiment.

A rule says little that holds for a robot that never moves as well. So an experiment with a behaviour makes
its rows of null robots too, and one with a curve makes them of constant and of shuffled data, by the very
functions that make its own rows: `nulls_of(rows, {"never moves": data})`. `scores` counts how many of the
rows that have a verdict hold.

Ours is above a null where it holds more of the rows than chance makes likely: an exact sign test (McNemar
1947) over the rows that hold for one of both alone, one-sided. Ours must be above every null, so that no
correction for their number is due. With fewer than five such rows the test can find nothing at 5 %, and then
an experiment has to say so.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from circuits.arrays import I64
from circuits.catalogue import later
from circuits.errors import ParameterError
from system.rule import Measured
from system.statement import Statement

stats = later("scipy.stats")

LIMIT = 0.05  # of the probability that ours is above a null by chance; ours
SHUFFLES = 99  # drawings of shuffled data, of which the one with the median score stands for all; ours
OURS, PAPER = "ours", "paper"

Data = TypeVar("Data")
Rows = tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Null:
    """A null and what the experiment's own rules say of it.

    name : what it does, as `never moves`.
    rows : the experiment's rows, made of its data.
    """

    name: str
    rows: Rows


@dataclass(frozen=True, slots=True)
class Score:
    """How many rows hold.

    name : of what: `ours`, the name of a null, or `paper` for the paper's own values.
    held : rows that hold.
    judged : rows with a verdict; of the paper those for which it gives a value that can be judged.
    p : probability by the sign test that ours holds so many more by chance; None for ours and the paper.
    """

    name: str
    held: int
    judged: int
    p: float | None = None

    @property
    def beaten(self) -> bool:
        """Whether ours is above it."""
        return self.p is not None and self.p < LIMIT

    def __str__(self) -> str:
        """Write it as `never moves 3 of 5 (p 0.25)`."""
        said = f"{self.name} {self.held} of {self.judged}"
        return said if self.p is None else f"{said} (p {self.p:.2g})"


def nulls_of(rows: Callable[[Data], Rows], data: Mapping[str, Data]) -> tuple[Null, ...]:
    """Nulls by their names, of their data; `rows` is what makes the experiment's own rows."""
    return tuple(Null(name, rows(each)) for name, each in data.items())


def shuffled(name: str, rows: Callable[[Data], Rows], make: Callable[[I64], Data], count: int) -> Null:
    """The null of data in an order that means nothing.

    Parameters
    ----------
    name
        Of the null.
    rows
        What makes the experiment's own rows.
    make
        Gives the data with what belongs to place `order[k]` at place k; `order` is an int64[count].
    count
        How many values are put into another order.
    """
    random = np.random.default_rng(0)
    tried = [rows(make(random.permutation(count))) for _ in range(SHUFFLES)]
    return Null(name, sorted(tried, key=lambda each: sum(row.agrees is True for row in each))[SHUFFLES // 2])


def scores(ours: Sequence[Statement], nulls: Sequence[Null], paper: Sequence[Statement]) -> tuple[Score, ...]:
    """The score of ours, of every null, and of the paper where it gives values that can be judged.

    Raises `ParameterError` where a null or the paper lacks a row of ours.

    Parameters
    ----------
    ours
        The experiment's rows.
    nulls
        Its nulls.
    paper
        The rows made of the paper's own values, in the unit and form of ours; without them they are judged
        where a row has both as plain values.
    """
    mine = [row.agrees for row in ours if row.agrees is not None]
    found = [Score(OURS, sum(mine), len(mine))]
    for null in nulls:
        theirs = [bool(said) for said in _verdicts(null.name, ours, null.rows)]
        found.append(Score(null.name, sum(theirs), len(theirs), above_p(mine, theirs)))
    if paper:
        known = [said for said in _verdicts(PAPER, ours, paper) if said is not None]
    else:
        known = [said for row in ours if (said := _paper_holds(row)) is not None]
    return (*found, Score(PAPER, sum(known), len(known))) if known else tuple(found)


def above_p(ours: Sequence[bool], theirs: Sequence[bool]) -> float:
    """One-sided p of the exact sign test that `ours` holds in more places than `theirs`; 1 if none differ."""
    gained = sum(a and not b for a, b in zip(ours, theirs, strict=True))
    lost = sum(b and not a for a, b in zip(ours, theirs, strict=True))
    return (
        float(stats.binomtest(gained, gained + lost, alternative="greater").pvalue) if gained + lost else 1.0
    )


def warning(found: Sequence[Score]) -> str:
    """Tell above which nulls ours is not; empty where it is above all."""
    alike = [score for score in found if score.p is not None and not score.beaten]
    if not alike:
        return ""
    few = " Fewer than five rows can show nothing by this test." if found[0].judged < 5 else ""
    return (
        f"These rows show nothing above: {', '.join(map(str, alike))}; ours holds {found[0].held} of"
        f" {found[0].judged}.{few}"
    )


def _verdicts(name: str, ours: Sequence[Statement], rows: Sequence[Statement]) -> list[bool | None]:
    """What other rows say where ours have a verdict, matched by their names."""
    by_name = {row.name: row.agrees for row in rows}
    judged = [row.name for row in ours if row.agrees is not None]
    missing = [each for each in judged if each not in by_name]
    if missing:
        raise ParameterError(f"{name}: no row {missing[0]}, must have every row of ours; make them alike")
    return [by_name[each] for each in judged]


def _paper_holds(row: Statement) -> bool | None:
    """Whether the paper's own value agrees by a row's rule; None where it cannot be judged as ours is."""
    ours = row.ours
    if row.agrees is None or row.paper is None or isinstance(ours, Measured):
        return None
    if isinstance(row.paper, str) is not isinstance(ours, str):
        return None
    return row.rule.holds(row.paper, row.paper)
