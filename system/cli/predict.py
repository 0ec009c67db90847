"""The verb `noctule predict`: measurements of a chip before they are made, with their bands."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from circuits.errors import ParameterError
from circuits.extraction.coach.metrics import Metric
from circuits.extraction.coach.posterior import check_process, posterior_of
from circuits.extraction.coach.sampled import Prediction, predict
from circuits.extraction.coach.table import format_table
from circuits.silicon.process_file import process_of
from system.cli.chip_fit import measurements
from system.cli.output import print_json, print_line, print_table, progress_bar
from system.cli.verbs import Predict
from system.files.writing import check_folder, write_text_atomic
from system.options.die.file import read_posterior

_METRICS = "metrics.json"


def predict_command(asked: Predict) -> None:
    """Predict measurements, write their files and metrics, and tell how wide the bands are."""
    if asked.draws < 2:
        raise ParameterError(f"--draws: {asked.draws}, must be 2 or more")
    folder = Path(asked.output)
    check_folder(folder)
    table, process = read_posterior(Path(asked.die)), process_of(asked.process)
    posterior, noise = posterior_of(table, asked.die)
    check_process(posterior, process, table.process, asked.die, "identify the die on this one")
    blank, _ = measurements(asked.blank, "predict", asked.conditions, asked.only)
    reference, _ = measurements(asked.fit, "fit", asked.conditions, ())
    with progress_bar(f"predicting {len(blank)} measurements") as progress:
        found = predict(blank, posterior, noise, process, reference, asked.draws, progress)
    folder.mkdir(exist_ok=True)
    for name, each in found.items():
        write_text_atomic(folder / f"{name}.csv", format_table(each.table))
    metrics = {name: metrics_document(each.metrics) for name, each in found.items()}
    write_text_atomic(folder / _METRICS, json.dumps(metrics, indent=1) + "\n")
    document = {
        "chip": asked.chip, "process": process.name, "die": asked.die, "folder": asked.output,
        "draws": asked.draws, "measurements": [_row(n, p) for n, p in found.items()],
    }  # fmt: skip
    if asked.as_json:
        print_json(document)
    else:
        _print(found, asked.output)


def metrics_document(metrics: Mapping[str, Metric]) -> dict[str, dict[str, Any]]:
    """Metrics as a JSON document has them, null for a number that there is not."""
    return {
        name: {"value": _plain(m.value), "low": _plain(m.low), "high": _plain(m.high), "unit": m.unit}
        for name, m in metrics.items()
    }


def _plain(value: float) -> float | None:
    return float(f"{value:.6g}") if math.isfinite(value) else None


def _row(name: str, found: Prediction) -> dict[str, Any]:
    points = len(next(iter(found.table.values())))
    return {"measurement": name, "points": points, "lost_draws": found.lost, "metrics": len(found.metrics)}


def _print(found: Mapping[str, Prediction], folder: str) -> None:
    rows = [
        (name, metric, f"{m.value:.4g}", f"{m.low:.4g}", f"{m.high:.4g}", m.unit)
        for name, each in found.items()
        for metric, m in each.metrics.items()
    ]
    print_table("predicted", ("measurement", "metric", "value:", "low:", "high:", "unit"), rows)
    print_line(f"{folder}: {len(found)} files and {_METRICS} written")
