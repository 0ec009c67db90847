"""`noctule montecarlo TARGET`: metrics of a block, a chip or a system over dies."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.solver.transient import Result as Run
from circuits.units import parse_quantity
from system.cli.beginning_output import told, told_lines
from system.cli.contributions import breakdown_document, check_pareto, print_breakdown, save_pareto
from system.cli.exit_status import DONE, NO
from system.cli.option_names import replay_of
from system.cli.output import print_json, print_line, progress_bar, working
from system.cli.rare import check_rare, print_rare
from system.cli.study_output import document, print_study
from system.cli.workers import on_processes
from system.files.writing import check_folder, write_text_atomic
from system.notice import say
from system.options.begin import FREE, BeginChoice, refuse_beginning
from system.options.block import choose, read_die
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture
from system.reader import with_params
from system.registry import load_system, system_names
from system.study.campaign import Workers
from system.study.engine import Outcome, on_threads, run_study
from system.study.manifest import Study, check_samples
from system.study.metric import default_metrics, with_named
from system.study.plan import Method, Plan
from system.study.report.picture import draw_study
from system.study.report.report import write_report
from system.study.report.result import Result, groups, judge_table
from system.study.search.breakdown import Breakdown, breakdowns, check_breakdown
from system.study.specification import Specification, limited_metrics, parse_spec
from system.study.statistics.confidence_sequence import StopRule, ended, sequence_interval
from system.study.table import FAILED, Condition, Table, empty, join, to_csv
from system.study.target import BlockTarget, Subject, Target, open_target
from system.system import SUCCEEDED

FIRST_DIE = 1000  # unless one is given


@dataclass(frozen=True, slots=True)
class Request:
    """What the options ask for, as text and numbers."""

    subject: Subject
    temperatures: tuple[str, ...]
    corners: tuple[str, ...]
    trials: int
    samples: int
    first_die: int
    plan: Method
    seed: int
    chunk: int
    specs: tuple[str, ...]
    until: str | None
    require: str | None
    threads: int | None
    workers: int | None
    scheduler: str | None
    output: str | None
    resume: bool
    csv: str | None
    plot: str | None
    contributions: str | None
    pareto: str | None
    rare: str | None


def montecarlo_command(
    *,
    target: str,
    metrics: Sequence[str],
    params: Sequence[str],
    biases: Sequence[str],
    bias_set: str | None,
    bias_kind: BiasKind | None,
    stimuli: Sequence[str],
    silicon: SiliconChoice,
    level: str,
    temperatures: Sequence[str],
    corners: Sequence[str],
    specs: Sequence[str],
    duration: str | None,
    as_json: bool,
    begin: BeginChoice = FREE,
    **options: Any,
) -> int:
    """Measure the target on dies, print statistics, and leave files as asked; returns what `measure` does."""
    given = {} if duration is None else {"duration": duration}
    contributions = options["contributions"]
    named = (*limited_metrics(specs), *(() if contributions is None else (contributions,)))
    measured = with_named(metrics, named)
    system: dict[str, Any] = {}
    if target in system_names():
        refuse_beginning(begin, target)
        loaded = load_system(target)
        _refuse_of_blocks(
            target, (("--bias", biases), ("--bias-set", bias_set), ("--stimulus", stimuli),
            ("--at", silicon.at)),
        )  # fmt: skip
        system, params = loaded.study_options(level, bias_kind, with_params(given, params)), ()
        measured = tuple(dict.fromkeys((SUCCEEDED, *(measured or loaded.study_metrics))))
    elif given:
        raise ParameterError("--duration: not an option of a block; it is one of a system")
    if not measured:
        choice = choose(target, params, biases, bias_kind, silicon, stimuli, bias_set, begin)
        measured = default_metrics(choice)
    subject = Subject(
        target, measured, tuple(params), tuple(biases), bias_set, bias_kind, tuple(stimuli),
        silicon, system, begin.held, begin.begin,
    )  # fmt: skip
    return measure(
        Request(subject, tuple(temperatures), tuple(corners), specs=tuple(specs), **options), as_json=as_json
    )


def _refuse_of_blocks(system: str, given: Sequence[tuple[str, object]]) -> None:
    for option, value in given:
        if value:
            raise ParameterError(f"{option}: an option of blocks and chips, not of {system}; leave it out")


def measure(request: Request, *, as_json: bool) -> int:
    """Run the study that is asked for, and print it; returns `NO` where every die failed."""
    study, specifications, rule = prepare(request)
    if request.rare is not None:
        print_rare(request.rare, study, specifications, request.threads, as_json=as_json)
        return DONE
    target = open_target(study.subject)
    tables: list[Table] = []
    try:
        outcome = _run(request, study, specifications, rule, tables)
    except KeyboardInterrupt:
        _leave(request, study, target, tables)
        raise
    result = Result(study, target, outcome, specifications, rule)
    units = [q.unit for q in target.quantities]
    found, refused = _contributions(request, result)
    if request.csv is not None:
        write_text_atomic(request.csv, to_csv(result.table, units))
    if request.plot is not None:
        save_picture(
            request.plot, lambda figure: draw_study(result.table, target.quantities, specifications, figure)
        )
    page = write_report(Path(request.output), result, replay_of, found) if request.output else None
    for note in outcome.chunks_redone:
        say(note)
    nominal = _nominal_run(study, target)
    if as_json:
        extra = {"contributions": [breakdown_document(b) for b in found]} if request.contributions else {}
        extra |= told(nominal)
        print_json({**document(result), "report": None if page is None else str(page), **extra})
    else:
        print_study(result)
        _print_rest(nominal, found)
        if page is not None:
            print_line(f"report: {page}")
    if refused:
        raise ParameterError(refused[0] if len(refused) == 1 else f"{refused[0]} ({len(refused) - 1} more)")
    return _status(result)


def _status(result: Result) -> int:
    """Say where no die could be measured."""
    silent = [(where, part) for *where, part in groups(result) if set(part.outcome) <= {FAILED}]
    for (corner, celsius), part in silent:
        at = f"{celsius:g} degC" + ("" if corner == "random" else f", corner {corner}")
        say(f"montecarlo: all {len(part)} samples at {at} failed, the first: {part.reason[0]}")
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


def _contributions(r: Request, result: Result) -> tuple[tuple[Breakdown, ...], tuple[str, ...]]:
    """Breakdowns that are asked for with their picture, and why others are not possible."""
    if r.contributions is None:
        return (), ()
    name = check_breakdown(result.study, result.target, r.contributions)
    with working(f"measuring gradients of {name}"):
        found, refused = breakdowns(result.study, result.target, result.table, name, r.threads)
    if r.pareto is not None and found:
        save_pareto(r.pareto, found)
    return found, refused


def prepare(request: Request) -> tuple[Study, tuple[Specification, ...], StopRule | None]:
    """Find out before the work what would fail after it."""
    r = request
    if r.plot is not None:
        check_picture(r.plot)
    if r.csv is not None:
        check_folder(r.csv)
    if r.samples < 1:
        raise ParameterError(
            f"--samples: {r.samples} from die {r.first_die}, must be 1 or more from die 0 on"
        )
    if r.trials < 1:
        raise ParameterError(f"--trials: {r.trials}, must be at least 1")
    if r.resume and r.output is None:
        raise ParameterError("--resume: which study, must come with --output FOLDER")
    target = open_target(r.subject)
    rule = _rule(r, target)
    if rule is not None and r.plan != "random":
        raise ParameterError(f"--until: its intervals need independent dies, {r.plan} has none; use random")
    plan = Plan(r.plan, r.seed, r.first_die, r.samples)
    study = Study(r.subject, plan, _conditions(r), r.chunk)
    _check_target(r, target)
    if r.contributions is not None:
        check_breakdown(study, target, r.contributions)
    check_pareto(r.pareto, r.contributions)
    if r.rare is not None:
        check_rare(r.rare, study, r.specs, _only_of_a_study(r))
    known = {q.name: q.unit for q in target.quantities}
    asked = tuple(parse_spec(text, known) for text in r.specs)
    return study, asked or target.specifications, rule


def _only_of_a_study(r: Request) -> dict[str, object]:
    """Options of a study that keeps its dies, with what they were given; none are falsy."""
    plan, first = r.plan != "random", r.first_die != FIRST_DIE
    return {
        "--until": r.until, "--require": r.require, "--output": r.output, "--resume": r.resume,
        "--csv": r.csv, "--plot": r.plot, "--contributions": r.contributions, "--workers": r.workers,
        "--scheduler": r.scheduler, "--plan": plan, "--first-die": first,
    }  # fmt: skip


def _rule(r: Request, target: Target) -> StopRule | None:
    if r.until is None and r.require is None:
        return None
    if not (r.specs or target.specifications):
        raise ParameterError("--until: of which yield, must come with --spec")
    half_width = None if r.until is None else _share(r.until, "--until")
    return StopRule(half_width, None if r.require is None else _share(r.require, "--require"))


def _share(text: str, option: str) -> float:
    """`2%` or `0.02`."""
    number = parse_quantity(text.strip().removesuffix("%"), "", option)
    return number / 100.0 if text.strip().endswith("%") else number


def _conditions(r: Request) -> tuple[Condition, ...]:
    celsius = [parse_quantity(t, "degC", "--temperature") for t in r.temperatures]
    _check_once("--temperature", [f"{t:g} degC" for t in celsius])
    _check_once("--corner", r.corners)
    check_samples(r.samples, len(r.corners) * len(celsius) * r.trials)
    return tuple(Condition(c, t, k) for c in r.corners for t in celsius for k in range(r.trials))


def _check_once(option: str, values: Sequence[str]) -> None:
    for value, count in Counter(values).items():
        if count > 1:  # its samples would count twice
            raise ParameterError(f"{option}: {value} is there twice, must be once")


def _check_target(r: Request, target: Target) -> None:
    base = read_die(r.subject.silicon)
    process = base.process and "random" in r.corners
    if r.samples > 1 and not (base.mismatch or process):
        raise ParameterError("--no-mismatch: no process varies either, so all dies are one; leave it out")
    if isinstance(target, BlockTarget):
        if r.trials > 1:
            raise ParameterError(f"--trials: {r.trials}, a block without noise has one; leave it out")
        if r.subject.stimuli and not target.runs_testbench:
            raise ParameterError("--stimulus: no metric of these runs the testbench; leave it out")


def _run(
    r: Request,
    study: Study,
    specifications: Sequence[Specification],
    rule: StopRule | None,
    tables: list[Table],
) -> Outcome:
    passed = samples = 0

    def stop(table: Table) -> bool:
        nonlocal passed, samples
        tables.append(table)
        samples += len(table)
        if rule is None:
            return False
        passed += int(judge_table(table, specifications).passed.sum())
        return ended(rule, sequence_interval(passed, samples, rule.level))

    folder = None if r.output is None else Path(r.output)
    with progress_bar(f"{r.subject.target}, {study.samples} samples") as progress, _workers(r) as workers:
        return run_study(
            study, folder, workers=workers, resume=r.resume, stop=stop if rule or r.csv else None,
            progress=progress, command=sys.argv,
        )  # fmt: skip


def _workers(r: Request) -> AbstractContextManager[Workers]:
    """Threads, or a Dask cluster where one is asked for."""
    if r.scheduler is None and r.workers is None:
        return on_threads(r.threads)
    if r.threads is not None:
        raise ParameterError("--threads: not with --workers or --scheduler; leave one out")
    return on_processes(r.scheduler, r.workers)


def _leave(r: Request, study: Study, target: Target, tables: Sequence[Table]) -> None:
    """Write what was finished when the study was interrupted."""
    table = join(tables) if tables else empty([q.name for q in target.quantities])
    if r.csv is not None and len(table):
        write_text_atomic(r.csv, to_csv(table, [q.unit for q in target.quantities]))
        text = f"{len(table)} of {study.samples} samples, those that were finished"
        say(f"{r.csv}: {text}")
    if r.output is not None:
        say(f"{r.output}: go on with --resume")
