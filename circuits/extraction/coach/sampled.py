"""Predictions of measurements with the band of all that is not known.

A draw takes unknowns from what the fit left of them, and the devices that no measurement reached from a die
of their own; readings get their noise. The curve is that of the fit itself, the band what 95 % of draws lie
in.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from circuits.arrays import F64
from circuits.errors import CircuitError, DataError
from circuits.extraction.coach.bench import Bench
from circuits.extraction.coach.conditions import Condition
from circuits.extraction.coach.metrics import RELATIVE, Metric, metrics_of
from circuits.extraction.coach.models import MODELS, complete, predicted, unknowns_of
from circuits.extraction.coach.table import Table, columns_of
from circuits.extraction.coach.unknown import Posterior, Theta
from circuits.silicon.die import Die, standard_normals
from circuits.silicon.process import Process

DRAWS = 200
FIRST_DIE = 1000
LEVEL = 0.95
_LEAST = 0.2  # share of draws that must have a curve
_PLACE = (("coach", ()),)

Data = Mapping[str, tuple[Condition, Table]]


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """A predicted measurement.

    condition: what was set. table: columns that were set, then each measured one with its `_low` and `_high`.
    metrics: each number with the ends of its 95 % interval. lost: draws for which the solver found no curve.
    """

    condition: Condition
    table: dict[str, F64]
    metrics: dict[str, Metric]
    lost: int


def predict(
    blank: Data,
    posterior: Posterior,
    factors: Mapping[tuple[str, str], float],
    base: Process,
    reference: Data,
    draws: int = DRAWS,
    progress: Callable[[float], None] = lambda _: None,
) -> dict[str, Prediction]:
    """Predict measurements.

    Parameters
    ----------
    blank
        What was set at each, by name.
    posterior
        What is known after the fit.
    factors
        Factors of the readings' noise, by measurement and column, of those that were fitted.
    base
        What is not fitted of the process; its area law is that of devices that were not reached.
    reference
        Measurements that predictions are put in relation to.
    draws
        How many.
    progress
        Is told the share that is done.

    Raises
    ------
    DataError
        The solver finds a curve of a measurement for too few of its draws, or the posterior is of a model
        that had other unknowns.
    """
    _same_unknowns(blank, posterior, base)
    centre = Bench(Theta(posterior.values()), base)
    benches = [centre, *_benches(posterior, base, draws)]
    curves: dict[str, list[dict[str, F64] | None]] = {}
    for done, (name, (condition, table)) in enumerate(blank.items(), 1):
        noise = _noise(condition, factors)
        found = []
        for k, bench in enumerate(benches):
            clean = _curve(bench, condition, table)
            found.append(clean if clean is None or k == 0 else _noisy(condition, clean, noise, k))
        if found[0] is None:
            found[0] = _nearest(condition, benches, found, posterior)
        curves[name] = found
        progress(done / len(blank))
    measured = {n: metrics_of(*d) for n, d in reference.items() if d[0].circuit in MODELS}
    read = {name: _metrics(blank[name], rows) for name, rows in curves.items()}
    return {name: _prediction(blank[name], curves[name], _related(name, read, measured)) for name in blank}


def _same_unknowns(blank: Data, posterior: Posterior, base: Process) -> None:
    needed = unknowns_of({name: condition for name, (condition, _) in blank.items()}, base)
    missing = [each.name for each in needed if each.name not in posterior.names]
    if missing:
        raise DataError(
            f"posterior: {len(missing)} unknowns are missing, {missing[0]} the first, must all be there;"
            " identify the die again with this version"
        )


def _nearest(
    condition: Condition, benches: list[Bench], found: list[dict[str, F64] | None], posterior: Posterior
) -> dict[str, F64]:
    """The curve of the draw nearest to the fit that has one, where the fit itself has none."""
    there = [k for k, row in enumerate(found) if row is not None]
    if not there:
        raise DataError(f"{condition.file}: no curve at the fit or any draw; correct the process or the die")

    def away(k: int) -> float:
        drawn = np.array([benches[k].theta[name] for name in posterior.names])
        return float((((drawn - posterior.mean) / posterior.sd) ** 2).sum())

    row = found[min(there, key=away)]
    return dict(row or {})


def _benches(posterior: Posterior, base: Process, draws: int) -> Iterator[Bench]:
    paths = [((name, ()),) for name in posterior.names]
    normals = np.array(
        [standard_normals(Die("A", FIRST_DIE + k), _PLACE, paths, "unknown") for k in range(draws)]
    )
    for k, values in enumerate(posterior.draws(normals)):
        yield Bench(Theta(values), base, Die("A", FIRST_DIE + k, process=False))


def _curve(bench: Bench, condition: Condition, table: Table) -> dict[str, F64] | None:
    try:
        found = predicted(bench, condition, table)
    except CircuitError:
        return None
    return found if all(np.isfinite(v).all() for v in found.values()) else None


def _noise(condition: Condition, factors: Mapping[tuple[str, str], float]) -> float:
    """Factor of the noise of a circuit's readings: the middle one of its measurements that were fitted."""
    own = [f for (name, _), f in factors.items() if name.split("_")[0] == condition.name.split("_")[0]]
    return float(np.median(own)) if own else 1.0


def _noisy(condition: Condition, clean: dict[str, F64], factor: float, k: int) -> dict[str, F64]:
    spread = MODELS[condition.circuit].noise(condition, clean)
    die, found = Die("A", FIRST_DIE + k - 1), {}
    for name, value in clean.items():
        path = ((condition.name, ()), (name, (value.size,)))
        found[name] = value + factor * spread[name] * standard_normals(die, _PLACE, [path], "reading")
        if name.endswith("_counts"):
            found[name] = np.maximum(np.round(found[name]), 0.0)
    return found


def _metrics(given: tuple[Condition, Table], rows: list[dict[str, F64] | None]) -> list[dict[str, Metric]]:
    condition, table = given
    return [
        {} if row is None else metrics_of(condition, Table({**table, **complete(condition, row)}))
        for row in rows
    ]


def _related(
    name: str, read: Mapping[str, list[dict[str, Metric]]], measured: Mapping[str, dict[str, Metric]]
) -> list[dict[str, Metric]]:
    """Metrics of a measurement's draws with those in relation to another file's."""
    rows = [dict(row) for row in read[name]]
    for file, metric, other, how in RELATIVE:
        if file != name:
            continue
        for k, row in enumerate(rows):
            against = measured.get(other) or (read[other][k] if other in read else {})
            if metric in row and metric in against:
                row[f"{metric}_{how}_to_{other}"] = _relation(row[metric], against[metric], how)
    return rows


def _relation(one: Metric, other: Metric, how: str) -> Metric:
    if how == "ratio":
        value = one.value / other.value if other.value else math.nan
        return Metric(value, value, value, "")
    value = one.value - other.value
    return Metric(value, value, value, one.unit)


def _prediction(
    given: tuple[Condition, Table], rows: list[dict[str, F64] | None], metrics: list[dict[str, Metric]]
) -> Prediction:
    condition, table = given
    kept = [complete(condition, row) for row in rows if row is not None]
    lost = len(rows) - len(kept)
    if len(kept) - 1 < _LEAST * (len(rows) - 1):
        raise DataError(f"{condition.file}: {lost} of {len(rows) - 1} draws have no curve, must be fewer")
    outer = 50.0 * (1.0 - LEVEL)
    columns = {name: table[name] for name in table if name in columns_of(condition)[0]}
    for name in columns_of(condition)[1]:
        drawn = np.array([row[name] for row in kept[1:]] or [kept[0][name]])
        low, high = np.percentile(drawn, [outer, 100.0 - outer], axis=0)
        columns |= {name: kept[0][name], f"{name}_low": low, f"{name}_high": high}
    return Prediction(condition, columns, _intervals(metrics), lost)


def _intervals(rows: list[dict[str, Metric]]) -> dict[str, Metric]:
    """The metrics of the fit, with the interval of 95 % of draws; a switch point's ends are its points."""
    outer, found = 50.0 * (1.0 - LEVEL), {}
    for name, first in rows[0].items():
        centre = first
        drawn = [row[name] for row in rows[1:] if name in row]
        low = np.array([m.low for m in drawn if math.isfinite(m.low)])
        high = np.array([m.high for m in drawn if math.isfinite(m.high)])
        ends = (
            (float(np.percentile(low, outer)), float(np.percentile(high, 100.0 - outer)))
            if low.size
            else (centre.low, centre.high)
        )
        middle = [row[name].value for row in rows[1:] if name in row and math.isfinite(row[name].value)]
        if not math.isfinite(centre.value) and middle:  # the fit's own curve has none in its record
            centre = centre._replace(value=float(np.median(middle)))
        found[name] = replace_metric(centre, *ends)
    return found


def replace_metric(centre: Metric, low: float, high: float) -> Metric:
    """A metric with another interval."""
    return Metric(centre.value, low, high, centre.unit)


__all__ = ["DRAWS", "Prediction", "predict", "replace"]
