"""Contributions to the variance of a metric in a finished study, at each condition and over its temperatures.

The standard normals z are the draws of the study's own dies. The response y is the metric, or its logarithm
where all its values are positive. The gradient about the nominal die is that of one run backwards (`adjoint`)
or of two dies a draw (`sensitivity`). Where that is not defined, or explains too little, a regression takes
its place (`contribution`).

Over several temperatures of a corner, T is one more factor, standardised over the samples. Its gradient is
the slope of the nominal die's metric on it, that of a draw the mean over the temperatures.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError, unknown_name
from system.options.block import read_die
from system.study.engine import dies_of
from system.study.manifest import Study
from system.study.search.adjoint import adjoint_sensitivity
from system.study.search.sensitivity import Sensitivity, sensitivity, varying_labels
from system.study.statistics.contribution import (
    Contributions,
    Key,
    VarianceShare,
    block,
    contributions,
    device,
    kind,
    parameter,
    percentages,
    standardise,
)
from system.study.statistics.regression import SAMPLES_A_TERM, enough
from system.study.table import Condition, Table, place_text, select
from system.study.target import BlockTarget, Target

Gradients = Literal["adjoint", "dies"]
FEWEST = 20  # defined samples, ours: R^2 of fewer is known to no better than +-0.1 or so
TEMPERATURE = "temperature"
BY: Mapping[str, Key] = MappingProxyType(
    {"device": device, "parameter": parameter, "block": block, "process": kind}
)


@dataclass(frozen=True, slots=True, eq=False)
class Breakdown:
    """Contributions to the variance of a metric at one corner.

    metric : name of the metric.
    corner : process corner.
    temperatures_c : temperatures of the samples, degC; there are several where temperature contributes.
    logarithm : whether the contributions are to the logarithm of the metric.
    samples : number of all samples; that of the defined ones is `found.samples`.
    found : shares of the variance.
    notes : warnings of gradients that are not defined, and of measurements that failed.
    """

    metric: str
    corner: str
    temperatures_c: tuple[float, ...]
    logarithm: bool
    samples: int
    found: Contributions
    notes: tuple[str, ...]

    @property
    def where(self) -> str:
        """The condition of the contributions in words, as `27 degC, corner ss`."""
        return place_text(self.corner, *self.temperatures_c)


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """Samples of a condition: draws float64[n, labels], metric float64[n]; gradients about the nominal."""

    condition: Condition
    z: F64
    y: F64
    about: Sensitivity
    why: str = ""  # gradients are not from one run backwards


def check_breakdown(study: Study, target: Target, metric: str) -> str:
    """Check that a metric of a study can be broken down, and give its name in the table.

    Raises `ParameterError` for a system and for too few dies, and `UnknownNameError` for a metric that the
    study does not measure.
    """
    if not isinstance(target, BlockTarget):
        raise ParameterError(f"contributions: {study.subject.target} is a system; study its blocks or chips")
    names = [q.name for q in target.quantities]
    wanted = metric.rpartition(":")[2].replace("-", "_")
    if wanted not in names:
        raise unknown_name("metric", metric, names)
    if study.plan.count < FEWEST:
        raise ParameterError(f"contributions: {study.plan.count} samples, must be >= {FEWEST}; take more")
    return wanted


def breakdowns(
    study: Study,
    target: Target,
    table: Table,
    metric: str,
    threads: int | None = None,
    by: Gradients = "adjoint",
) -> tuple[tuple[Breakdown, ...], tuple[str, ...]]:
    """Break the variance of a metric down at every condition, then over the temperatures of a corner.

    Parameters
    ----------
    study : the finished study.
    target : what it measured.
    table : its samples.
    metric : name of the metric in the table.
    threads : number of threads that measure gradients; all cores unless given.
    by : whether gradients come from one run backwards where the metric has them, or from moved dies always.

    Returns
    -------
    What was found, and one line for each condition at which it is not possible.
    """
    found: list[Breakdown] = []
    refused: list[str] = []
    for corner in dict.fromkeys(c.corner for c in study.conditions):
        parts = list(_parts(study, target, table, metric, corner, threads, by))
        for group in [[part] for part in parts] + ([parts] if len(parts) > 1 else []):
            try:
                found.append(_breakdown(metric, group))
            except ParameterError as error:
                refused.append(str(error))
    return tuple(found), tuple(refused)


def share_rows(shares: Sequence[VarianceShare], most: int) -> list[tuple[str, str]]:
    """Give names and percentages of shares as the rows of a table.

    The percentages sum to 100.0 as written. The shares beyond the `most` first ones are one row, and the
    unexplained part is the last row.
    """
    *explained, rest = shares
    shown, others = explained[:most], explained[most:]
    if others:
        shown.append(VarianceShare(f"{len(others)} others", sum(share.value for share in others)))
    rows = [*shown, rest]
    percent = percentages(rows)
    return [(s.name, f"{p:.1f} %") for s, p in zip(rows, percent, strict=True)]


def _parts(
    study: Study, target: Target, table: Table, metric: str, corner: str, threads: int | None, by: Gradients
) -> Iterator[_Part]:
    labels, everything = varying_labels(target, corner), target.labels()
    columns = [everything.index(label) for label in labels]
    own = np.array(table.corner, dtype=object) == corner
    for celsius in dict.fromkeys(c.temperature_c for c in study.conditions if c.corner == corner):
        part = select(table, (own & (table.temperature_c == celsius)).astype(np.bool_))
        draws = np.array([target.draws(die)[columns] for die in dies_of(study, _numbers(part))])
        condition = Condition(corner, celsius, 0)
        die, why = read_die(study.subject.silicon), ""
        about = adjoint_sensitivity(target, die, condition, metric) if by == "adjoint" else ""
        if isinstance(about, str):
            why, about = about, sensitivity(target, die, condition, threads)
        yield _Part(condition, draws.reshape(len(part), len(labels)), part.column(metric), about, why)


def _numbers(part: Table) -> range:
    """Dies of a block's samples at a condition, which are consecutive."""
    return range(int(part.die[0]), int(part.die[-1]) + 1) if len(part) else range(0)


def _breakdown(metric: str, parts: list[_Part]) -> Breakdown:
    corner, celsius = parts[0].condition.corner, tuple(part.condition.temperature_c for part in parts)
    where = f"contributions: {metric} at {', '.join(f'{t:g}' for t in celsius)} degC, {corner}"
    samples, parts = sum(len(part.y) for part in parts), [_defined(part) for part in parts]
    y = np.concatenate([part.y for part in parts])
    if len(y) < FEWEST:
        raise ParameterError(
            f"{where}: {len(y)} defined samples of {samples}, must be >= {FEWEST}; take more dies"
        )
    if np.ptp(y) == 0.0:
        raise ParameterError(f"{where}: all {len(y)} defined samples are equal; name a metric that varies")
    logarithm = bool((y > 0.0).all())
    names, z = _factors(parts)
    gradient = _gradient(metric, parts, logarithm=logarithm)
    notes = tuple(_notes(names, gradient, parts))
    known = bool(np.isfinite(gradient).all())
    if not known and not enough(len(y), len(names)):
        least = SAMPLES_A_TERM * (len(names) + 1)
        raise ParameterError(f"{where}: {notes[0]}, which needs {least} defined samples, not {len(y)}")
    found = contributions(names, z, np.log(y) if logarithm else y, gradient if known else None)
    return Breakdown(metric, corner, celsius, logarithm, samples, found, notes)


def _defined(part: _Part) -> _Part:
    defined = np.isfinite(part.y)
    return replace(part, z=part.z[defined], y=part.y[defined])


def _factors(parts: list[_Part]) -> tuple[tuple[str, ...], F64]:
    """Names, and standardised columns float64[samples, names]; T is one where it varies."""
    names, z = parts[0].about.labels, np.vstack([part.z for part in parts])
    if len(parts) == 1:
        return names, z
    return (*names, TEMPERATURE), np.column_stack([z, _standard_temperature(parts)])


def _standard_temperature(parts: list[_Part]) -> F64:
    return standardise(np.concatenate([np.full(len(part.y), part.condition.temperature_c) for part in parts]))


def _gradient(metric: str, parts: list[_Part], *, logarithm: bool) -> F64:
    """Of the metric or its logarithm by each factor, float64[factors]."""
    column = parts[0].about.metrics.index(metric)
    each = [(p.about.log_gradient if logarithm else p.about.gradient)[:, column] for p in parts]
    if len(parts) == 1:
        return each[0]
    sizes = np.array([len(part.y) for part in parts])
    nominal = np.array([part.about.nominal[column] for part in parts])
    if logarithm:
        nominal = np.log(np.where(nominal > 0.0, nominal, np.nan))
    # the column has mean 0 and variance 1, so its slope is a mean product
    slope = float(np.mean(np.repeat(nominal, sizes) * _standard_temperature(parts)))
    return np.append(np.average(each, axis=0, weights=sizes), slope)


def _notes(names: Sequence[str], gradient: F64, parts: list[_Part]) -> Iterator[str]:
    unknown_of = [name for name, g in zip(names, gradient, strict=True) if not np.isfinite(g)]
    if unknown_of:
        more = f" and {len(unknown_of) - 1} more" if len(unknown_of) > 1 else ""
        yield f"no gradient by {unknown_of[0]}{more} about the nominal die, so by regression"
    whys = [part.why for part in parts if part.why]
    if whys:
        yield f"gradients from two dies a draw: {whys[0]}"
    failures = [f for part in parts for f in part.about.failures]
    if failures:
        yield f"{len(failures)} dies measured for gradients failed, as {failures[0]}"
