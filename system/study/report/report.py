"""The report of a finished study: one self-contained page that a reader can keep, mail and print.

It says what was asked for, and for every corner and temperature the classes, the yield with its causes, each
metric with its statistics and pictures, contributions where they were asked for, and the worst samples with
the command that measures each again. It depends on the study alone: the same study gives the same page.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from matplotlib.figure import Figure

from circuits.units import format_quantity
from system.files.writing import write_text_atomic
from system.plot import PALE
from system.study.folder import REPORT
from system.study.manifest import read_manifest
from system.study.report.page import add, add_picture, add_table, code, page, write
from system.study.report.picture import histogram, normal_quantiles
from system.study.report.result import Result, groups, shares_of, study_yield, summary, varied
from system.study.report.worst import replay_options, worst
from system.study.search.breakdown import BY, Breakdown, share_rows
from system.study.specification import Specification
from system.study.statistics.contribution import grouped, pareto
from system.study.statistics.interval import Estimate
from system.study.statistics.summary import Summary
from system.study.table import Table, counted, place_text
from system.study.target import Quantity

WORST = 5  # samples of each kind at each condition
DEVICES = 12  # of a table of contributions
_INTERVAL = "95 % interval"


Replay = Callable[[str, Sequence[tuple[str, str]]], str]  # folder, options: a command


def write_report(folder: Path, result: Result, replay: Replay, breakdowns: Sequence[Breakdown] = ()) -> Path:
    """Write the report into the folder of a study, whole or not at all, and give its path.

    Parameters
    ----------
    folder : folder of the study, which has its manifest.
    result : the finished study.
    replay : gives the command that measures a sample again, from the folder and the options that name the
        sample.
    breakdowns : contributions to the variance that the report shows.
    """
    path = folder / REPORT
    write_text_atomic(path, report(folder, result, read_manifest(folder), replay, breakdowns))
    return path


def report(
    folder: Path,
    result: Result,
    manifest: Mapping[str, Any],
    replay: Replay,
    breakdowns: Sequence[Breakdown] = (),
) -> str:
    """Give the report as the text of an HTML page.

    Parameters
    ----------
    folder : folder of the study, as the commands that measure a sample again are to name it.
    result : the finished study.
    manifest : document of the study's manifest.
    replay : gives the command that measures a sample again, from the folder and the options that name the
        sample.
    breakdowns : contributions to the variance that the report shows.
    """
    title = f"Monte Carlo study of {result.study.subject.target}"
    root, body = page(title)
    add(body, "h1", title)
    _asked(body, result, manifest)
    for corner, celsius, part in groups(result):
        add(body, "h2", f"At {place_text(corner, celsius)}")
        if not len(part):
            add(body, "p", "No samples.")
            continue
        _classes(body, part)
        _yield(body, result, part)
        for quantity in result.quantities:
            _metric(body, result, part, quantity)
        _worst(body, result, part, lambda options: replay(str(folder), options))
    for each in breakdowns:
        _contributions(body, each)
    return write(root)


def _asked(body: Element, result: Result, manifest: Mapping[str, Any]) -> None:
    study = result.study
    silicon, plan, samples = study.subject.silicon, study.plan, len(result.table)
    last = plan.first + samples // max(len(study.conditions), 1) - 1
    early = f", {study.samples} were wanted: a rule stopped it" if result.outcome.stopped else ""
    rows: list[tuple[str, object]] = [
        ("command", code(_command(manifest.get("command", ())))),
        ("dies", f"{silicon.lot}/{plan.first} to {last}" if samples else "none"),
        ("samples", f"{samples}{early}"),
        ("plan", f"{plan.method}, seed {plan.seed}"),
        ("varied", varied(study)),
        ("trials a die", len({c.trial for c in study.conditions})),
        ("specifications", "; ".join(map(str, result.specifications)) or "none"),
        ("circuit", code(str(manifest.get("circuit", "")))),
        ("versions", ", ".join(f"{k} {v}" for k, v in manifest.get("versions", {}).items())),
    ]
    add_table(body, ("", ""), rows)


def _command(words: Sequence[str]) -> str:
    """As it was given, by the program's name alone: where that is installed says nothing of the study."""
    return shlex.join([*(Path(word).name for word in words[:1]), *words[1:]])


def _classes(body: Element, part: Table) -> None:
    add(body, "h3", "Classes")
    add_table(body, ("class", "samples:", "share:"), shares_of(counted(part.outcome), len(part)))


def _yield(body: Element, result: Result, part: Table) -> None:
    found = study_yield(result, part)
    if found is None:
        return
    low, high = (100.0 * end for end in (found.estimate.interval.low, found.estimate.interval.high))
    add(body, "h3", f"Yield: {100.0 * found.estimate.value:.2f} %")
    specs = " and ".join(map(str, result.specifications))
    kind = f"{_INTERVAL} {low:.2f} to {high:.2f} % ({result.interval_kind})"
    add(body, "p", f"{found.passed} of {found.samples} samples pass, {kind}: {specs}.")
    if found.causes:
        causes = shares_of(found.causes, found.samples)
        add_table(body, ("does not pass because of", "samples:", "share:"), causes)


def _metric(body: Element, result: Result, part: Table, quantity: Quantity) -> None:
    s = summary(result, part, quantity)
    add(body, "h3", f"{quantity.name} ({quantity.unit})" if quantity.unit else quantity.name)
    infinite = f", {s.infinite} infinite" if s.infinite else ""
    add(body, "p", f"{s.defined} samples defined, {s.undefined} not defined{infinite}.")
    if s.share is not None:
        add(body, "p", f"Yes: {s.share}, {_INTERVAL} ({result.interval_kind}).")
        return
    if not s.defined:
        return
    add_table(body, ("", "value:", f"{_INTERVAL}:"), _statistics(s, quantity.unit))
    draw = partial(_draw_metric, part, quantity, result.specifications, s)
    add_picture(
        body, draw, f"Histogram of {quantity.name} with its limits, and its quantiles against normal ones"
    )
    marks = "dashed: the mean, in the band of its interval; orange: limits of the specifications"
    add(body, "p", f"Histogram ({marks}), and quantiles with the line of a normal distribution.")


def _statistics(s: Summary, unit: str) -> list[tuple[str, str, str]]:
    rows = [
        ("mean", *_estimate(s.mean, unit)),
        ("sigma", *_estimate(s.sigma, unit)),
        ("skew", *_estimate(s.skew, "")),
    ]
    return rows + [(f"quantile {100.0 * q.p:g} %", *_estimate(q.estimate, unit)) for q in s.quantiles]


def _estimate(estimate: Estimate, unit: str) -> tuple[str, str]:
    low, high = (_number(end, unit) for end in (estimate.interval.low, estimate.interval.high))
    return _number(
        estimate.value, unit
    ) or "not defined", f"{low} to {high}" if low and high else "too few samples"


def _number(value: float, unit: str) -> str:
    if not math.isfinite(value):
        return ""
    return format_quantity(value, unit) if unit else f"{value + 0.0:.4g}"  # no -0


def _draw_metric(
    part: Table, quantity: Quantity, specifications: Sequence[Specification], s: Summary, figure: Figure
) -> None:
    figure.set_size_inches(9.0, 3.3)
    left, right = figure.subplots(1, 2)
    histogram(part, quantity, specifications, left)
    ends = (s.mean.interval.low, s.mean.interval.high)
    if np.isfinite(ends).all():
        left.axvspan(*ends, color=PALE, alpha=0.4, lw=0)
    normal_quantiles(part, quantity, right)


def _contributions(body: Element, each: Breakdown) -> None:
    found = each.found
    what = f"ln {each.metric}" if each.logarithm else each.metric
    add(body, "h2", f"Contributions to the variance of {what} at {each.where}")
    check = "" if found.check is None else f"; a linear regression is off by {100.0 * found.check:.1f} points"
    defined = f"{found.samples} of {each.samples} samples, where it is defined"
    add(body, "p", f"By {found.model}, R^2 {found.r2:.3f}, from {defined}{check}.")
    for note in (*each.notes, found.note):
        if note:
            add(body, "p", f"{note}.")
    add_picture(body, partial(_draw_pareto, each), f"Shares of the variance of {what} by device")
    for by, key in BY.items():
        add_table(body, (f"by {by}", "share:"), share_rows(grouped(found, key), DEVICES))


def _draw_pareto(each: Breakdown, figure: Figure) -> None:
    figure.set_size_inches(8.0, 3.8)
    pareto(grouped(each.found, BY["device"]), figure.subplots())


def _worst(
    body: Element, result: Result, part: Table, replay: Callable[[Sequence[tuple[str, str]]], str]
) -> None:
    units = {q.name: q.unit for q in result.quantities}
    rows = []
    words = [q.name for q in result.quantities if q.yes_no]
    for each in worst(part, result.specifications, WORST, words):
        k = each.row
        values = [_number(float(x), units[m]) for m, x in zip(part.metrics, part.values[k], strict=True)]
        command = code(replay(replay_options(result.study, part, k)))
        rows.append((int(part.die[k]), part.outcome[k], *values, each.why, command))
    add(body, "h3", "Worst samples")
    kinds = "that failed, that are not defined, of an excluded class, and farthest out"
    add(body, "p", f"At most {WORST} each {kinds}; the command measures one again.")
    heads = ("die:", "class", *(f"{m}:" for m in part.metrics), "why", "command")
    add_table(body, heads, rows)
