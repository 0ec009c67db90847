"""The verb `noctule centre`: biases are moved so that more dies pass, and fresh dies tell the gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.units import parse_quantity
from system.cli.block_choice import target_of
from system.cli.deck_measures import own_measures
from system.cli.exit_status import DONE, NO
from system.cli.option_names import words_of
from system.cli.output import json_text, print_json, print_line, print_table, progress_bar, quantity_cell
from system.cli.study_output import share_document
from system.cli.study_verbs import Centre
from system.files.writing import check_folder, write_text_atomic
from system.notice import say
from system.options.block import Value, read_die
from system.options.silicon import SiliconChoice
from system.plot import COLOURS, INK, check_picture, save_picture
from system.registry import system_names
from system.study.engine import on_threads, run_study
from system.study.manifest import Study
from system.study.metrics.measure import named_measures
from system.study.metrics.metric import with_named
from system.study.plan import Plan
from system.study.report.result import judge_table
from system.study.search.behavioural_target import BehaviouralTarget, has_model
from system.study.search.centre import Budget, Centred, Problem, centre
from system.study.search.knob import Knob, knobs_of, moved_subject, options_of
from system.study.specification import Specification, limited_metrics, parse_spec
from system.study.statistics.comparison import YieldDifference, compare_yields
from system.study.statistics.summary import Yield, summarise_yield
from system.study.table import Condition, Table
from system.study.target import BlockTarget, Subject, Target, hashed

FIRST_FRESH = 1000  # dies before it are tuned on, it and later ones reported on
CHUNK = 32
BEHAVIOURAL, TRANSISTOR = "behavioural", "transistor"


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


@dataclass(frozen=True, slots=True)
class Result:
    """Finished search with the yield of fresh dies.

    Attributes
    ----------
    asked : options of the verb.
    start : block with its options at the start, and what is measured of it.
    specifications : conditions that a die must fulfil to pass.
    units : unit of each metric.
    knobs : biases and sizes that were moved.
    values : value of each knob that the search found.
    level : what the search measured, `behavioural` or `transistor`.
    found : where the search ended.
    reports : yields of fresh dies.
    """

    asked: Centre
    start: Subject
    specifications: tuple[Specification, ...]
    units: Mapping[str, str]
    knobs: tuple[Knob, ...]
    values: tuple[Value, ...]
    level: str
    found: Centred
    reports: tuple[Report, ...]

    @property
    def subject(self) -> Subject:
        """The block with the values that the search found."""
        return moved_subject(self.start, self.knobs, self.values)


def centre_command(asked: Centre) -> int:
    """Search, report on fresh dies, and write the files that are asked for.

    Returns the exit status, `NO` where no fresh die passes.
    """
    result = run(asked)
    save_picture(asked.plot, partial(draw, result))
    if asked.output is not None:
        write_text_atomic(asked.output, json_text(document(result)))
    if asked.as_json:
        print_json(document(result))
    else:
        _print(result)
    none = [report.varied for report in result.reports if report.after.passed == 0]
    for varied in none:
        say(f"centre: no fresh die passes where {varied} varies; give it more to move, or other limits")
    return NO if none else DONE


def subject_of(asked: Centre) -> Subject:
    """Give the block as the search begins with it, and the metrics that are measured of it.

    Raises `ParameterError` for a system.
    """
    block, values = asked.block, asked.values
    if block in system_names():
        raise ParameterError(f"centre: {block} is a system, must be a block or chip; name one of its chips")
    own = own_measures(block, values, asked.silicon, asked.stimulus)
    measures = named_measures((*own, *asked.measure))
    named = with_named((*asked.metric, *measures), limited_metrics(asked.spec))
    named = named or _default(block)
    return hashed(
        Subject(
            target_of(block, values), named, values.param, values.bias, values.bias_set, values.bias_kind,
            asked.stimulus, asked.silicon,
        )
    )  # fmt: skip


def run(asked: Centre) -> Result:
    """Search on the tuning dies, and report on fresh ones.

    Whatever can fail is checked before the search. Raises `ParameterError` for options that contradict each
    other or the block.
    """
    subject, span = subject_of(asked), parse_quantity(asked.span, "V", "--span")
    _check(asked, span)
    target = BlockTarget(subject)
    if subject.stimuli and not target.runs_testbench:
        raise ParameterError("--stimulus: no metric of these runs the testbench; leave it out")
    units = {q.name: q.unit for q in target.quantities}
    limited = {q.name: q.limit_unit for q in target.quantities}
    specifications = tuple(parse_spec(text, limited) for text in asked.spec)
    knobs = knobs_of(target.choice, asked.move, asked.move_param)
    condition = Condition("random", target.choice.silicon.temperature_c, 0)
    level = _level(asked, target)

    def values_at(coordinates: F64) -> tuple[Value, ...]:
        pairs = zip(knobs, coordinates.tolist(), strict=True)
        return tuple(knob.at(u, asked.reach, span) for knob, u in pairs)

    def open_at(coordinates: F64) -> Target:
        made = BlockTarget(moved_subject(subject, knobs, values_at(coordinates)))
        if level == BEHAVIOURAL:
            return BehaviouralTarget(made)
        made.machines(condition.temperature_c)  # lowered once, before threads share it
        return made

    problem = Problem(open_at, len(knobs), specifications, read_die(subject.silicon), condition)
    budget = Budget(tuning=asked.tuning_dies, generations=asked.generations)
    with progress_bar(f"{subject.target}, search") as progress:
        found = centre(problem, budget=budget, seed=asked.seed, workers=asked.threads, progress=progress)
    values = values_at(found.coordinates)
    designs = subject, moved_subject(subject, knobs, values)
    reports = tuple(_report(asked, designs, s, specifications, condition) for s in _silicons(asked.silicon))
    return Result(asked, subject, specifications, units, knobs, values, level, found, reports)


def _level(asked: Centre, target: BlockTarget) -> str:
    """Level of the search; `auto` is behavioural where there is a model and sizes stay as they are."""
    if asked.level == "auto":
        return BEHAVIOURAL if has_model(target) and not asked.move_param else TRANSISTOR
    return asked.level


def _check(asked: Centre, span: float) -> None:
    if not asked.spec:
        raise ParameterError('--spec: what should pass, must be given; write --spec "class is works"')
    if not 1 <= asked.tuning_dies <= FIRST_FRESH:
        raise ParameterError(
            f"--tuning-dies: {asked.tuning_dies}, must be 1 to {FIRST_FRESH}; later dies are for the report"
        )
    if asked.first_fresh_die < FIRST_FRESH or asked.fresh_dies < 1:
        raise ParameterError(
            f"--fresh-dies: {asked.fresh_dies} from die {asked.first_fresh_die}, must be at least one from"
            f" {FIRST_FRESH} on; earlier dies are for the search"
        )
    if asked.generations < 0 or not 0 <= asked.seed < 2**64:
        raise ParameterError(f"--generations, --seed: {asked.generations}, {asked.seed}, must be at least 0")
    if not 1.0 < asked.reach <= 1e3:
        raise ParameterError(
            f"--range: {asked.reach:g}, must be above 1 and at most 1000; 3 is a third to three"
        )
    if not 0.0 < span <= 5.0:
        raise ParameterError(f"--span: {span:g} V, must be above 0 and at most 5 V; give 0.1V")
    if not (asked.silicon.mismatch or asked.silicon.process_variation):
        raise ParameterError("--no-mismatch: no process varies either, so all dies are one; leave it out")
    check_picture(asked.plot)
    if asked.output is not None:
        check_folder(asked.output)


def _default(block: str) -> tuple[str, ...]:
    """Best delay, whose measurement tells a neuron's class."""
    if block == "rebound-neuron":
        return ("best_delay",)
    raise ParameterError(
        "--metric: whose run tells the class, must be given; name one of the block's metrics"
    )


def _silicons(silicon: SiliconChoice) -> list[SiliconChoice]:
    """Mismatch alone first, where both vary."""
    both = silicon.mismatch and silicon.process_variation
    return [replace(silicon, process_variation=False), silicon] if both else [silicon]


def _report(
    asked: Centre,
    designs: tuple[Subject, Subject],
    silicon: SiliconChoice,
    specifications: Sequence[Specification],
    condition: Condition,
) -> Report:
    plan = Plan("random", 0, asked.first_fresh_die, asked.fresh_dies)
    tables = []
    for label, subject in zip(("before", "after"), designs, strict=True):
        study = Study(replace(subject, silicon=silicon), plan, (condition,), CHUNK)
        with (
            progress_bar(f"fresh dies, {_varied(silicon)}, {label}") as progress,
            on_threads(asked.threads) as workers,
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


def document(result: Result) -> dict[str, Any]:
    """Give the result of a search as members of a JSON document."""
    asked, found = result.asked, result.found
    search = {k: v for k, v in asdict(found).items() if k != "coordinates"}
    return {
        "block": asked.block,
        "specifications": [str(s) for s in result.specifications],
        "temperature_C": parse_quantity(asked.silicon.temperature, "degC", "--temperature"),
        "lot": asked.silicon.lot,
        "at": asked.silicon.at,
        "seed": asked.seed,
        "search_level": result.level,
        "level": TRANSISTOR,
        "tuning_dies": [0, asked.tuning_dies - 1],
        "fresh_dies": [asked.first_fresh_die, asked.first_fresh_die + asked.fresh_dies - 1],
        "moved": [
            {"name": k.name, "unit": k.unit, "before": k.value, "after": v, "change": k.change(v)}
            for k, v in zip(result.knobs, result.values, strict=True)
        ],
        "options": words_of(options_of(result.subject)),
        "search": search,
        "fresh": [
            {
                "varied": f.varied,
                "before": _yield_document(f.before),
                "after": _yield_document(f.after),
                "difference": asdict(f.difference),
                "means": {m: {"before": a, "after": b} for m, (a, b) in f.means.items()},
            }
            for f in result.reports
        ],
    }


def _yield_document(found: Yield) -> dict[str, Any]:
    shares = share_document(found, "Clopper-Pearson")
    return {"samples": found.samples, **shares, "causes": dict(found.causes)}


def _print(result: Result) -> None:
    asked, found = result.asked, result.found
    print_line(
        f"{asked.block}, {' and '.join(map(str, result.specifications))}; tuned on dies"
        f" {asked.silicon.lot}/0 to {asked.tuning_dies - 1} at {result.level} level\n"
    )
    rows = [
        (k.name, quantity_cell(k.value, k.unit), quantity_cell(v, k.unit), k.change_text(v))
        for k, v in zip(result.knobs, result.values, strict=True)
    ]
    print_table("moved", ("name", "before:", "after:", "change:"), rows)
    if not found.coordinates.any():
        print_line("nothing beat the start: nothing is moved")
    print_line(
        f"search: {found.candidates} candidates, {found.measurements} dies measured; sigma x {found.scale:g}:"
        f" {_percent(found.share_before)} before, {_percent(found.share_after)} after; as it is:"
        f" {_percent(found.yield_before)} before, {_percent(found.yield_after)} after"
    )
    if found.impossible:
        print_line(f"{found.impossible} candidates were no circuit, and counted as failing")
    for report in result.reports:
        _print_report(result, report)
    print_line(f"{' '.join(words_of(options_of(result.subject)))}")


def _print_report(result: Result, report: Report) -> None:
    asked, d = result.asked, report.difference
    last = asked.first_fresh_die + asked.fresh_dies - 1
    print_line("")
    rows = [
        (name, f"{y.passed} of {y.samples}", _percent(y.estimate.value), _between(y), _causes(y))
        for name, y in (("before", report.before), ("after", report.after))
    ]
    heads = ("", "pass:", "yield:", "95 % interval (Clopper-Pearson)", "does not pass because of")
    print_table(
        f"fresh dies {asked.first_fresh_die} to {last}, {report.varied}, transistor level", heads, rows
    )
    print_line(
        f"{d.only_second_passes} dies gained, {d.only_first_passes} lost; McNemar's test of equal yields:"
        f" p = {d.p_value:.2g}"
    )
    for metric, (before, after) in report.means.items():
        cells = (quantity_cell(v, result.units[metric]) for v in (before, after))
        print_line(f"mean {metric} where defined: {' before, '.join(cells)} after")


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def _between(found: Yield) -> str:
    ends = found.estimate.interval
    return f"{100.0 * ends.low:.2f} to {100.0 * ends.high:.2f} %"


def _causes(found: Yield) -> str:
    return ", ".join(f"{n} {cause}" for cause, n in found.causes.items())


def draw(result: Result, figure: Figure) -> None:
    """Fill `figure` with the course of the search, what was moved, and the yields with their intervals."""
    search, moves, fresh = figure.subplots(1, 3)
    search.plot(np.arange(1, result.found.best.size + 1), result.found.best, color=COLOURS[0])
    search.set(xlabel="candidates of the first stage", ylabel="best objective")
    bars = moves.barh([k.name for k in result.knobs], result.found.coordinates, color=COLOURS[0])
    moves.invert_yaxis()
    moves.set(xlabel="move, of its range", xlim=(-1.7, 1.7), xticks=(-1.0, 0.0, 1.0))
    texts = [k.change_text(v) for k, v in zip(result.knobs, result.values, strict=True)]
    moves.bar_label(bars, texts, fontsize=7, padding=2)
    moves.axvline(0.0, color=INK, lw=0.8)
    for k, report in enumerate(result.reports):
        for y, x, colour in ((report.before, k - 0.1, COLOURS[1]), (report.after, k + 0.1, COLOURS[2])):
            value, ends = y.estimate.value, y.estimate.interval
            reach = [[100.0 * (value - ends.low)], [100.0 * (ends.high - value)]]
            label = None if k else ("before" if colour == COLOURS[1] else "after")
            fresh.errorbar([x], [100.0 * value], yerr=reach, fmt="o", color=colour, capsize=3, label=label)
    fresh.set_xticks(
        range(len(result.reports)), [f.varied.replace(" and ", "\nand ") for f in result.reports]
    )
    fresh.set(xlim=(-0.5, len(result.reports) - 0.5), ylabel="fresh dies that pass (%)")
    fresh.legend()
    figure.set_size_inches(10.0, 4.0)
