"""Output of a study: its samples as a JSON document, and as tables for a reader."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from circuits.silicon.course import Course
from system.cli.option_names import as_options
from system.cli.output import print_line, print_table, quantity_cell
from system.cli.run_command_line import names_in_study
from system.options.block import describe_dies
from system.options.temperature import COURSE
from system.study.report.result import Result, groups, shares_of, study_yield, summary, varied
from system.study.statistics.summary import Proportion, Yield
from system.study.table import Table, counted, place_text, unmeasured
from system.study.target import Quantity

SHOWN = (0.025, 0.25, 0.5, 0.75, 0.975)  # quantiles of the printed table
LISTED = 20  # failed samples that the reader sees


def document(result: Result) -> dict[str, Any]:
    """Give a study as members of a JSON document."""
    table, study = result.table, result.study
    silicon = study.subject.silicon
    found = list(groups(result))
    single = len(found) == 1
    return {
        "target": study.subject.target,
        "block": study.subject.target,
        "temperature_C": result.study.subject.course or (found[0][1] if single else [t for _, t, _ in found]),
        "corner": found[0][0] if single else [c for c, _, _ in found],
        **describe_dies(silicon),
        "process": silicon.process,
        "law": silicon.law,
        "at": silicon.at,
        "options": options_said(study.subject.system),
        "first_die": study.plan.first,
        "plan": study.plan.method,
        "seed": study.plan.seed,
        "samples": len(table),
        "wanted": study.samples,
        "stopped": result.outcome.stopped,
        "shared": result.shared,
        "chunks_read": result.outcome.chunks_read,
        "chunks_redone": result.outcome.chunks_redone,
        **_statistics(result, table),
        "conditions": [
            {"corner": c, "temperature_C": t, "samples": len(part), **_statistics(result, part)}
            for c, t, part in found
            if not single
        ],
        "failed": [
            {
                "die": int(table.die[k]),
                "corner": table.corner[k],
                "temperature_C": float(table.temperature_c[k]),
                "trial": int(table.trial[k]),
                "reason": table.reason[k],
            }
            for k in table.failed
        ],
        "unmeasured": unmeasured(table),
        "dies": table.die,
        "outcomes": list(table.outcome),
        "values": {m: table.column(m) for m in table.metrics},
    }


def options_said(options: Mapping[str, Any]) -> list[str]:
    """Give what a study sets of a system's runs beside their temperature, as `area=4.0`."""
    return [f"{name}={value}" for name, value in options.items() if name != COURSE]


def _statistics(result: Result, table: Table) -> dict[str, Any]:
    total = max(len(table), 1)
    return {
        "classes": {word: {"count": n, "share": n / total} for word, n in counted(table.outcome).items()},
        "metrics": {q.name: _metric(result, table, q) for q in result.quantities},
        "yield": _yield_document(result, table),
    }


def _metric(result: Result, table: Table, quantity: Quantity) -> dict[str, Any]:
    s = summary(result, table, quantity)
    return {
        "unit": quantity.unit,
        "defined": s.defined,
        "undefined": s.undefined,
        "infinite": s.infinite,
        "share": None if s.share is None else share_document(s.share, result.interval_kind(table)),
        **{n: getattr(s, n).value for n in ("mean", "sigma", "skew")},
        **{f"{n}_interval": asdict(getattr(s, n).interval) for n in ("mean", "sigma", "skew")},
        "quantiles": {str(q.p): q.estimate.value for q in s.quantiles},
        "quantile_intervals": {str(q.p): asdict(q.estimate.interval) for q in s.quantiles},
    }


def _yield_document(result: Result, table: Table) -> dict[str, Any] | None:
    found = study_yield(result, table)
    if found is None:
        return None
    return {
        "specifications": [str(s) for s in result.specifications],
        **share_document(found, result.interval_kind(table)),
        "causes": dict(found.causes),
    }


def share_document(share: Proportion, kind: str) -> dict[str, Any]:
    """Give the share of the samples that pass as members of a JSON document.

    kind: name of the kind of its interval.
    """
    interval = asdict(share.estimate.interval)
    return {"passed": share.passed, "value": share.estimate.value, "interval": interval, "kind": kind}


def print_study(result: Result) -> None:
    """Print the statistics of a study by condition, and the samples that failed."""
    table = result.table
    print_line(f"{_heading(result)}\n")
    if result.shared:
        print_line(f"{result.shared}\n")
    for corner, celsius, part in groups(result):
        place = place_text(corner, celsius)
        _print_group(result, part, f" from {place} on" if result.study.subject.course else f" at {place}")
    for reason, count in unmeasured(table).items():
        print_line(f"{count} of {len(table)} samples: {said_of(result, reason)}")
    failed = table.failed
    for k in failed[:LISTED]:
        print_line(f"die {table.die[k]} failed: {said_of(result, table.reason[k])}")
    if len(failed) > LISTED:
        print_line(f"and {len(failed) - LISTED} more failed; --csv or --json has them all")


def said_of(result: Result, reason: str) -> str:
    """Give the reason why a sample failed, with the options of the study that set the fields it names."""
    return as_options(reason, names_in_study({"target": result.study.subject.target}))


def _heading(result: Result) -> str:
    """What was measured on which dies, and what varied."""
    study = result.study
    last = study.plan.first + len(result.table) // len(study.conditions) - 1
    return (
        f"{study.subject.target}, dies {study.subject.silicon.lot}/{study.plan.first} to {last},"
        f" {study.plan.method}, {varied(study)}{'; stopped early' if result.outcome.stopped else ''}"
        + (f"; temperature {Course(course)}" if (course := result.study.subject.course) else "")
    )


def study_title(result: Result) -> str:
    """Give the title of a study's picture: what was measured on which dies, and at what places."""
    places = dict.fromkeys((c.corner, c.temperature_c) for c in result.study.conditions)
    said = "; ".join(place_text(*place) for place in places).replace("degC", "°C")
    return f"{_heading(result)}\nat {said}"


def _print_group(result: Result, table: Table, where: str) -> None:
    classes = shares_of(counted(table.outcome), len(table))
    print_table(f"outcome{where}", ("class", "samples:", "share:"), classes)
    infinite = any(np.isinf(table.column(q.name)).any() for q in result.quantities if not q.yes_no)
    counts = ("defined:", "undefined:", *(("infinite:",) if infinite else ()))
    heads = ("metric", *counts, "mean:", "", "sigma:", *(f"{100 * q:g} %:" for q in SHOWN))
    shares = [_share_cells(result, table, q) for q in result.quantities if q.yes_no]
    if shares:
        title = f"yes or no; 95 % interval ({result.interval_kind(table)})"
        print_table(title, ("metric", "undefined:", "yes"), shares)
    body = [_cells(result, table, q, infinite=infinite) for q in result.quantities if not q.yes_no]
    if body:
        print_table("metrics, where they are defined; 95 % interval of the mean", heads, body)
    found = study_yield(result, table)
    if found is not None:
        _print_yield(result, found, result.interval_kind(table))


def _share_cells(result: Result, table: Table, quantity: Quantity) -> tuple[object, ...]:
    s = summary(result, table, quantity)
    return quantity.name, s.undefined, s.share


def _cells(result: Result, table: Table, quantity: Quantity, *, infinite: bool) -> tuple[object, ...]:
    def cell(value: float) -> str:
        return quantity_cell(value, quantity.unit) if math.isfinite(value) else ""

    s = summary(result, table, quantity)
    ends = s.mean.interval
    between = f"{cell(ends.low)} to {cell(ends.high)}" if math.isfinite(ends.low) else ""
    quantiles = [cell(q.estimate.value) for q in s.quantiles if q.p in SHOWN]
    counts = (s.defined, s.undefined, *((s.infinite,) if infinite else ()))
    return quantity.name, *counts, cell(s.mean.value), between, cell(s.sigma.value), *quantiles


def _print_yield(result: Result, found: Yield, kind: str) -> None:
    low, high = found.estimate.interval.low, found.estimate.interval.high
    specs = " and ".join(str(s) for s in result.specifications)
    share = f"{100.0 * found.estimate.value:.2f} %" if found.samples else "not defined"
    bounds = f"{100.0 * low:.2f} to {100.0 * high:.2f} % ({kind})"
    print_line(f"yield {share}, 95 % interval {bounds}: {specs}")
    if found.causes:
        causes = shares_of(found.causes, found.samples)
        print_table("does not pass because of", ("cause", "samples:", "share:"), causes)
