"""`noctule reproduce`: an experiment of a paper, ours beside theirs."""

from __future__ import annotations

from dataclasses import asdict

from system.commands.output import print_json, print_line, print_table, progress_bar
from system.experiment import Report, Row, Value
from system.plot import check_picture, save_picture
from system.registry import load_experiment


def reproduce_command(experiment: str, *, plot: str | None, as_json: bool) -> int:
    """Run `experiment`, print its rows, draw it into `plot`; 1 if a predicted row disagrees, else 0."""
    if plot is not None:
        check_picture(plot)
    chosen = load_experiment(experiment)
    with progress_bar(chosen.name) as progress:
        report = chosen.run(progress)
    if plot is not None:
        save_picture(plot, report.draw)
    if as_json:
        rows = [asdict(row) for row in report.rows]
        print_json({"experiment": chosen.name, "rows": rows, "notes": report.notes})
    else:
        _print(f"{chosen.name}: {chosen.summary}", report)
    return 0 if report.agrees else 1


def _print(title: str, report: Report) -> None:
    columns = ("name", "paper:", "ours:", "rule", "", "agrees")
    print_table(title, columns, [_cells(row) for row in report.rows])
    for note in report.notes:
        print_line(note)


def _cells(row: Row) -> tuple[str, ...]:
    kind = "fitted" if row.fitted else "predicted"
    return row.name, _text(row.paper), _text(row.ours), row.rule, kind, "yes" if row.agrees else "NO"


def _text(value: Value) -> str:
    return f"{value:.6g}" if isinstance(value, float) else "" if value is None else str(value)
