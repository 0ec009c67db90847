"""What a search for biases or sizes tells: what moved, and the yield of fresh dies before and after."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from circuits.errors import ParameterError
from system.cli.option_names import words_of
from system.cli.output import json_text, print_json, print_line, print_table, progress_bar, quantity_cell
from system.cli.study_output import share_document
from system.files.writing import check_folder, write_text_atomic
from system.options.block import Value
from system.options.silicon import SiliconChoice
from system.study.engine import on_threads, run_study
from system.study.manifest import Study
from system.study.plan import Plan
from system.study.report.result import judge_table
from system.study.search.knob import Knob, moved_subject, options_of
from system.study.specification import Specification
from system.study.statistics.comparison import YieldDifference, compare_yields
from system.study.statistics.summary import Yield, summarise_yield
from system.study.table import Condition, Table
from system.study.target import BlockTarget, Subject

FIRST_FRESH = 1000  # dies before it are tuned on, it and later ones reported on
CHUNK = 32
TRANSISTOR = "transistor"


@dataclass(frozen=True, slots=True)
class FreshDies:
    """Dies that a search is judged on.

    Attributes
    ----------
    tuning : dies of the search, from 0 on.
    count : dies of the report.
    first : the first of them.
    threads : how many measure them; all cores if None.
    """

    tuning: int
    count: int
    first: int
    threads: int | None

    @property
    def last(self) -> int:
        """The last die of the report."""
        return self.first + self.count - 1

    def check(self) -> None:
        """Raise `ParameterError` where the search would see dies of the report, or there are none."""
        if not 1 <= self.tuning <= FIRST_FRESH:
            raise ParameterError(
                f"--tuning-dies: {self.tuning}, must be 1 to {FIRST_FRESH}; later dies are for the report"
            )
        if self.first < FIRST_FRESH or self.count < 1:
            raise ParameterError(
                f"--fresh-dies: {self.count} from die {self.first}, must be at least one from"
                f" {FIRST_FRESH} on; earlier dies are for the search"
            )

    def document(self) -> dict[str, Any]:
        """Give the first and the last die of the search and of the report as members of a JSON document."""
        return {"tuning_dies": [0, self.tuning - 1], "fresh_dies": [self.first, self.last]}


@dataclass(frozen=True, slots=True)
class Report:
    """Yield of fresh dies before and after a search.

    Attributes
    ----------
    varied : what varies from die to die, in words.
    before : yield at the start.
    after : yield at the biases that were found.
    difference : difference of the two yields, on the same dies.
    means : mean of each metric over the dies where it is defined, before and after, in SI units.
    """

    varied: str
    before: Yield
    after: Yield
    difference: YieldDifference
    means: Mapping[str, tuple[float, float]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Searched:
    """What every finished search has, with the yield of fresh dies.

    Attributes
    ----------
    start : block with its options at the start, and what is measured of it.
    specifications : conditions that a die must fulfil to pass.
    units : unit of each metric.
    knobs : biases and sizes that were moved.
    values : value of each knob that the search found.
    reports : yields of fresh dies.
    """

    start: Subject
    specifications: tuple[Specification, ...]
    units: Mapping[str, str]
    knobs: tuple[Knob, ...]
    values: tuple[Value, ...]
    reports: tuple[Report, ...]

    @property
    def subject(self) -> Subject:
        """The block with the values that the search found."""
        return moved_subject(self.start, self.knobs, self.values)

    def document(self, block: str, silicon: SiliconChoice, fresh: FreshDies) -> dict[str, Any]:
        """Give what was searched, of a block on a silicon, and what was found, as members of a document."""
        return {
            "block": block,
            "specifications": [str(s) for s in self.specifications],
            "temperature_C": BlockTarget(self.start).choice.silicon.temperature_c,
            "lot": silicon.lot,
            "at": silicon.at,
            "level": TRANSISTOR,
            **fresh.document(),
            **_moved_document(self.knobs, self.values, self.subject),
            "fresh": [_report_document(f) for f in self.reports],
        }

    def give(self, output: str | None, document: Mapping[str, Any], show: Callable[[], None] | None) -> None:
        """Write a document of it into the file that is asked for; print it, or what `show` prints instead."""
        if output is not None:
            write_text_atomic(output, json_text(document))
        if show is None:
            print_json(document)
        else:
            show()

    def print_moved(self, title: str, asked: str) -> None:
        """Print what was asked for, in words, what moved, and by how much."""
        print_line(f"{asked}\n")
        rows = [
            (k.name, quantity_cell(k.value, k.unit), quantity_cell(v, k.unit), k.change_text(v))
            for k, v in zip(self.knobs, self.values, strict=True)
        ]
        print_table(title, ("name", "before:", "after:", "change:"), rows)

    def print_found(self, search: str, impossible: tuple[int, str], fresh: FreshDies) -> None:
        """Print how the search went, and what fresh dies tell of what it found.

        search: in words. impossible: how many candidates were no circuit, and the words for them.
        """
        print_line(f"search: {search}")
        if impossible[0]:
            print_line(f"{impossible[0]} {impossible[1]}")
        for report in self.reports:
            _print_report(fresh, report, self.units)

    def print_options(self) -> None:
        """Print the options by which other verbs take what it found."""
        print_line(" ".join(words_of(options_of(self.subject))))


def check_search(
    fresh: FreshDies,
    spec: Sequence[str],
    example: str,
    reach: float,
    silicon: SiliconChoice,
    output: str | None,
) -> None:
    """Raise `ParameterError` for options that no search can have.

    fresh: dies that it is judged on. spec: what should pass. example: a specification, for who gives none.
    reach: factor by which biases or sizes move, each way. silicon: what all dies share. output: file of the
    result, if one is asked for.
    """
    if not spec:
        raise ParameterError(f'--spec: what should pass, must be given; write --spec "{example}"')
    fresh.check()
    if not 1.0 < reach <= 1e3:
        raise ParameterError(f"--range: {reach:g}, must be above 1 and at most 1000; 3 is a third to three")
    if not (silicon.mismatch or silicon.process_variation):
        raise ParameterError("--no-mismatch: no process varies either, so all dies are one; leave it out")
    if output is not None:
        check_folder(output)


def reports_on(
    fresh: FreshDies,
    designs: tuple[Subject, Subject],
    silicon: SiliconChoice,
    specifications: Sequence[Specification],
    condition: Condition,
) -> tuple[Report, ...]:
    """Measure the fresh dies of a block as a search began and as it ended, with mismatch alone first."""
    both = silicon.mismatch and silicon.process_variation
    varied = [replace(silicon, process_variation=False), silicon] if both else [silicon]
    return tuple(_report_on(fresh, designs, s, specifications, condition) for s in varied)


def _report_on(
    fresh: FreshDies,
    designs: tuple[Subject, Subject],
    silicon: SiliconChoice,
    specifications: Sequence[Specification],
    condition: Condition,
) -> Report:
    plan = Plan("random", 0, fresh.first, fresh.count)
    tables = []
    for label, subject in zip(("before", "after"), designs, strict=True):
        study = Study(replace(subject, silicon=silicon), plan, (condition,), CHUNK)
        with (
            progress_bar(f"fresh dies, {_varied(silicon)}, {label}") as progress,
            on_threads(fresh.threads) as workers,
        ):
            tables.append(run_study(study, workers=workers, progress=progress).table)
    first, second = tables
    verdicts = [judge_table(t, specifications) for t in tables]
    return Report(
        _varied(silicon),
        summarise_yield(verdicts[0]),
        summarise_yield(verdicts[1]),
        compare_yields(first.die, verdicts[0].passed, second.die, verdicts[1].passed),
        {m: (_mean(first, m), _mean(second, m)) for m in first.metrics},
    )


def _mean(table: Table, metric: str) -> float:
    x = table.column(metric)
    x = x[np.isfinite(x)]
    return float(x.mean()) if x.size else float("nan")


def _varied(silicon: SiliconChoice) -> str:
    parts = [
        name for name, on in (("mismatch", silicon.mismatch), ("process", silicon.process_variation)) if on
    ]
    return " and ".join(parts)


def _report_document(found: Report) -> dict[str, Any]:
    """Give a report as members of a JSON document."""
    return {
        "varied": found.varied,
        "before": _yield_document(found.before),
        "after": _yield_document(found.after),
        "difference": asdict(found.difference),
        "means": {m: {"before": a, "after": b} for m, (a, b) in found.means.items()},
    }


def _yield_document(found: Yield) -> dict[str, Any]:
    shares = share_document(found, "Clopper-Pearson")
    return {"samples": found.samples, **shares, "causes": dict(found.causes)}


def _print_report(fresh: FreshDies, report: Report, units: Mapping[str, str]) -> None:
    d = report.difference
    print_line("")
    rows = [
        (name, f"{y.passed} of {y.samples}", percent(y.estimate.value), _between(y), _causes(y))
        for name, y in (("before", report.before), ("after", report.after))
    ]
    heads = ("", "pass:", "yield:", "95 % interval (Clopper-Pearson)", "does not pass because of")
    print_table(f"fresh dies {fresh.first} to {fresh.last}, {report.varied}, transistor level", heads, rows)
    print_line(
        f"{d.only_second_passes} dies gained, {d.only_first_passes} lost; McNemar's test of equal yields:"
        f" p = {d.p_value:.2g}"
    )
    for metric, (before, after) in report.means.items():
        cells = (quantity_cell(v, units[metric]) for v in (before, after))
        print_line(f"mean {metric} where defined: {' before, '.join(cells)} after")


def percent(share: float) -> str:
    """Write a share in percent."""
    return f"{100.0 * share:.1f} %"


def _between(found: Yield) -> str:
    ends = found.estimate.interval
    return f"{100.0 * ends.low:.2f} to {100.0 * ends.high:.2f} %"


def _causes(found: Yield) -> str:
    return ", ".join(f"{n} {cause}" for cause, n in found.causes.items())


def _moved_document(knobs: Sequence[Knob], values: Sequence[Value], found: Subject) -> dict[str, Any]:
    """Give what moved, and the options that make the block that was found, as members of a document."""
    return {
        "moved": [
            {"name": k.name, "unit": k.unit, "before": k.value, "after": v, "change": k.change(v)}
            for k, v in zip(knobs, values, strict=True)
        ],
        "options": words_of(options_of(found)),
    }
