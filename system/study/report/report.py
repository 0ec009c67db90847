"""The report of a study: one self-contained page that a reader can keep, mail and print.

It says what was asked for, and for every corner and temperature the classes, the yield with its causes, each
metric with its statistics and pictures, contributions where they were asked for, and the worst samples with
the command that measures each again. It depends on the study alone: the same study gives the same page. While
the study runs it says how far that is, and reads itself again.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from circuits.units import format_quantity
from system.files.writing import write_text_atomic
from system.plot import PALE, draw_runs
from system.study.folder import REPORT
from system.study.manifest import read_manifest
from system.study.report.again import AGAIN_SAID, Options, Replay, again_with_page
from system.study.report.growing import Going
from system.study.report.page import Code, Grid, Link, picture, render
from system.study.report.picture import histogram, is_log_normal, normal_quantiles, values_of
from system.study.report.result import Result, alike, groups, shares_of, study_yield, summary, varied
from system.study.report.waveform import runs_of
from system.study.report.worst import replay_options, worst
from system.study.search.breakdown import BY, Breakdown, share_rows
from system.study.specification import Specification
from system.study.statistics.contribution import grouped, pareto
from system.study.statistics.interval import Estimate
from system.study.statistics.summary import Summary
from system.study.table import Condition, Table, counted, place_text
from system.study.target import BlockTarget, Quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WORST = 5  # samples of each kind at each condition
DEVICES = 12  # of a table of contributions
_INTERVAL = "95 % interval"
_SHARES = ("class", "samples:", "share:")
_WORST_KINDS = "that failed, that are not defined, of an excluded class, and farthest out"

_SO_FAR = "Waveforms and contributions come with the last of them."

Again = Callable[[Options], "tuple[str | Link, Code]"]


def write_report(folder: Path, result: Result, replay: Replay, breakdowns: Sequence[Breakdown] = ()) -> Path:
    """Write the report of a finished study into its folder, whole or not at all, and give its path.

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


def write_so_far(folder: Path, result: Result, replay: Replay, refresh: int) -> None:
    """Write the report of a study that is not finished into its folder, whole or not at all.

    refresh: after how many seconds the page is to read itself again; 0 for one that nobody goes on with now.
    """
    text = report(folder, result, read_manifest(folder), replay, going=Going(refresh))
    write_text_atomic(folder / REPORT, text)


def report(
    folder: Path,
    result: Result,
    manifest: Mapping[str, Any],
    replay: Replay,
    breakdowns: Sequence[Breakdown] = (),
    going: Going | None = None,
) -> str:
    """Give the report as the text of an HTML page.

    Parameters
    ----------
    folder : folder of the study, as the commands that measure a sample again are to name it.
    result : the study with the samples that there are.
    manifest : document of the study's manifest.
    replay : gives the command that measures a sample again, from the folder and the options that name the
        sample.
    breakdowns : contributions to the variance that the report shows.
    going : of a study that is not finished; such a page has no waveforms.
    """
    of_one = partial(again_with_page, folder, Path(), replay, filmed=result.target.filmed)
    found = [
        _group(result, corner, celsius, part, of_one) | _waveforms_in(result, corner, celsius, part, going)
        for corner, celsius, part in groups(result)
    ]
    return render(
        {
            "title": f"Monte Carlo study of {result.study.subject.target}",
            "refresh": going.refresh if going else 0,
            "state": _state(result, going) if going else "",
            "asked": _asked(result, manifest),
            "groups": found,
            "breakdowns": [_contributions(each) for each in breakdowns],
        }
    )


def _state(result: Result, going: Going) -> str:
    """How far a study is that is not finished."""
    most = "at most " if result.rule else ""
    far = f"Not finished yet: {len(result.table)} of {most}{result.study.samples} samples. {_SO_FAR}"
    return f"{far} {going.said}"


def _waveforms_in(
    result: Result, corner: str, celsius: float, part: Table, going: Going | None
) -> dict[str, Any]:
    """Waveforms at one corner and temperature (degC), which a study has once it is finished."""
    if going or not len(part):
        return {"waveforms": None}
    return {"waveforms": _waveforms(result, Condition(corner, celsius, int(part.trial[0])), part)}


def _asked(result: Result, manifest: Mapping[str, Any]) -> Grid:
    study = result.study
    silicon, plan, samples = study.subject.silicon, study.plan, len(result.table)
    last = int(result.table.die.max()) if samples else 0
    early = f", {study.samples} were wanted: a rule stopped it" if result.outcome.stopped else ""
    rows: list[tuple[str, object]] = [
        ("command", Code(_command(manifest.get("command", ())))),
        ("dies", f"{silicon.lot}/{plan.first} to {last}" if samples else "none"),
        ("samples", f"{samples}{early}"),
        ("plan", f"{plan.method}, seed {plan.seed}"),
        ("varied", ". ".join(filter(None, (varied(study), result.shared)))),
        ("trials a die", len({c.trial for c in study.conditions})),
        ("specifications", "; ".join(map(str, result.specifications)) or "none"),
        ("circuit", Code(str(manifest.get("circuit", "")))),
        ("versions", ", ".join(f"{k} {v}" for k, v in manifest.get("versions", {}).items())),
    ]
    return Grid(("", ""), rows)


def _command(words: Sequence[str]) -> str:
    """As it was given, by the program's name alone: where that is installed says nothing of the study."""
    return shlex.join([*(Path(word).name for word in words[:1]), *words[1:]])


def _group(result: Result, corner: str, celsius: float, part: Table, of_one: Again) -> dict[str, Any]:
    """What the page says of the samples at one corner and temperature (degC)."""
    found: dict[str, Any] = {"place": place_text(corner, celsius), "samples": len(part)}
    if not len(part):
        return found
    return found | {
        "classes": Grid(_SHARES, shares_of(counted(part.outcome), len(part))),
        "yields": _yield(result, part),
        "metrics": [_metric(result, part, quantity) for quantity in result.quantities],
        "worst_said": f"At most {WORST} each {_WORST_KINDS}; of each {AGAIN_SAID[result.target.filmed]}.",
        "worst": _worst(result, part, of_one),
    }


def _yield(result: Result, part: Table) -> dict[str, Any] | None:
    found = study_yield(result, part)
    if found is None:
        return None
    low, high = (100.0 * end for end in (found.estimate.interval.low, found.estimate.interval.high))
    specs = " and ".join(map(str, result.specifications))
    kind = f"{_INTERVAL} {low:.2f} to {high:.2f} % ({result.interval_kind(part)})"
    return {
        "value": f"{100.0 * found.estimate.value:.2f} %",
        "said": f"{found.passed} of {found.samples} samples pass, {kind}: {specs}.",
        "causes": Grid(
            ("does not pass because of", "samples:", "share:"), shares_of(found.causes, found.samples)
        ),
    }


def _metric(result: Result, part: Table, quantity: Quantity) -> dict[str, Any]:
    s = summary(result, part, quantity)
    infinite = f", {s.infinite} infinite" if s.infinite else ""
    found: dict[str, Any] = {
        "name": f"{quantity.name} ({quantity.unit})" if quantity.unit else quantity.name,
        "lines": [f"{s.defined} samples defined, {s.undefined} not defined{infinite}."],
        "statistics": None,
    }
    if s.share is not None:
        found["lines"].append(f"Yes: {s.share}, {_INTERVAL} ({result.interval_kind(part)}).")
        return found
    if not s.defined:
        return found
    draw = partial(_draw_metric, part, quantity, result.specifications, s)
    scale = "; the axis is logarithmic, for the logarithms are nearer to a normal distribution"
    return found | {
        "statistics": Grid(
            ("", "value:", f"{_INTERVAL}:"),
            _statistics(s, quantity.unit, "several a die" if alike(part) else ""),
        ),
        "picture": picture(
            draw, f"Histogram of {quantity.name} with its limits, and its quantiles against normal ones"
        ),
        "caption": "Histogram, and quantiles with the line of a normal distribution"
        + (f"{scale}." if is_log_normal(values_of(part, quantity)) else "."),
    }


def _waveforms(result: Result, condition: Condition, part: Table) -> dict[str, Any] | None:
    """Waveforms of the nominal die, of the median one and of the worst, where a block's runs are measured."""
    if not isinstance(result.target, BlockTarget):
        return None
    found, failed = runs_of(result, result.target, condition, part)
    if not found:
        return None
    block = result.target.choice.block
    first = next(iter(found.values()))
    nodes = block.plotted or tuple(first.spikes) or first.nodes[1:5]
    return {
        "said": " ".join(["The testbench on the nominal die, and on dies of the study.", *failed]),
        "picture": picture(partial(draw_runs, found, nodes), f"Waveforms of {', '.join(found)}"),
    }


def _statistics(s: Summary, unit: str, several: str) -> list[tuple[str, str, str]]:
    """Rows of a table; several: why what is known of independent samples alone has no interval, if so."""
    few = several or "too few samples"
    unknown = "values are equal" if s.sigma.value == 0.0 else few
    rows = [
        ("mean", *_estimate(s.mean, unit, unknown)),
        ("sigma", *_estimate(s.sigma, unit, unknown)),
        ("skew", *_estimate(s.skew, "", unknown)),
    ]
    return rows + [(f"quantile {100.0 * q.p:g} %", *_estimate(q.estimate, unit, few)) for q in s.quantiles]


def _estimate(estimate: Estimate, unit: str, unknown: str) -> tuple[str, str]:
    low, high = (_number(end, unit) for end in (estimate.interval.low, estimate.interval.high))
    between = f"{low} to {high}" if low and high else unknown
    return _number(estimate.value, unit) or "not defined", between


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
        left.axvspan(*ends, color=PALE, alpha=0.4, lw=0, label=f"{_INTERVAL} of the mean")
    normal_quantiles(part, quantity, right)
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper left", ncols=4, fontsize=8)


def _contributions(each: Breakdown) -> dict[str, Any]:
    found = each.found
    what = f"ln {each.metric}" if each.logarithm else each.metric
    check = "" if found.check is None else f"; a linear regression is off by {100.0 * found.check:.1f} points"
    defined = f"{found.samples} of {each.samples} samples, where it is defined"
    notes = [f"{note}." for note in (*each.notes, found.note) if note]
    return {
        "title": f"Contributions to the variance of {what} at {each.where}",
        "lines": [f"By {found.model}, R^2 {found.r2:.3f}, from {defined}{check}.", *notes],
        "picture": picture(partial(_draw_pareto, each), f"Shares of the variance of {what} by device"),
        "tables": [
            Grid((f"by {by}", "share:"), share_rows(grouped(found, key), DEVICES)) for by, key in BY.items()
        ],
    }


def _draw_pareto(each: Breakdown, figure: Figure) -> None:
    figure.set_size_inches(8.0, 3.8)
    pareto(grouped(each.found, BY["device"]), figure.subplots())


def _worst(result: Result, part: Table, of_one: Again) -> Grid:
    units = {q.name: q.unit for q in result.quantities}
    rows = []
    words = [q.name for q in result.quantities if q.yes_no]
    for each in worst(part, result.specifications, WORST, words):
        k = each.row
        values = [_number(float(x), units[m]) for m, x in zip(part.metrics, part.values[k], strict=True)]
        die, command = of_one(replay_options(result.study, part, k))
        rows.append((die, part.outcome[k], *values, each.why, command))
    return Grid(("die:", "class", *(f"{m}:" for m in part.metrics), "why", "command"), rows)
