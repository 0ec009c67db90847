"""Gradients of a block's metric about the nominal die from one run backwards, as `sensitivity` has them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from circuits.errors import CircuitError
from circuits.gradient.every import every_gradient
from circuits.lowering.kernel import on_die
from circuits.silicon.die import Die
from system.study.metrics.gradient import measure_of_metric
from system.study.metrics.metric import measurements
from system.study.search.sensitivity import Sensitivity, varying_labels
from system.study.table import Condition
from system.study.target import BlockTarget, Target


def adjoint_sensitivity(target: Target, die: Die, condition: Condition, metric: str) -> Sensitivity | str:
    """Differentiate one metric about the nominal die, or say why it has no gradient of that kind.

    Parameters
    ----------
    target, die, condition
        As `sensitivity` has them.
    metric
        Name of the metric.

    Returns
    -------
    Sensitivity or str
        Gradients, NaN for other metrics; or the reason why there are none.
    """
    if not isinstance(target, BlockTarget):
        return "it is a system"
    labels = varying_labels(target, condition.corner)
    (asked,) = (m for m in target.metrics if m.name == metric)
    shared = [m.measure for m in measurements(target.metrics)]
    machine = target.machines(condition.temperature_c)[shared.index(asked.measure)]
    nominal = replace(die, number=None, corner=condition.corner)  # type: ignore[arg-type]  # was checked
    try:
        there = on_die(machine, nominal)
        found = every_gradient(there, (measure_of_metric(asked, lambda: there),))
    except CircuitError as error:
        return str(error)
    known = {label: i for i, label in enumerate(found.labels)}
    missing = [label for label in labels if label not in known]
    if missing or found.notes[0] or not np.isfinite(found.by).all():
        return found.notes[0] or f"{missing[0] if missing else metric} has none"
    columns = [known[label] for label in labels]
    names = tuple(q.name for q in target.quantities)
    at, empty = names.index(metric), np.full((len(labels), len(names)), np.nan)
    slopes, values = empty.copy(), np.full(len(names), np.nan)
    slopes[:, at], values[at] = found.by[0, columns] * found.sigma[columns], found.values[0]
    return Sensitivity(labels, names, values, empty, empty, (), slopes)
