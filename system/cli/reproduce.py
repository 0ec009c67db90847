"""The verb `noctule reproduce`: runs a paper's experiment, and shows our results beside its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

from circuits.errors import ParameterError, meant
from system.cli.exit_status import DONE, NO
from system.cli.output import print_json, print_line, print_table, progress_bar
from system.cli.verbs import Reproduce
from system.cli.workers import on_processes
from system.experiment import Report
from system.notice import say
from system.plot import check_picture, save_picture
from system.registry import load_experiment
from system.rule import Value
from system.statement import Statement
from system.study.campaign import Execution, here

MOST = 100_000  # of any count: days of work at a run a second; ours
SHOWN = 20  # characters of a count that is refused; ours
VERDICTS = {True: "yes", False: "NO", None: ""}


def reproduce_command(asked: Reproduce) -> int:
    """Run an experiment, print its rows and draw it; returns `NO` where a row disagrees."""
    check_picture(asked.plot)
    chosen = load_experiment(asked.experiment)
    run = chosen.run
    if chosen.counts is not None:
        counts = _counts(chosen.name, chosen.counts, asked.param)
        run = partial(run, execution=_execution(asked), **counts)
    else:
        for option in ("param", "output", "resume", "workers", "scheduler"):
            if getattr(asked, option):
                raise ParameterError(f"--{option}: {chosen.name} is no campaign, it has none; leave it out")
    with progress_bar(chosen.name) as progress:
        report = run(progress)
    save_picture(asked.plot, report.draw)
    if asked.as_json:
        rows = [row.row() for row in report.rows]
        said = {"scores": [asdict(score) for score in report.scores], "notes": report.said}
        print_json({"experiment": chosen.name, "rows": rows} | said)
    else:
        _print(f"{chosen.name}: {chosen.summary}", report)
    if report.agrees:
        return DONE
    of = f"{len(report.disagreeing)} of {len(report.rows)} rows disagree"
    say(f"{chosen.name}: {of}: {', '.join(report.disagreeing)}")
    return NO


def _execution(asked: Reproduce) -> Execution:
    if asked.resume and asked.output is None:
        raise ParameterError("--resume: needs the file of --output; add it")
    many = asked.workers is not None or asked.scheduler is not None
    made_by = partial(on_processes, asked.scheduler, asked.workers) if many else here
    return Execution(None if asked.output is None else Path(asked.output), asked.resume, made_by)


def _counts(experiment: str, usual: Mapping[str, int], params: Sequence[str]) -> dict[str, int]:
    """Whole numbers that are given, by name."""
    found: dict[str, int] = {}
    for text in params:
        name, _, value = text.partition("=")
        if name not in usual:
            known = ", ".join(f"{n}={k}" for n, k in usual.items())
            advice = f"known are {known}{meant(name, usual)}" if known else "it has none, leave it out"
            raise ParameterError(f"--param: {name}, unknown to {experiment}; {advice}")
        if not (value.isdecimal() and len(value) <= len(str(MOST)) and 1 <= int(value) <= MOST):
            raise ParameterError(
                f'--param: {name} "{value[:SHOWN]}", must be a whole number from 1 to {MOST}'
            )
        found[name] = int(value)
    return found


def _print(title: str, report: Report) -> None:
    columns = ("name", "paper:", "ours:", "rule", "", "agrees")
    print_table(title, columns, [_cells(row) for row in report.rows])
    print_line(f"Rows that hold: {'; '.join(map(str, report.scores))}")
    for note in report.said:
        print_line(note)


def _cells(row: Statement) -> tuple[str, ...]:
    kind = "fitted" if row.fitted else "predicted"
    verdict = VERDICTS[row.agrees]
    return row.name, _text(row.paper), _text(row.shown), row.rule.text, kind, verdict


def _text(value: Value) -> str:
    return f"{value:.6g}" if isinstance(value, float) else "" if value is None else str(value)
