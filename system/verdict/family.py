"""Families of tests: where many rows of an experiment have a p, each is judged with the others in view.

Of n tests at 5 % one in twenty is significant by chance. Holm's procedure keeps the probability of a single
wrong one below the limit, whatever their dependence: the k-th smallest p (from 0) is taken n - k times, and
is no smaller than the one before it. Source: Holm, Scandinavian Journal of Statistics 6, 65 (1979).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from system.rule import Measured
from system.statement import Statement


def holm(p: Sequence[float]) -> F64:
    """Probabilities of a family of tests, adjusted for their number, float64[n] from 0 to 1."""
    known = np.asarray(p, dtype=np.float64)
    order, count = np.argsort(known, kind="stable"), known.size
    adjusted = np.empty(count)
    adjusted[order] = np.minimum(np.maximum.accumulate(known[order] * np.arange(count, 0, -1)), 1.0)
    return adjusted


def family(rows: Sequence[Statement]) -> tuple[Statement, ...]:
    """The same rows, those that are judged by a p with one that is adjusted for all of these together.

    A row without a p, or without a verdict, stays as it is.
    """
    tested = [k for k, row in enumerate(rows) if _tested(row)]
    if len(tested) < 2:
        return tuple(rows)
    adjusted = dict(zip(tested, holm([_p_of(rows[k]) for k in tested]).tolist(), strict=True))
    return tuple(
        _corrected(row, adjusted[k], len(tested)) if k in adjusted else row for k, row in enumerate(rows)
    )


def _tested(row: Statement) -> bool:
    return row.rule.by_p and isinstance(row.ours, Measured) and math.isfinite(row.ours.p)


def _p_of(row: Statement) -> float:
    return row.ours.p if isinstance(row.ours, Measured) else math.nan


def _corrected(row: Statement, p: float, count: int) -> Statement:
    if not isinstance(row.ours, Measured):
        return row
    shown = f"{row.shown}, Holm {p:.2g}" if isinstance(row.shown, str) else row.shown
    ours = replace(row.ours, shown=shown, p=p)
    return replace(row, ours=ours, rule=row.rule.beside(f"Holm over {count} rows"))
