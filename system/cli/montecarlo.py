"""The verb `noctule montecarlo TARGET`: measures metrics of a block, a chip or a system on many dies."""

from __future__ import annotations

import os
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from circuits.errors import ParameterError, meant
from circuits.silicon.course import Points
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result as Run
from circuits.units import parse_quantity
from system.cli.beginning_output import told, told_lines
from system.cli.block_choice import choose_block, target_of
from system.cli.contributions import breakdown_document, check_pareto, print_breakdown, save_pareto
from system.cli.deck_measures import own_measures
from system.cli.exit_status import DONE, NO
from system.cli.option_names import option_of, replay_of
from system.cli.output import print_json, print_line, progress_bar, working
from system.cli.rare import check_rare, print_rare
from system.cli.study_output import document, print_study, said_of, study_title
from system.cli.study_verbs import Montecarlo
from system.cli.workers import on_processes, workers_of
from system.files.writing import check_folder, write_text_atomic
from system.notice import say
from system.options.begin import refuse_beginning
from system.options.block import read_die
from system.options.cards import cards_lines, describe_cards
from system.options.silicon import USUAL_CELSIUS
from system.options.target import file_of
from system.options.temperature import COURSE, is_course, read_course, temperature_fields
from system.plot import check_picture, save_picture
from system.reader import with_params
from system.registry import check_target, load_system, system_names
from system.study.campaign import Workers
from system.study.engine import Outcome, in_dies, run_study
from system.study.manifest import Study, check_samples
from system.study.metrics.measure import named_measures
from system.study.metrics.metric import default_metrics, with_named
from system.study.plan import Plan
from system.study.report.growing import Growing
from system.study.report.picture import draw_study
from system.study.report.report import write_report, write_so_far
from system.study.report.result import Result, groups, judge_table
from system.study.search.breakdown import Breakdown, breakdowns, check_breakdown
from system.study.search.order import worst_first
from system.study.specification import Classes, Specification, limited_metrics
from system.study.statistics.confidence_sequence import StopRule, ended, sequence_interval
from system.study.table import FAILED, Condition, Table, empty, join, place_text, to_csv
from system.study.target import BlockTarget, Subject, Target, hashed, open_target
from system.system import SUCCEEDED

FIRST_DIE = 1000  # unless one is given


def montecarlo_command(asked: Montecarlo) -> int:
    """Measure the target on dies, print statistics, and write the files that are asked for.

    Returns the exit status, as `measure`.
    """
    return measure(asked, subject_of(asked))


def subject_of(asked: Montecarlo) -> Subject:
    """Give the target with its options, and the metrics to measure, its own ones where none is asked for."""
    target, values, silicon, begin = asked.target, asked.values, asked.silicon, asked.begin
    if file_of(target) is None:
        check_target(target)
    given = {} if asked.duration is None else {"duration": asked.duration}
    contributions = asked.contributions
    named = (*limited_metrics(asked.spec), *(() if contributions is None else (contributions,)))
    chosen = partial(choose_block, target, values, silicon, asked.stimulus, begin)
    own = own_measures(target, silicon, chosen)
    asked_for = (*asked.metric, *named_measures((*own, *asked.measure)))
    measured, params = with_named(asked_for, named), values.param
    system: dict[str, Any] = {}
    if target in system_names():
        refuse_beginning(begin, target)
        loaded = load_system(target)
        _refuse_of_blocks(
            target, (("--bias", values.bias), ("--bias-set", values.bias_set), ("--stimulus", asked.stimulus),
            ("--at", silicon.at), ("--measure", asked.measure)),
        )  # fmt: skip
        course = _course(asked.temperature)
        for option, value, usual in (("--engine", asked.engine, "native"), ("--device", asked.device, "cpu")):
            if value != usual:
                raise ParameterError(f"{option}: {value}, of blocks and chips, not of {target}; leave it out")
        if course and COURSE not in loaded.settings:
            raise ParameterError(f"--temperature: a course, but {target} takes one number; give it so")
        system = loaded.study_options(asked.level, values.bias_kind, with_params(given, params))
        if course:
            system[COURSE] = course
            loaded.scenario(**system)  # refuses it where no chip is in the loop
        params = ()
        measured = tuple(dict.fromkeys((SUCCEEDED, *(measured or loaded.study_metrics))))
    elif given:
        raise ParameterError("--duration: not an option of a block; it is one of a system")
    if not measured:
        measured = default_metrics(chosen())
    return hashed(
        Subject(
            target_of(target, values), measured, params, values.bias, values.bias_set, values.bias_kind,
            asked.stimulus, silicon, system, begin.held, begin.begin, engine=asked.engine,
            device=asked.device,
        )
    )  # fmt: skip


def _refuse_of_blocks(system: str, given: Sequence[tuple[str, object]]) -> None:
    for option, value in given:
        if value:
            raise ParameterError(f"{option}: an option of blocks and chips, not of {system}; leave it out")


def measure(asked: Montecarlo, subject: Subject) -> int:
    """Run the study that is asked for, and print it.

    Returns the exit status, `NO` where every sample at some corner and temperature failed.
    """
    study, specifications, rule = prepare(asked, subject)
    if asked.rare is not None:
        print_rare(asked.rare, study, specifications, asked.threads, as_json=asked.as_json)
        return DONE
    target = open_target(subject)
    begun = Result(study, target, Outcome(empty([q.name for q in target.quantities])), specifications, rule)
    tables: list[Table] = []
    growing = _growing(asked, begun)
    try:
        outcome = _run(asked, begun, tables, growing)
    except KeyboardInterrupt:
        growing.leave()
        _leave(asked, begun, tables)
        raise
    result = replace(begun, outcome=outcome)
    units = [q.unit for q in target.quantities]
    found, refused = _contributions(asked, result)
    if asked.csv is not None:
        write_text_atomic(asked.csv, to_csv(result.table, units))
    save_picture(
        asked.plot,
        lambda figure: draw_study(
            result.table, target.quantities, specifications, figure, study_title(result)
        ),
    )
    page = write_report(Path(asked.output), result, replay_of, found) if asked.output else None
    for note in (*outcome.chunks_redone, *_unseen_classes(result)):
        say(note)
    nominal = _nominal_run(study, target)
    _tell(asked, result, found, nominal, page)
    if refused:
        raise ParameterError(refused[0] if len(refused) == 1 else f"{refused[0]} ({len(refused) - 1} more)")
    return _status(result)


def _tell(
    asked: Montecarlo, result: Result, found: Sequence[Breakdown], nominal: Run | None, page: Path | None
) -> None:
    """Print the study, as a document or for a reader."""
    silicon = _on_some_die(result.target) if isinstance(result.target, BlockTarget) else None
    if asked.as_json:
        cards = {} if silicon is None else describe_cards(silicon, asked.engine)
        extra = {"contributions": [breakdown_document(b) for b in found]} if asked.contributions else {}
        report = {"report": None if page is None else str(page)}
        print_json(
            {
                **document(result),
                **report,
                **extra,
                **told(nominal),
                "engine": asked.engine,
                "device": asked.device,
                **cards,
            }
        )
        return
    print_study(result)
    for line in () if silicon is None else cards_lines(silicon, asked.engine):
        print_line(line)
    _print_rest(nominal, found)
    if page is not None:
        print_line(f"report: {page}")


def _on_some_die(target: BlockTarget) -> Silicon:
    """The target's silicon on any die that is drawn."""
    silicon = target.choice.silicon
    return replace(silicon, die=replace(silicon.die, number=0))


def _unseen_classes(result: Result) -> Iterator[str]:
    """Lines on words of a specification that are the class of no sample, but nearly that of one."""
    seen = sorted(set(result.table.outcome))
    for each in result.specifications:
        for word in each.words if isinstance(each, Classes) else ():
            if word not in seen and meant(word, seen):
                yield f"spec: no sample's class is {word}{meant(word, seen)}"


def _status(result: Result) -> int:
    """Say where no die could be measured."""
    silent = [group for group in groups(result) if set(group[2].outcome) <= {FAILED}]
    for corner, celsius, part in silent:
        at = place_text(corner, celsius)
        first = said_of(result, part.reason[0])
        say(f"montecarlo: all {len(part)} samples at {at} failed, the first: {first}")
    return NO if silent else DONE


def _nominal_run(study: Study, target: Target) -> Run | None:
    """A run of a block's testbench, whose beginning and whose silence are those of the study's."""
    if not isinstance(target, BlockTarget) or not study.plan.count:
        return None
    return target.nominal_run(study.conditions[0].temperature_c)


def _print_rest(nominal: Run | None, found: Sequence[Breakdown]) -> None:
    """What a run told, and what the variance comes from."""
    for line in told_lines(nominal):
        print_line(f"nominal die: {line}")
    for each in found:
        print_breakdown(each)


def _contributions(asked: Montecarlo, result: Result) -> tuple[tuple[Breakdown, ...], tuple[str, ...]]:
    """Breakdowns that are asked for with their picture, and why others are not possible."""
    if asked.contributions is None:
        return (), ()
    name = check_breakdown(result.study, result.target, asked.contributions)
    with working(f"measuring gradients of {name}"):
        found, refused = breakdowns(
            result.study, result.target, result.table, name, asked.threads, asked.gradients
        )
    if asked.pareto is not None and found:
        save_pareto(asked.pareto, found)
    return found, refused


def prepare(asked: Montecarlo, subject: Subject) -> tuple[Study, tuple[Specification, ...], StopRule | None]:
    """Check the options before the work, and give the study, its specifications and its stop rule.

    The rule is None for a fixed number of samples. Raises `ParameterError` for options that contradict each
    other or the target.
    """
    check_picture(asked.plot)
    if asked.csv is not None:
        check_folder(asked.csv)
    if asked.samples < 1:
        raise ParameterError(
            f"--samples: {asked.samples} from die {asked.first_die}, must be 1 or more from die 0 on"
        )
    if asked.trials < 1:
        raise ParameterError(f"--trials: {asked.trials}, must be at least 1")
    if asked.resume and asked.output is None:
        raise ParameterError("--resume: which study, must come with --output FOLDER")
    target = open_target(subject)
    rule = _rule(asked, target)
    if rule is not None and asked.plan != "random":
        raise ParameterError(
            f"--until: its intervals need independent dies, {asked.plan} has none; use random"
        )
    if rule is not None and asked.trials > 1:
        raise ParameterError(
            f"--until: its intervals need independent samples, {asked.trials} trials of a die are not; leave"
            " --trials out, or take noctule mission, whose --until is of dies"
        )
    if rule is not None and asked.order != "number":
        raise ParameterError(
            f"--order: {asked.order}, but --until and --require need dies at random; leave one out"
        )
    plan = Plan(asked.plan, asked.seed, asked.first_die, asked.samples)
    study = Study(subject, plan, _conditions(asked, target), asked.chunk)
    _check_target(asked, target)
    if asked.contributions is not None:
        check_breakdown(study, target, asked.contributions)
    check_pareto(asked.pareto, asked.contributions)
    if asked.rare is not None:
        check_rare(asked.rare, study, asked.spec, _only_of_a_study(asked))
    return study, target.specified(asked.spec) or target.specifications, rule


def _only_of_a_study(asked: Montecarlo) -> dict[str, object]:
    """Options of a study that keeps its dies, with what they were given; none are falsy."""
    names = ("until", "require", "output", "resume", "csv", "plot", "contributions", "workers", "scheduler")
    plan, first = asked.plan != "random", asked.first_die != FIRST_DIE
    return {option_of(n): getattr(asked, n) for n in names} | {"--plan": plan, "--first-die": first}


def _rule(asked: Montecarlo, target: Target) -> StopRule | None:
    if asked.until is None and asked.require is None:
        return None
    if not (asked.spec or target.specifications):
        raise ParameterError("--until: of which yield, must come with --spec")
    half_width = None if asked.until is None else _share(asked.until, "--until")
    return StopRule(half_width, None if asked.require is None else _share(asked.require, "--require"))


def _share(text: str, option: str) -> float:
    """`2%` or `0.02`."""
    number = parse_quantity(text.strip().removesuffix("%"), "", option)
    return number / 100.0 if text.strip().endswith("%") else number


def _conditions(asked: Montecarlo, target: Target) -> tuple[Condition, ...]:
    course = _course(asked.temperature) if asked.target in system_names() else ()
    if course:
        celsius = [temperature_fields(course)["temperature_c"]]
    elif not asked.temperature and isinstance(target, BlockTarget):
        celsius = [target.choice.silicon.temperature_c]
    else:
        texts = asked.temperature or (USUAL_CELSIUS,)
        celsius = [parse_quantity(t, "degC", "--temperature") for t in texts]
    _check_once("--temperature", [f"{t:g} degC" for t in celsius])
    _check_once("--corner", asked.corner)
    check_samples(asked.samples, len(asked.corner) * len(celsius) * asked.trials)
    return tuple(Condition(c, t, k) for c in asked.corner for t in celsius for k in range(asked.trials))


def _course(texts: Sequence[str]) -> Points:
    """The course of temperature of a study's runs, of which it has one; none where it has temperatures."""
    courses = [found for text in texts if is_course(text) and isinstance(found := read_course(text), tuple)]
    if courses and len(texts) > 1:
        raise ParameterError("--temperature: a course beside another, must be alone; leave the others out")
    return courses[0] if courses else ()


def _check_once(option: str, values: Sequence[str]) -> None:
    for value, count in Counter(values).items():
        if count > 1:  # its samples would count twice
            raise ParameterError(f"{option}: {value} is there twice, must be once")


def _check_target(asked: Montecarlo, target: Target) -> None:
    base = read_die(asked.silicon)
    process = base.process and "random" in asked.corner
    if asked.samples > 1 and not (base.mismatch or process):
        raise ParameterError("--no-mismatch: no process varies either, so all dies are one; leave it out")
    if isinstance(target, BlockTarget):
        if asked.trials > 1:
            raise ParameterError(f"--trials: {asked.trials}, a block without noise has one; leave it out")
        if asked.stimulus and not target.runs_testbench:
            raise ParameterError("--stimulus: no metric of these runs the testbench; leave it out")


def _run(asked: Montecarlo, begun: Result, tables: list[Table], growing: Growing[Sequence[Table]]) -> Outcome:
    study, specifications, rule = begun.study, begun.specifications, begun.rule
    counts: dict[tuple[str, float], Counter[bool]] = defaultdict(Counter)

    def stop(table: Table) -> bool:
        tables.append(table)
        growing(tables)
        if rule is None:
            return False
        passed = judge_table(table, specifications).passed.tolist()
        for place in zip(table.corner, table.temperature_c.tolist(), passed, strict=True):
            counts[place[:2]][place[2]] += 1
        # the yield at each place is one of its own, whose dies are independent
        each = (sequence_interval(n[True], n.total(), rule.level) for n in counts.values())
        return all(ended(rule, interval) for interval in each)

    folder = None if asked.output is None else Path(asked.output)
    part = None
    if asked.order == "worst":
        part = worst_first(study, begun.target, specifications)
    with progress_bar(f"{asked.target}, {study.samples} samples") as progress, _workers(asked) as workers:
        return run_study(
            study, folder, workers=workers, resume=asked.resume, stop=stop, progress=progress,
            command=sys.argv, part=part,
        )  # fmt: skip


def _growing(asked: Montecarlo, begun: Result) -> Growing[Sequence[Table]]:
    """Writes the report again and again while the study runs, where it has a folder."""

    def write(tables: Sequence[Table], refresh: int) -> None:
        if asked.output is not None:
            so_far = replace(begun, outcome=Outcome(in_dies(tables)))
            write_so_far(Path(asked.output), so_far, replay_of, refresh)

    return Growing(write)


def _workers(asked: Montecarlo) -> AbstractContextManager[Workers]:
    """Threads, or a Dask cluster where one is asked for."""
    cores, given = os.cpu_count() or 1, (asked.scheduler, asked.workers, asked.threads)
    if asked.engine == "ngspice" and given == (None,) * 3 and cores > 1 and asked.samples > asked.chunk:
        return on_processes(None, cores)  # ngspice runs once a process
    return workers_of(asked.threads, asked.workers, asked.scheduler)


def _leave(asked: Montecarlo, begun: Result, tables: Sequence[Table]) -> None:
    """Write what was finished when the study was interrupted."""
    table = join(tables) if tables else begun.table
    if asked.csv is not None and len(table):
        write_text_atomic(asked.csv, to_csv(table, [q.unit for q in begun.quantities]))
        text = f"{len(table)} of {begun.study.samples} samples, those that were finished"
        say(f"{asked.csv}: {text}")
    if asked.output is not None:
        say(f"{asked.output}: go on with --resume")
