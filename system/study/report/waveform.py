"""Waveforms of a study's dies: the nominal one, the one nearest to the median, and the worst."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from circuits.errors import CircuitError
from circuits.silicon.die import NOMINAL, Die
from circuits.solver.transient import Result as Run
from circuits.solver.transient import simulate
from system.study.engine import dies_of
from system.study.report.result import Result
from system.study.report.worst import worst
from system.study.table import Condition, Table
from system.study.target import BlockTarget


def runs_of(
    result: Result, target: BlockTarget, condition: Condition, table: Table
) -> tuple[dict[str, Run], list[str]]:
    """Give the runs of the testbench by what die each is of, and a sentence for each die that has none.

    Parameters
    ----------
    result : the finished study.
    target : what it measured.
    condition : corner, temperature and trial of the samples.
    table : samples of that condition.
    """
    found: dict[str, Run] = {}
    failed = []
    for label, die in _dies(result, table).items():
        try:
            # NOMINAL has no lot's corner: a corner moves it too
            choice = target.choice_on(replace(die, corner=condition.corner), condition)  # type: ignore[arg-type]
            found[label] = simulate(choice.testbench(), choice.silicon)
        except CircuitError as error:
            failed.append(f"{label}: {error}.")
    return found, failed


def _dies(result: Result, table: Table) -> dict[str, Die]:
    """Dies to show by their labels, each once."""
    chosen = {"nominal die": NOMINAL}
    for word, row in (("median", _median(table)), ("worst", _worst(result, table))):
        if row is None:
            continue
        number = int(table.die[row])
        (die,) = dies_of(result.study, range(number, number + 1))
        if die not in chosen.values():
            chosen[f"die {number}, {word}: {table.outcome[row]}"] = die
    return chosen


def _median(table: Table) -> int | None:
    """Row of the sample nearest to the median of the first metric that varies."""
    for name in table.metrics:
        x = table.column(name)
        if np.isfinite(x).any() and np.ptp(x[np.isfinite(x)]) > 0.0:
            return int(np.nanargmin(np.abs(np.where(np.isfinite(x), x, np.nan) - np.nanmedian(x))))
    return None


def _worst(result: Result, table: Table) -> int | None:
    words = [q.name for q in result.quantities if q.yes_no]
    first = worst(table, result.specifications, 1, words)
    return first[0].row if first else None
