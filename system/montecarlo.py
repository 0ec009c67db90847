"""A plain Monte Carlo run: metrics of one block on many dies, and what they come to.

A sample is a die: its silicon is the same in every command. Where a metric is not defined, because the neuron
does not work or the solver gave up, the sample is counted as such and never dropped.
"""

from __future__ import annotations

import csv
import io
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from circuits.blocks.metric import Metric
from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.registry import load_metric, metric_names
from circuits.silicon import Silicon
from circuits.solver.batch import samples
from circuits.solver.transient import Result, simulate
from system.options import Choice
from system.plot import COLOURS, INK
from system.registry import unknown

QUANTILES = (0.025, 0.25, 0.5, 0.75, 0.975)
FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Row:
    """One die: its outcome, a value a metric (NaN where not defined), and why it failed."""

    die: int
    outcome: str
    values: tuple[float, ...]
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Summary:
    """What the defined values of a metric come to, in its unit; NaN where there are too few."""

    defined: int
    mean: float
    sigma: float
    quantiles: tuple[float, ...]


def metrics_of(choice: Choice, names: Sequence[str]) -> tuple[Metric, ...]:
    """Registered metrics of the block's circuit, else what its testbench measures, by name.

    Raises `UnknownNameError` for a name that is neither.
    """
    known = [m for m in map(load_metric, metric_names()) if choice.circuit.name in m.circuits]
    own = {m.name: m for m in known}
    wanted = list(dict.fromkeys(name.replace("-", "_") for name in names))
    if any(name not in own for name in wanted):
        measured = _measured(choice)
        for name in wanted:
            if name not in own and name not in measured:
                raise unknown("metric", name, [*own, *measured])
        own = {**measured, **own}
    return tuple(own[name] for name in wanted)


def rows(choice: Choice, metrics: Sequence[Metric], dies: range, workers: int | None = None) -> Iterator[Row]:
    """One row a die of the choice's lot, in order; the same for any number of `workers`."""
    base = choice.silicon.die
    if not (base.mismatch or (base.process and base.corner == "random")):
        raise ParameterError("--no-mismatch: no process varies either, so all dies are one; leave it out")
    machines = [m.prepare(choice.circuit, choice.silicon) for m in _measurements(metrics)]
    read = partial(_read, metrics, machines)
    for sample in samples(read, machines[0], (replace(base, number=k) for k in dies), workers):
        number = sample.die.number or 0
        if sample.value is None:
            yield Row(number, FAILED, (math.nan,) * len(metrics), sample.reason)
        else:
            yield replace(sample.value, die=number)


def summarise(values: Sequence[float]) -> Summary:
    """Mean, standard deviation and quantiles of the values that are defined."""
    x = np.array([v for v in values if not math.isnan(v)])
    if x.size == 0:
        return Summary(0, math.nan, math.nan, (math.nan,) * len(QUANTILES))
    sigma = float(x.std(ddof=1)) if x.size > 1 else math.nan
    return Summary(x.size, float(x.mean()), sigma, tuple(float(q) for q in np.quantile(x, QUANTILES)))


def outcomes(table: Sequence[Row]) -> dict[str, int]:
    """Number of dies by outcome, the most frequent first."""
    counts = Counter(row.outcome for row in table)
    return dict(sorted(counts.items(), key=lambda item: (-item[1], item[0])))


def to_csv(table: Sequence[Row], metrics: Sequence[Metric]) -> str:
    """`die,class,METRIC_UNIT ...,reason`, a row a die; empty where a metric is not defined."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    numbers = numeric(metrics)
    writer.writerow(["die", "class", *(column(m) for _, m in numbers), "reason"])
    for row in table:
        cells = ("" if math.isnan(row.values[k]) else repr(row.values[k]) for k, _ in numbers)
        writer.writerow([row.die, row.outcome, *cells, row.reason])
    return text.getvalue()


def numeric(metrics: Sequence[Metric]) -> list[tuple[int, Metric]]:
    """Metrics that are numbers, with their position."""
    return [(k, m) for k, m in enumerate(metrics) if m.value is not None]


def column(metric: Metric) -> str:
    """Name with the unit, `best_delay_s`."""
    return f"{metric.name}_{metric.unit}" if metric.unit else metric.name


def draw(table: Sequence[Row], metrics: Sequence[Metric], figure: Figure) -> None:
    """A bar an outcome, then a histogram a metric."""
    numbers = numeric(metrics)
    axes = figure.subplots(1 + len(numbers), 1, squeeze=False)[:, 0]
    counts = outcomes(table)
    axes[0].barh(list(counts), list(counts.values()), color=COLOURS[0])
    axes[0].invert_yaxis()
    axes[0].set_xlabel(f"dies of {len(table)}")
    for ax, (k, metric) in zip(axes[1:], numbers, strict=True):
        x = np.array([row.values[k] for row in table])
        ax.hist(x[~np.isnan(x)], bins="auto" if np.isfinite(x).sum() > 1 else 1, color=COLOURS[0])
        ax.axvline(summarise(x.tolist()).mean, color=INK, lw=1, ls="--")
        ax.set_xlabel(f"{metric.name} ({metric.unit})" if metric.unit else metric.name)
        ax.set_ylabel("dies")


def _measurements(metrics: Sequence[Metric]) -> list[Metric]:
    """The first metric of each measurement that several can share."""
    return list({id(m.measure): m for m in reversed(metrics)}.values())[::-1]


def _read(metrics: Sequence[Metric], machines: Sequence[Machine], first: Machine) -> Row:
    """Measure everything on the die of `first`, a machine of the first measurement."""
    there = [first, *(on_die(m, first.silicon.die) for m in machines[1:])]
    shared = _measurements(metrics)
    found = {id(m.measure): m.measure(machine) for m, machine in zip(shared, there, strict=True)}
    values = tuple(math.nan if m.value is None else float(m.value(found[id(m.measure)])) for m in metrics)
    judged = found[id(shared[0].measure)]
    return Row(0, shared[0].outcome(judged), values, shared[0].reason(judged))


def _measured(choice: Choice) -> dict[str, Metric]:
    """What the testbench measures, as metrics; their names come from a run on the nominal die."""
    measures, outcome = choice.block.measures, choice.block.outcome

    def prepare(circuit: Circuit, silicon: Silicon) -> Machine:
        return to_kernel(choice.testbench(), silicon)

    def value(name: str, result: Result) -> float:
        found = measures(result)[name]
        return math.nan if found is None else found

    def metric(name: str) -> Metric:
        circuits, summary = (choice.circuit.name,), "of the testbench's run"
        return Metric(
            name, "", summary, circuits, prepare, simulate, outcome, _no_reason, partial(value, name)
        )

    nominal = simulate(
        prepare(choice.circuit, replace(choice.silicon, die=replace(choice.silicon.die, number=None)))
    )
    return {name: metric(name) for name in measures(nominal)}


def _no_reason(_: Any) -> str:
    return ""
