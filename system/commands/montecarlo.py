"""`noctule montecarlo TARGET`: metrics of a block, a chip or a system over dies."""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from circuits.circuit import BiasKind
from circuits.errors import DataError, ParameterError
from circuits.process import check_temperature
from circuits.units import parse_quantity
from system.commands.contributions import breakdown_document, check_pareto, print_breakdown, save_pareto
from system.commands.output import print_json, print_line, print_table, progress_bar, quantity_cell, working
from system.commands.rare import check_rare, print_rare
from system.files import write_text_atomic
from system.options import read_die
from system.plot import check_picture, save_picture
from system.registry import load_system, system_names
from system.silicon_choice import SiliconChoice
from system.study.breakdown import Breakdown, breakdowns, check_breakdown
from system.study.confidence_sequence import StopRule, ended, sequence_interval
from system.study.engine import Outcome, Submit, on_threads, run_study
from system.study.manifest import Study
from system.study.picture import draw_study
from system.study.plan import METHODS, Method, Plan
from system.study.report import write_report
from system.study.result import Result, groups, judge_table, study_yield, summary, varied
from system.study.specification import Specification, parse_spec
from system.study.summary import Yield
from system.study.table import Condition, Table, empty, join, to_csv
from system.study.target import BlockTarget, Quantity, Subject, Target, open_target

SHOWN = (0.025, 0.25, 0.5, 0.75, 0.975)  # quantiles of the printed table
FIRST_DIE = 1000  # unless one is given
LISTED = 20  # failed samples that the reader sees


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
    duration: str,
    temperatures: Sequence[str],
    corners: Sequence[str],
    specs: Sequence[str],
    route: Mapping[str, str | None],
    as_json: bool,
    **options: Any,
) -> None:
    """Measure the target on dies, print statistics, and leave files as asked."""
    given = {name: value for name, value in route.items() if value is not None}
    system: dict[str, Any] = {}
    if target in system_names():
        loaded = load_system(target)
        system = loaded.study_options(level, parse_quantity(duration, "s", "--duration"), bias_kind, given)
        if list(metrics) == ["best_delay"]:
            metrics = loaded.study_metrics  # what a block is asked for by default has none
    elif given:
        raise ParameterError(f"--{next(iter(given))}: not an option of a block; it is one of the rover")
    subject = Subject(
        target, tuple(metrics), tuple(params), tuple(biases), bias_set, bias_kind, tuple(stimuli), silicon,
        system,
    )  # fmt: skip
    measure(
        Request(subject, tuple(temperatures), tuple(corners), specs=tuple(specs), **options), as_json=as_json
    )


def measure(request: Request, *, as_json: bool) -> None:
    """Run the study that is asked for, and print it."""
    study, specifications, rule = prepare(request)
    if request.rare is not None:
        print_rare(request.rare, study, specifications, request.threads, as_json=as_json)
        return
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
    # a study of no dies has no folder
    page = write_report(Path(request.output), result, found) if request.output and study.plan.count else None
    for note in outcome.chunks_redone:
        sys.stderr.write(f"noctule: {note}\n")
    if as_json:
        extra = {"contributions": [breakdown_document(b) for b in found]} if request.contributions else {}
        print_json({**document(result), "report": None if page is None else str(page), **extra})
    else:
        _print(result)
        for each in found:
            print_breakdown(each)
        if page is not None:
            print_line(f"report: {page}")
    if refused:
        raise ParameterError(refused[0] if len(refused) == 1 else f"{refused[0]} ({len(refused) - 1} more)")


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
    if r.csv is not None and not Path(r.csv).absolute().parent.is_dir():
        raise DataError(f"{r.csv}: there is no folder {Path(r.csv).parent}; make it first (mkdir -p)")
    if r.samples < 0 or r.first_die < 0:
        raise ParameterError(
            f"--samples: {r.samples} from die {r.first_die}, must be 0 or more from die 0 on"
        )
    if r.trials < 1 or r.chunk < 1:
        raise ParameterError(f"--trials, --chunk: {r.trials}, {r.chunk}, must be at least 1")
    if r.plan not in METHODS:
        raise ParameterError(f"--plan: {r.plan}, must be {', '.join(METHODS)}")
    if r.resume and r.output is None:
        raise ParameterError("--resume: which study, must come with --output FOLDER")
    rule = _rule(r)
    if rule is not None and r.plan != "random":
        raise ParameterError(f"--until: its intervals need independent dies, {r.plan} has none; use random")
    plan = Plan(r.plan, r.seed, r.first_die, r.samples)
    study = Study(r.subject, plan, _conditions(r), r.chunk)
    target = open_target(r.subject)
    _check_target(r, target)
    if r.contributions is not None:
        check_breakdown(study, target, r.contributions)
    check_pareto(r.pareto, r.contributions)
    if r.rare is not None:
        check_rare(r.rare, study, r.specs, _only_of_a_study(r))
    known = {q.name: q.unit for q in target.quantities}
    return study, tuple(parse_spec(text, known) for text in r.specs), rule


def _only_of_a_study(r: Request) -> dict[str, object]:
    """Options of a study that keeps its dies, with what they were given; none are falsy."""
    plan, first = r.plan != "random", r.first_die != FIRST_DIE
    return {
        "--until": r.until, "--require": r.require, "--output": r.output, "--resume": r.resume,
        "--csv": r.csv, "--plot": r.plot, "--contributions": r.contributions, "--workers": r.workers,
        "--scheduler": r.scheduler, "--plan": plan, "--first-die": first,
    }  # fmt: skip


def _rule(r: Request) -> StopRule | None:
    if r.until is None and r.require is None:
        return None
    if not r.specs:
        raise ParameterError("--until: of which yield, must come with --spec")
    half_width = None if r.until is None else _share(r.until, "--until")
    return StopRule(half_width, None if r.require is None else _share(r.require, "--require"))


def _share(text: str, option: str) -> float:
    """`2%` or `0.02`."""
    number = parse_quantity(text.strip().removesuffix("%"), "", option)
    return number / 100.0 if text.strip().endswith("%") else number


def _conditions(r: Request) -> tuple[Condition, ...]:
    celsius = [parse_quantity(t, "degC", "--temperature") for t in r.temperatures]
    for value in celsius:
        check_temperature(value)
    return tuple(Condition(c, t, k) for c in r.corners for t in celsius for k in range(r.trials))


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
    with progress_bar(f"{r.subject.target}, {study.samples} samples") as progress, _workers(r) as (submit, n):
        return run_study(
            study, folder, submit=submit, ahead=n, resume=r.resume, stop=stop if rule or r.csv else None,
            progress=progress, command=sys.argv,
        )  # fmt: skip


def _workers(r: Request) -> AbstractContextManager[tuple[Submit, int]]:
    """Threads, or a Dask cluster where one is asked for."""
    if r.scheduler is None and r.workers is None:
        return on_threads(r.threads)
    if r.threads is not None:
        raise ParameterError("--threads: not with --workers or --scheduler; leave one out")
    # dask is slow to import, and most studies run on threads
    cluster: Callable[..., AbstractContextManager[tuple[Submit, int]]] = import_module(
        "system.study.cluster"
    ).on_cluster
    return cluster(r.scheduler, r.workers)


def _leave(r: Request, study: Study, target: Target, tables: Sequence[Table]) -> None:
    """Write what was finished when the study was interrupted."""
    table = join(tables) if tables else empty([q.name for q in target.quantities])
    if r.csv is not None and len(table):
        write_text_atomic(r.csv, to_csv(table, [q.unit for q in target.quantities]))
        text = f"{len(table)} of {study.samples} samples, those that were finished"
        sys.stderr.write(f"noctule: {r.csv}: {text}\n")
    if r.output is not None:
        sys.stderr.write(f"noctule: {r.output}: go on with --resume\n")


def document(result: Result) -> dict[str, Any]:
    """The study as JSON has it."""
    table, study = result.table, result.study
    silicon = study.subject.silicon
    found = list(groups(result))
    single = len(found) == 1
    return {
        "target": study.subject.target,
        "block": study.subject.target,
        "temperature_C": found[0][1] if single else [t for _, t, _ in found],
        "corner": found[0][0] if single else [c for c, _, _ in found],
        "lot": silicon.lot,
        "mismatch": silicon.mismatch,
        "process_variation": silicon.process,
        "at": silicon.at,
        "first_die": study.plan.first,
        "plan": study.plan.method,
        "seed": study.plan.seed,
        "samples": len(table),
        "wanted": study.samples,
        "stopped": result.outcome.stopped,
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
            for k in range(len(table))
            if table.reason[k]
        ],
        "dies": table.die,
        "outcomes": list(table.outcome),
        "values": {m: table.column(m) for m in table.metrics},
    }


def _statistics(result: Result, table: Table) -> dict[str, Any]:
    words = Counter(table.outcome)
    total = max(len(table), 1)
    ordered = sorted(words.items(), key=lambda item: (-item[1], item[0]))
    return {
        "classes": {word: {"count": n, "share": n / total} for word, n in ordered},
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
        "passed": found.passed,
        "value": found.estimate.value,
        "interval": asdict(found.estimate.interval),
        "kind": result.interval_kind,
        "causes": dict(found.causes),
    }


def _print(result: Result) -> None:
    study, table = result.study, result.table
    last = study.plan.first + len(table) // len(study.conditions) - 1
    print_line(
        f"{study.subject.target}, dies {study.subject.silicon.lot}/{study.plan.first} to {last},"
        f" {study.plan.method}, {varied(study)}{'; stopped early' if result.outcome.stopped else ''}\n"
    )
    for corner, celsius, part in groups(result):
        where = f" at {celsius:g} degC" + ("" if corner == "random" else f", corner {corner}")
        _print_group(result, part, where)
    failed = [k for k in range(len(table)) if table.reason[k]]
    for k in failed[:LISTED]:
        print_line(f"die {table.die[k]} failed: {table.reason[k]}")
    if len(failed) > LISTED:
        print_line(f"and {len(failed) - LISTED} more failed; --csv or --json has them all")


def _print_group(result: Result, table: Table, where: str) -> None:
    words = sorted(Counter(table.outcome).items(), key=lambda item: (-item[1], item[0]))
    rows = [(word, n, f"{100.0 * n / len(table):.1f} %") for word, n in words]
    print_table(f"outcome{where}", ("class", "samples:", "share:"), rows)
    heads = ("metric", "defined:", "undefined:", "mean:", "", "sigma:", *(f"{100 * q:g} %:" for q in SHOWN))
    body = [_cells(result, table, q) for q in result.quantities]
    if body:
        print_table("metrics, where they are defined; 95 % interval of the mean", heads, body)
    found = study_yield(result, table)
    if found is not None:
        _print_yield(result, found)


def _cells(result: Result, table: Table, quantity: Quantity) -> tuple[object, ...]:
    def cell(value: float) -> str:
        return quantity_cell(value, quantity.unit) if math.isfinite(value) else ""

    s = summary(result, table, quantity)
    ends = s.mean.interval
    between = f"{cell(ends.low)} to {cell(ends.high)}" if s.defined > 1 else ""
    quantiles = [cell(q.estimate.value) for q in s.quantiles if q.p in SHOWN]
    counts = (s.defined, s.undefined + s.infinite)
    return quantity.name, *counts, cell(s.mean.value), between, cell(s.sigma.value), *quantiles


def _print_yield(result: Result, found: Yield) -> None:
    low, high = found.estimate.interval.low, found.estimate.interval.high
    specs = " and ".join(str(s) for s in result.specifications)
    share = f"{100.0 * found.estimate.value:.2f} %" if found.samples else "not defined"
    bounds = f"{100.0 * low:.2f} to {100.0 * high:.2f} % ({result.interval_kind})"
    print_line(f"yield {share}, 95 % interval {bounds}: {specs}")
    rows = [(cause, n, f"{100.0 * n / found.samples:.1f} %") for cause, n in found.causes.items()]
    if rows:
        print_table("does not pass because of", ("cause", "samples:", "share:"), rows)
