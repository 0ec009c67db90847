"""The verb `noctule centre`: biases are moved so that more dies pass, and fresh dies tell the gain."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.units import parse_quantity
from system.cli.block_choice import choose_block, target_of
from system.cli.deck_measures import own_measures
from system.cli.exit_status import DONE, NO
from system.cli.output import print_line, progress_bar
from system.cli.search_output import (
    TRANSISTOR,
    FreshDies,
    Searched,
    check_search,
    percent,
    reports_on,
)
from system.cli.study_verbs import Centre
from system.notice import say
from system.options.block import Value, read_die
from system.plot import COLOURS, INK, check_picture, save_picture
from system.registry import system_names
from system.study.metrics.measure import named_measures
from system.study.metrics.metric import with_named
from system.study.search.behavioural_target import BehaviouralTarget, has_model
from system.study.search.centre import Budget, Centred, Problem, centre
from system.study.search.knob import knobs_of, moved_subject
from system.study.search.linear import centre_by_gradient
from system.study.specification import check_form, limited_metrics
from system.study.table import Condition
from system.study.target import BlockTarget, Subject, Target, hashed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BEHAVIOURAL = "behavioural"


@dataclass(frozen=True, slots=True, kw_only=True)
class Result(Searched):
    """Finished search with the yield of fresh dies.

    Attributes
    ----------
    asked : options of the verb.
    level : what the search measured, `behavioural` or `transistor`.
    found : where the search ended.
    """

    asked: Centre
    level: str
    found: Centred


def centre_command(asked: Centre) -> int:
    """Search, report on fresh dies, and write the files that are asked for.

    Returns the exit status, `NO` where no fresh die passes.
    """
    result = run(asked)
    save_picture(asked.plot, partial(draw, result))
    result.give(asked.output, document(result), None if asked.as_json else lambda: _print(result))
    none = [report.varied for report in result.reports if report.after.passed == 0]
    if none:
        where = " alone, or ".join(none)
        say(f"centre: no fresh die passes with {where} varying; give it more to move, or other limits")
    return NO if none else DONE


def subject_of(asked: Centre) -> Subject:
    """Give the block as the search begins with it, and the metrics that are measured of it.

    Raises `ParameterError` for a system.
    """
    block, values = asked.block, asked.values
    if block in system_names():
        raise ParameterError(f"centre: {block} is a system, must be a block or chip; name one of its chips")
    chosen = partial(choose_block, block, values, asked.silicon, asked.stimulus)
    own = own_measures(block, asked.silicon, chosen)
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
    span = parse_quantity(asked.span, "V", "--span")
    _check(asked, span)
    if asked.block not in system_names():
        check_form(asked.spec)
    subject = subject_of(asked)
    target = BlockTarget(subject)
    if subject.stimuli and not target.runs_testbench:
        raise ParameterError("--stimulus: no metric of these runs the testbench; leave it out")
    units = {q.name: q.unit for q in target.quantities}
    specifications = target.specified(asked.spec)
    knobs = knobs_of(target.choice, asked.move, asked.move_param)
    if not knobs:
        raise ParameterError(
            f"--move: none, and {asked.block} has no bias that is a current; name a bias or size"
        )
    condition = Condition("random", target.choice.silicon.temperature_c, 0)
    level = _level(asked, target)

    def values_at(coordinates: F64) -> tuple[Value, ...]:
        pairs = zip(knobs, coordinates.tolist(), strict=True)
        return tuple(knob.at(u, asked.reach, span) for knob, u in pairs)

    def open_block(coordinates: F64) -> BlockTarget:
        made = BlockTarget(moved_subject(subject, knobs, values_at(coordinates)))
        if level != BEHAVIOURAL:
            made.machines(condition.temperature_c)  # lowered once, before threads share it
        return made

    def open_at(coordinates: F64) -> Target:
        made = open_block(coordinates)
        return BehaviouralTarget(made) if level == BEHAVIOURAL else made

    problem = Problem(open_at, len(knobs), specifications, read_die(subject.silicon), condition)
    budget = Budget(tuning=asked.tuning_dies, generations=asked.generations)
    with progress_bar(f"{subject.target}, search") as progress:
        if asked.by == "gradient":
            found = centre_by_gradient(problem, open_block, asked.tuning_dies, asked.threads, progress)
        else:
            found = centre(problem, budget=budget, seed=asked.seed, workers=asked.threads, progress=progress)
    values = values_at(found.coordinates)
    designs = subject, moved_subject(subject, knobs, values)
    reports = reports_on(fresh_of(asked), designs, asked.silicon, specifications, condition)
    return Result(
        asked=asked, start=subject, specifications=specifications, units=units, knobs=knobs, values=values,
        level=level, found=found, reports=reports,
    )  # fmt: skip


def _level(asked: Centre, target: BlockTarget) -> str:
    """Level of the search; `auto` is behavioural where there is a model and sizes stay as they are."""
    if asked.by == "gradient" and asked.level == BEHAVIOURAL:
        raise ParameterError("--by: gradient, is of transistors; leave --level out")
    if asked.level == "auto" and asked.by == "gradient":
        return TRANSISTOR
    if asked.level == "auto":
        return BEHAVIOURAL if has_model(target) and not asked.move_param else TRANSISTOR
    return asked.level


def _check(asked: Centre, span: float) -> None:
    check_search(fresh_of(asked), asked.spec, "class is works", asked.reach, asked.silicon, asked.output)
    if asked.generations < 0 or not 0 <= asked.seed < 2**64:
        raise ParameterError(f"--generations, --seed: {asked.generations}, {asked.seed}, must be at least 0")
    if not 0.0 < span <= 5.0:
        raise ParameterError(f"--span: {span:g} V, must be above 0 and at most 5 V; give 0.1V")
    check_picture(asked.plot)


def fresh_of(asked: Centre) -> FreshDies:
    """Give the dies that a search is judged on."""
    return FreshDies(asked.tuning_dies, asked.fresh_dies, asked.first_fresh_die, asked.threads)


def _default(block: str) -> tuple[str, ...]:
    """Best delay, whose measurement tells a neuron's class."""
    if block == "rebound-neuron":
        return ("best_delay",)
    raise ParameterError(
        "--metric: whose run tells the class, must be given; name one of the block's metrics"
    )


def document(result: Result) -> dict[str, Any]:
    """Give the result of a search as members of a JSON document."""
    asked, found = result.asked, result.found
    search = {k: v for k, v in asdict(found).items() if k != "coordinates"}
    return {
        **result.document(asked.block, asked.silicon, fresh_of(asked)),
        "seed": asked.seed,
        "search_level": result.level,
        "search": search,
    }


def _print(result: Result) -> None:
    asked, found = result.asked, result.found
    conditions = " and ".join(map(str, result.specifications))
    tuned = f"tuned on dies {asked.silicon.lot}/0 to {asked.tuning_dies - 1} at {result.level} level"
    result.print_moved("moved", f"{asked.block}, {conditions}; {tuned}")
    if not found.coordinates.any():
        print_line("nothing beat the start: nothing is moved")
    search = (
        f"{found.candidates} candidates, {found.measurements} dies measured; sigma x {found.scale:g}:"
        f" {percent(found.share_before)} before, {percent(found.share_after)} after; as it is:"
        f" {percent(found.yield_before)} before, {percent(found.yield_after)} after"
    )
    said = "candidates were no circuit, and counted as failing"
    result.print_found(search, (found.impossible, said), fresh_of(asked))
    result.print_options()


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
