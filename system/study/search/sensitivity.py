"""Gradient of every metric of a block by the standard normals behind its die, about the nominal die.

    g_i = (m(+h e_i) - m(-h e_i)) / 2 h,    h = 0.5 sigma (ours)

in the metric's unit a sigma; the log-sensitivity is the same of ln m. Half a sigma averages over the part of
the response that most dies use and stays above the solver's tolerance. The 2 n + 1 dies are rows of a table
of draws, so they are measured like any die of a study. A gradient is NaN where either die has no value.
What stands behind a bias is moved by its line (`system.study.search.direction`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from circuits.arrays import F64
from circuits.silicon.die import Die
from circuits.silicon.sampling import Sampling
from system.study.campaign import thread_count
from system.study.search.direction import Directions, directions
from system.study.statistics.contribution import kind
from system.study.table import Condition
from system.study.target import Measurement, Target

STEP = 0.5  # sigma, ours


@dataclass(frozen=True, slots=True, eq=False)
class Sensitivity:
    """Metrics of the nominal die, and of dies moved a step below and above it along directions.

    Attributes
    ----------
    labels : tuple of str
        Label of each draw.
    metrics : tuple of str
        Name of each metric.
    nominal : array
        Values of the nominal die, float64[metrics], in SI units.
    below : array
        Values with a die moved by -0.5 sigma, float64[directions, metrics], in SI units.
    above : array
        Values with a die moved by +0.5 sigma, float64[directions, metrics], in SI units.
    failures : tuple of str
        Reason of each measurement that failed, with what was moved.
    slopes : array or None
        Change of each metric with one sigma of a draw, float64[labels, metrics], in SI units, where that was
        not found by moving draws; None else.
    moved : Directions or None
        Along which dies were moved; None for a draw each.
    """

    labels: tuple[str, ...]
    metrics: tuple[str, ...]
    nominal: F64
    below: F64
    above: F64
    failures: tuple[str, ...]
    slopes: F64 | None = None
    moved: Directions | None = None

    @property
    def gradient(self) -> F64:
        """Change of each metric with one sigma of a draw, float64[labels, metrics]; NaN where not defined."""
        if self.slopes is not None:
            return self.slopes
        return self._by_label((self.above - self.below) / (2.0 * STEP))

    @property
    def log_gradient(self) -> F64:
        """Change of the logarithm of each metric with one sigma of a draw, float64[labels, metrics].

        It is NaN where a value is not defined or not positive.
        """
        if self.slopes is not None:
            return np.asarray(self.slopes / np.where(self.nominal > 0.0, self.nominal, np.nan))
        below, above = (np.where(x > 0.0, x, np.nan) for x in (self.below, self.above))
        return self._by_label((np.log(above) - np.log(below)) / (2.0 * STEP))

    def _by_label(self, along: F64) -> F64:
        return along if self.moved is None else self.moved.gradient(along)


def sensitivity(target: Target, die: Die, condition: Condition, threads: int | None = None) -> Sensitivity:
    """Measure the nominal die, and two dies for each direction.

    Parameters
    ----------
    target
        A block or chip.
    die
        Gives the lot, and which variation is on.
    condition
        Corner and temperature; a corner that is set leaves the shared process no draws.
    threads
        Number of threads that measure dies, all cores unless given.

    Raises
    ------
    ParameterError
        The target is a system, whose draws are not listed.
    """
    labels = varying_labels(target, condition.corner)
    along = directions(target, labels, condition)
    steps = STEP * along.rows
    rows = np.vstack([np.zeros((1, len(labels))), -steps, steps])
    found = measure_rows(target, die, condition, labels, rows, threads)
    values = np.array([m.values for m in found]).reshape(len(rows), len(target.quantities))
    moved = ("nominal", *(f"{label} {sign}{STEP:g} sigma" for sign in "-+" for label in along.names))
    failures = tuple(f"{name}: {m.reason}" for name, m in zip(moved, found, strict=True) if m.reason)
    below, above = np.split(values[1:], 2)
    metrics = tuple(q.name for q in target.quantities)
    return Sensitivity(labels, metrics, values[0], below, above, failures, moved=along)


def varying_labels(target: Target, corner: str) -> tuple[str, ...]:
    """List the labels of the draws that vary from die to die at a corner.

    A corner other than `random` sets the shared process, whose draws then do not vary.
    """
    return tuple(label for label in target.labels() if corner == "random" or kind(label) != "process")


def measure_rows(
    target: Target,
    die: Die,
    condition: Condition,
    labels: Sequence[str],
    rows: F64,
    threads: int | None = None,
    progress: Callable[[], None] | None = None,
) -> list[Measurement]:
    """Measure dies that are given by their draws, and give a measurement for each row.

    Parameters
    ----------
    target : a block or chip.
    die : gives the lot, which variation is on, and every draw that has no label.
    condition : corner and temperature.
    labels : label of each column of draws.
    rows : float64[n, labels], standard normals of each die.
    threads : number of threads, all cores unless given.
    progress : is called after each measurement.
    """
    table = Sampling("rows", 0, {label: k for k, label in enumerate(labels)}, rows)
    dies = [replace(die, number=number, sampling=table) for number in range(len(rows))]
    size = max(min(target.together, len(rows) // thread_count(threads)), 1)

    def measure(some: Sequence[Die]) -> list[Measurement]:
        found = target.measure_each(some, (condition,))
        if progress is not None:
            for _ in found:
                progress()
        return found

    with ThreadPoolExecutor(thread_count(threads)) as executor:
        parts = executor.map(measure, [dies[k : k + size] for k in range(0, len(dies), size)])
        return [each for part in parts for each in part]
