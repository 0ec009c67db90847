"""The verb `noctule corners BLOCK --metric M`: dies at k sigma on which a metric is lowest and highest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from circuits.units import format_quantity
from system.cli.match_verb import Corners
from system.cli.output import print_json, print_line, print_table
from system.cli.over_dies import by_what, quantity_of, slopes_of, target_of
from system.study.metrics.measure import measure_name, named_measures
from system.study.search.corner import StatisticalCorner, corners, write_dies
from system.study.search.slope import Slopes


def corners_command(asked: Corners) -> None:
    """Print the statistical corners of metrics, and write their dies."""
    target = target_of(asked.block, asked.metric, asked.over, "corners")
    found: list[tuple[Slopes, StatisticalCorner, Path | None]] = []
    names = (*asked.metric, *map(measure_name, named_measures(asked.over.measure)))
    for quantity in dict.fromkeys(quantity_of(target, name) for name in names):
        slopes = slopes_of(target, quantity.name, asked.over)
        own = corners(slopes, asked.sigma)
        found += [(slopes, each, _written(asked, slopes, each)) for each in own]
    units = {q.name: q.limit_unit for q in target.quantities}
    if asked.as_json:
        print_json({"block": asked.block, "corners": [_document(*each, units) for each in found]})
        return
    rows = [
        (
            each.metric,
            f"{each.sigma:+g}",
            format_quantity(each.value, units[each.metric]),
            _moved(slopes, each),
        )
        for slopes, each, _ in found
    ]
    print_table("statistical corners", ("metric", "sigma:", "measured there:", "moved most"), rows)
    for _, _, path in found:
        if path is not None:
            print_line(f"die: {path}")


def _written(asked: Corners, slopes: Slopes, each: StatisticalCorner) -> Path | None:
    if asked.output is None:
        return None
    side = "low" if each.sigma < 0.0 else "high"
    (path,) = write_dies(Path(asked.output), slopes, [(f"{each.metric}-{side}", each.point)])
    return path


def _document(
    slopes: Slopes, each: StatisticalCorner, path: Path | None, units: dict[str, str]
) -> dict[str, Any]:
    return {
        "metric": each.metric,
        "unit": units[each.metric],
        "sigma": each.sigma,
        "value": each.value,
        "by": by_what(slopes),
        "die_file": None if path is None else str(path),
    }


def _moved(slopes: Slopes, each: StatisticalCorner) -> str:
    order = abs(each.point).argsort()[::-1][:2]
    return ", ".join(f"{slopes.labels[k]} {each.point[k]:+.2f}" for k in order)
