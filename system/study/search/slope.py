"""A metric of a block and its gradient by the standard normals behind a die, about any die.

A die is a row z of draws, as in `system.study.search.sensitivity`. The gradient is that of one run backwards
where the metric has one (`circuits.gradient`), else of two dies a draw.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from circuits.arrays import F64
from circuits.blocks.metric import Metric
from circuits.errors import ParameterError
from circuits.gradient.every import every_gradient
from circuits.lowering.kernel import Machine, on_die
from circuits.silicon.die import Die
from circuits.silicon.sampling import Sampling
from system.study.metrics.gradient import measure_of_metric, measured_by
from system.study.metrics.metric import measurements
from system.study.search.direction import directions
from system.study.search.sensitivity import STEP, measure_rows, varying_labels
from system.study.table import Condition
from system.study.target import BlockTarget

BACKWARDS = 3  # runs of the testbench that one run and one run backwards count as; ours
EDGES = 2  # of a search, each of which has such a pair


@dataclass(frozen=True, slots=True, eq=False)
class Slope:
    """A metric about a die.

    value : its value, in SI units; NaN where it is not defined.
    by : its change with one sigma of each draw, float64[labels].
    note : why it is not smooth there; empty else.
    """

    value: float
    by: F64
    note: str


class Slopes:
    """Gives a metric of a block with its gradient at dies.

    Attributes
    ----------
    labels : tuple of str
        Label of each draw.
    sigma : array
        What one sigma of each draw is, float64[labels], in V for thresholds and relative else; NaN where
        nothing tells.
    runs : int
        Runs of the testbench that were made so far, one run backwards counted as `BACKWARDS`.
    """

    def __init__(
        self, target: BlockTarget, die: Die, condition: Condition, metric: str, threads: int | None = None
    ) -> None:
        """Raise `ParameterError` for a metric that has no value."""
        self.target, self.condition, self.threads = target, condition, threads
        self.die = replace(die, number=0, corner=condition.corner)  # type: ignore[arg-type]  # was checked
        self.metric, self.labels, self.runs = metric, varying_labels(target, condition.corner), 0
        self.sigma = _sigma(target, self.labels)
        self._column = [q.name for q in target.quantities].index(metric)
        self._differentiable = self._is_differentiable()
        self._nominal: Slope | None = None

    def _is_differentiable(self) -> bool:
        """Whether runs backwards differentiate the metric: one that is read from one run, or has edges."""
        if self._asked.edges is not None:
            return True
        try:
            measured_by(self._asked)
        except ParameterError:
            return False
        return True

    @property
    def _asked(self) -> Metric:
        (asked,) = (m for m in self.target.metrics if m.name == self.metric)
        return asked

    @property
    def by_gradient(self) -> bool:
        """Whether the gradient is that of one run backwards."""
        return self._differentiable

    def at(self, z: F64) -> Slope:
        """Give the metric and its gradient on the die with the draws `z`, float64[labels]."""
        if self._nominal is not None and not z.any():
            return self._nominal
        found = self._by_run(z) if self._differentiable else None
        if found is None:
            self._differentiable = False
            found = self._by_dies(z)
        if not z.any():
            self._nominal = found
        return found

    def values(self, rows: F64) -> F64:
        """Measure dies with the draws float64[n, labels]; float64[n] in SI units, NaN where not defined."""
        return np.asarray(self.all_values(rows)[:, self._column])

    def all_values(self, rows: F64) -> F64:
        """Measure all metrics of the target on the same dies; float64[n, metrics]."""
        self.runs += len(rows)
        found = measure_rows(self.target, self.die, self.condition, self.labels, rows, self.threads)
        values = np.array([m.values for m in found], dtype=np.float64)
        return values.reshape(len(rows), len(self.target.quantities))

    def _machine(self, z: F64) -> Machine:
        """The testbench of the metric on the die with some draws."""
        shared = [m.measure for m in measurements(self.target.metrics)]
        machine = self.target.machines(self.condition.temperature_c)[shared.index(self._asked.measure)]
        columns = {label: k for k, label in enumerate(self.labels)}
        return on_die(machine, replace(self.die, sampling=Sampling("rows", 0, columns, z[None])))

    def _by_run(self, z: F64) -> Slope | None:
        """By runs backwards; None where the metric, or some draw, has no gradient of that kind."""
        machine = self._machine(z)
        found = every_gradient(machine, (measure_of_metric(self._asked, lambda: machine),))
        self.runs += BACKWARDS if self._asked.edges is None else 1 + EDGES * BACKWARDS
        if not found.labels:
            return Slope(np.nan, np.full(len(self.labels), np.nan), found.notes[0])
        known = {label: k for k, label in enumerate(found.labels)}
        if not all(label in known for label in self.labels):
            return None
        columns = [known[label] for label in self.labels]
        if np.isfinite(found.values[0]) and not np.isfinite(found.by[0, columns]).any():
            return None
        return Slope(float(found.values[0]), found.by[0, columns] * found.sigma[columns], found.notes[0])

    def _by_dies(self, z: F64) -> Slope:
        along = directions(self.target, self.labels, self.condition)
        steps = STEP * along.rows
        values = self.values(np.vstack([z, z - steps, z + steps]))
        below, above = np.split(values[1:], 2)
        return Slope(float(values[0]), along.gradient((above - below) / (2.0 * STEP)), "")


def _sigma(target: BlockTarget, labels: Sequence[str]) -> F64:
    """What one sigma of each draw is."""
    sigma = dict(zip(target.labels(), target.sigma(), strict=True))
    return np.array([sigma[label] for label in labels])
