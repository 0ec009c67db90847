"""One least-squares fit of all unknowns to all measurements, through the solver itself.

Minimised is `sum((y - f(theta))^2 / sigma^2) + sum((theta - mean)^2 / sd^2)`. A measurement's derivatives
are differences by those unknowns alone that its model reads. How large the readings' noise is, a factor a
measurement and column, follows from the residuals, with the share of its points that the fit uses up taken
off.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, Bools
from circuits.catalogue import later
from circuits.errors import CircuitError, DataError
from circuits.extraction.coach.bench import Bench
from circuits.extraction.coach.conditions import Condition
from circuits.extraction.coach.table import Table
from circuits.extraction.coach.unknown import Posterior, Theta
from circuits.silicon.process import Process

optimise = later("scipy.optimize")

_STEP = 3e-2  # of an unknown's spread before the fit, for derivatives; ours
_ROUNDS = 3  # of the factor of the noise
_EVALUATIONS = 25  # of the residuals in one round
_SLACK = 0.5  # of the cost, by a unit of an unknown, that a fit may leave; ours
_FEWEST = 5  # residuals that say how large a noise is; ours
_QUIETEST = 0.4  # factor of a noise that no fit goes below, as no model is that good; ours
_FAR = 50.0  # residual where the solver finds nothing


@dataclass(frozen=True, slots=True)
class Model:
    """What predicts the readings of a circuit's measurements.

    predict: `predict(bench, condition, table)` returns readings by column, without noise. usable:
    `usable(condition, table)` returns which points may be fitted, by column. noise: `noise(condition,
    predicted)` returns the standard deviation of readings, by column.
    """

    predict: Callable[[Bench, Condition, Table], dict[str, F64]]
    usable: Callable[[Condition, Table], dict[str, Bools]]
    noise: Callable[[Condition, Mapping[str, F64]], dict[str, F64]]


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """A measurement that is fitted.

    condition: what was set. table: what was set and read. model: what predicts it. kept: which points are
    fitted, bool[points] by column.
    """

    condition: Condition
    table: Table
    model: Model
    kept: Mapping[str, Bools]


class Block(NamedTuple):
    """A column of a measurement in a fit.

    Attributes
    ----------
    residual : array
        Readings less the fit over their noise, of the points that were fitted, float64[fitted].
    jacobian : array
        Their derivatives by the unknowns in units of their spread before, float64[fitted, unknowns].
    noise : array
        Standard deviation of all readings, float64[points], in their unit.
    """

    residual: F64
    jacobian: F64
    noise: F64


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A fit.

    posterior: what is known after it. blocks: what was fitted, by measurement and column. factors: factor of
    the noise by measurement and column.
    """

    posterior: Posterior
    blocks: Mapping[tuple[str, str], Block]
    factors: Mapping[tuple[str, str], float]


class _Problem:
    """Residuals and their derivatives in units of the unknowns' spreads."""

    def __init__(self, measured: Iterable[Measured], prior: Posterior, base: Process) -> None:
        """Hold what is fitted; factors of the noise begin at 1."""
        self.measured, self.prior, self.base = tuple(measured), prior, base
        self.centre, self.sd = prior.mean, prior.sd
        self.factors = {(m.condition.name, c): 1.0 for m in self.measured for c in m.kept}
        self.scale: dict[tuple[str, str], F64] = {}

    def theta(self, x: F64) -> dict[str, float]:
        return dict(zip(self.prior.names, (self.centre + self.sd * x).tolist(), strict=True))

    def one(self, m: Measured, values: Mapping[str, float]) -> tuple[F64, set[str]]:
        """Residuals of a measurement, and what its model read; NaN where the solver finds nothing."""
        theta = Theta(values)
        try:
            found = m.model.predict(Bench(theta, self.base), m.condition, m.table)
        except CircuitError:
            return np.full(sum(int(k.sum()) for k in m.kept.values()), np.nan), theta.read
        parts = []
        for column, kept in m.kept.items():
            key = m.condition.name, column
            if key not in self.scale:  # the noise's size is that at the beginning of a round
                self.scale[key] = (
                    self.factors[key] * m.model.noise(m.condition, {column: found[column]})[column]
                )
            parts.append(((m.table[column] - found[column]) / self.scale[key])[kept])
        return np.concatenate(parts), theta.read

    def residuals(self, x: F64) -> F64:
        parts = [self.one(m, self.theta(x))[0] for m in self.measured]
        return np.asarray(np.nan_to_num(np.concatenate([*parts, x]), nan=_FAR))

    def jacobian(self, x: F64) -> F64:
        blocks = [self.block(m, x) for m in self.measured]
        return np.concatenate([*blocks, np.eye(x.size)])

    def block(self, m: Measured, x: F64) -> F64:
        """Derivatives of a measurement's residuals, float64[points, unknowns]."""
        base, read = self.one(m, self.theta(x))
        found = np.zeros((base.size, x.size))
        for k, name in enumerate(self.prior.names):
            if name in read:
                moved = x.copy()
                moved[k] += _STEP
                up = self.one(m, self.theta(moved))[0]
                found[:, k] = (up - base) / _STEP
        return np.asarray(np.nan_to_num(found))


def fit(
    measured: Iterable[Measured],
    prior: Posterior,
    base: Process,
    start: Mapping[str, float] | None = None,
    factors: Mapping[tuple[str, str], float] | None = None,
    rounds: int = _ROUNDS,
) -> Fit:
    """Fit all unknowns to measurements.

    Parameters
    ----------
    measured
        The measurements with the points that are fitted.
    prior
        What is known before.
    base
        What is not fitted of the process.
    start
        Values to begin with, by name; the prior's means unless given.
    factors
        Factors of the noise to begin with.
    rounds
        How often the fit is made with the factors of the one before.

    Raises
    ------
    DataError
        There are fewer points than unknowns of the process, or the fit does not converge.
    """
    problem = _Problem(measured, prior, base)
    problem.factors |= {key: value for key, value in (factors or {}).items() if key in problem.factors}
    _enough(problem)
    given = {**prior.values(), **(start or {})}
    x = (np.array([given[name] for name in prior.names]) - problem.centre) / problem.sd
    for _ in range(rounds - 1):
        x, residual, jacobian = _solved(problem, x)
        _rescale(problem, residual, jacobian)
    x, residual, jacobian = _solved(problem, x)
    covariance = np.linalg.inv(jacobian.T @ jacobian) * np.outer(problem.sd, problem.sd)
    posterior = Posterior(prior.unknowns, problem.centre + problem.sd * x, covariance)
    blocks = {
        key: Block(residual[rows], jacobian[rows], problem.scale[key]) for key, rows in _slices(problem)
    }
    return Fit(posterior, blocks, dict(problem.factors))


def _solved(problem: _Problem, x: F64) -> tuple[F64, F64, F64]:
    """Unknowns at the minimum, residuals and their derivatives there."""
    problem.scale.clear()
    solved = optimise.least_squares(
        problem.residuals, x, jac=problem.jacobian, max_nfev=_EVALUATIONS, xtol=1e-4, ftol=3e-4
    )
    files = ", ".join(m.condition.file for m in problem.measured)
    if solved.status < 0 or not np.isfinite(solved.fun).all():
        raise DataError(f"{files}: no minimum ({solved.message}); leave out what does not belong here")
    if solved.status == 0 and solved.optimality > _SLACK * solved.cost:
        raise DataError(f"{files}: not converged in {_EVALUATIONS} steps; leave out what does not belong")
    return solved.x, solved.fun, solved.jac


def _enough(problem: _Problem) -> None:
    process = [u for u in problem.prior.unknowns if u.kind == "process"]
    points = sum(int(kept.sum()) for m in problem.measured for kept in m.kept.values())
    if points <= len(process):
        names = ", ".join(m.condition.file for m in problem.measured) or "no file"
        raise DataError(
            f"{names}: {points} points for {len(process)} numbers of the process, must be more; measure more"
        )


def _slices(problem: _Problem) -> list[tuple[tuple[str, str], slice]]:
    found, begin = [], 0
    for m in problem.measured:
        for column, kept in m.kept.items():
            end = begin + int(kept.sum())
            found.append(((m.condition.name, column), slice(begin, end)))
            begin = end
    return found


def _rescale(problem: _Problem, residual: F64, jacobian: F64) -> None:
    """Make the noise of each column what its residuals say."""
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    used = np.einsum("ij,jk,ik->i", jacobian, covariance, jacobian)
    for key, rows in _slices(problem):
        if rows.stop - rows.start < _FEWEST:
            continue
        left = max(rows.stop - rows.start - float(used[rows].sum()), 1.0)
        spread = float(np.sqrt((residual[rows] ** 2).sum() / left))
        problem.factors[key] = max(problem.factors[key] * spread, _QUIETEST)
