"""`noctule montecarlo TARGET`: metrics of a block or chip over dies."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from circuits.blocks.metric import Metric
from circuits.circuit import BiasKind
from circuits.errors import DataError, ParameterError
from system import montecarlo
from system.commands.output import print_json, print_line, print_table, progress_bar, quantity_cell
from system.files import write_text_atomic
from system.montecarlo import QUANTILES, Row
from system.options import Choice, choose, describe_silicon
from system.plot import check_picture, save_picture
from system.silicon_choice import SiliconChoice


@dataclass(frozen=True, slots=True)
class _Run:
    choice: Choice
    metrics: tuple[Metric, ...]
    dies: range
    table: list[Row]


def montecarlo_command(
    target: str,
    *,
    names: Sequence[str],
    count: int,
    first_die: int,
    params: Sequence[str],
    biases: Sequence[str],
    bias_kind: BiasKind | None,
    silicon: SiliconChoice,
    stimuli: Sequence[str],
    workers: int | None,
    csv: str | None,
    plot: str | None,
    as_json: bool,
) -> None:
    """Measure `target` on dies, print statistics, and write a row a die (`csv`) and a picture (`plot`).

    Interrupted, it leaves the rows that were finished in `csv`.
    """
    _check(count, first_die, csv, plot)
    choice = choose(target, params, biases, bias_kind, silicon, stimuli)
    metrics = montecarlo.metrics_of(choice, names)
    if stimuli and all(m.unit or m.value is None for m in metrics):
        raise ParameterError("--stimulus: no metric of these runs the testbench; leave it out")
    run = _Run(choice, metrics, range(first_die, first_die + count), [])
    try:
        with progress_bar(f"{target}, {count} dies") as progress:
            for row in montecarlo.rows(choice, metrics, run.dies, workers):
                run.table.append(row)
                progress(len(run.table) / count)
    finally:
        if csv is not None and run.table:
            write_text_atomic(csv, montecarlo.to_csv(run.table, metrics))
            if len(run.table) < count:
                done = f"{len(run.table)} of {count} dies, those that were finished"
                sys.stderr.write(f"noctule: {csv}: {done}\n")
    if plot is not None:
        save_picture(plot, lambda figure: montecarlo.draw(run.table, metrics, figure))
    if as_json:
        print_json(_document(run))
    else:
        _print(run)


def _check(count: int, first_die: int, csv: str | None, plot: str | None) -> None:
    """Find out before the work what would fail after it."""
    if plot is not None:
        check_picture(plot)
    if csv is not None and not Path(csv).absolute().parent.is_dir():
        raise DataError(f"{csv}: there is no folder {Path(csv).parent}; make it first (mkdir -p)")
    if count < 1 or first_die < 0:
        raise ParameterError(f"--samples: {count} from die {first_die}, must be at least 1 from die 0 on")


def _document(run: _Run) -> dict[str, Any]:
    total = len(run.table)
    silicon = {k: v for k, v in describe_silicon(run.choice.silicon).items() if k != "die"}
    return {
        "block": run.choice.block.name,
        **silicon,
        "first_die": run.dies.start,
        "samples": total,
        "classes": {
            word: {"count": n, "share": n / total} for word, n in montecarlo.outcomes(run.table).items()
        },
        "metrics": {m.name: _metric(run, k, m) for k, m in montecarlo.numeric(run.metrics)},
        "failed": [{"die": row.die, "reason": row.reason} for row in run.table if row.reason],
        "dies": [row.die for row in run.table],
        "outcomes": [row.outcome for row in run.table],
    }


def _metric(run: _Run, k: int, metric: Metric) -> dict[str, Any]:
    values = [row.values[k] for row in run.table]
    found = montecarlo.summarise(values)
    return {
        "unit": metric.unit,
        "defined": found.defined,
        "undefined": len(values) - found.defined,
        "mean": found.mean,
        "sigma": found.sigma,
        "quantiles": {str(q): v for q, v in zip(QUANTILES, found.quantiles, strict=True)},
        "values": values,
    }


def _print(run: _Run) -> None:
    total, silicon = len(run.table), run.choice.silicon
    dies = f"dies {silicon.die.lot}/{run.dies.start} to {run.dies.stop - 1}"
    print_line(f"{run.choice.block.name} at {silicon.temperature_c:g} degC, {dies}, {_varied(run)}\n")
    shares = [(word, n, f"{100 * n / total:.1f} %") for word, n in montecarlo.outcomes(run.table).items()]
    print_table("outcome", ("class", "dies:", "share:"), shares)
    heads = ("metric", "defined:", "undefined:", "mean:", "sigma:", *(f"{100 * q:g} %:" for q in QUANTILES))
    body = [_cells(run, k, m) for k, m in montecarlo.numeric(run.metrics)]
    if body:
        print_table("metrics, where they are defined", heads, body)
    for row in run.table:
        if row.reason:
            print_line(f"die {row.die} failed: {row.reason}")


def _cells(run: _Run, k: int, metric: Metric) -> tuple[object, ...]:
    found = montecarlo.summarise([row.values[k] for row in run.table])
    numbers = (found.mean, found.sigma, *found.quantiles)
    texts = ("" if math.isnan(x) else quantity_cell(x, metric.unit) for x in numbers)
    return metric.name, found.defined, len(run.table) - found.defined, *texts


def _varied(run: _Run) -> str:
    die = run.choice.silicon.die
    process = "process" if die.process else ""
    parts = [
        "mismatch" if die.mismatch else "",
        process if die.corner == "random" else f"corner {die.corner}",
    ]
    return " and ".join(p for p in parts if p)
