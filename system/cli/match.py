"""The verb `noctule match BLOCK --metric M`: what spreads a metric, and the area of each device."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.units import format_quantity, parse_quantity
from system.cli.match_verb import Match
from system.cli.output import print_json, print_line, print_table, working
from system.cli.over_dies import by_what, quantity_of, slopes_of, target_of
from system.study.search.area import Matched, matched, order, scaled_rows
from system.study.search.slope import Slope, Slopes
from system.study.statistics.interval import Estimate, sigma_interval

LISTED = 15  # devices of the printed table
SQUARE_MICROMETRE = 1e-12  # m^2


def match_command(asked: Match) -> None:
    """Print what each device adds to the spread of a metric, and the areas for a wanted one."""
    target = target_of(asked.block, (asked.metric,), asked.over, "match")
    quantity = quantity_of(target, asked.metric)
    slopes = slopes_of(target, quantity.name, asked.over)
    with working(f"gradient of {quantity.name}"):
        slope = slopes.at(np.zeros(len(slopes.labels)))
        if not slope.by.any():
            raise ParameterError(f"metric: {quantity.name}, is moved by nothing that varies on these dies")
        wanted = _wanted(asked, slope, quantity.limit_unit)
        found = matched(slopes, slope, wanted, _share(asked.least, "least"))
        checks = _checks(asked, slopes, found)
    if asked.as_json:
        print_json(_document(asked, slopes, slope, found, checks))
        return
    _print(slopes, slope, found, wanted, quantity.limit_unit)
    for name, (defined, estimate) in checks.items():
        told = (format_quantity(x, quantity.limit_unit) for x in (estimate.value, *_ends(estimate)))
        some = "" if defined == asked.check else f"{defined} of "  # the others have no such metric
        print_line("{} by {}{} dies: {}, 95 % interval {} to {}".format(name, some, asked.check, *told))


def _ends(estimate: Estimate) -> tuple[float, float]:
    return estimate.interval.low, estimate.interval.high


def _wanted(asked: Match, slope: Slope, unit: str) -> float:
    """The spread that is asked for, in the metric's unit; that of today unless one is."""
    if not np.isfinite(slope.value):
        raise ParameterError(f"metric: {asked.metric} is not defined on the nominal die; {slope.note}")
    if asked.spread is None:
        return float(np.linalg.norm(slope.by))
    text = asked.spread.strip()
    value = _share(text, "spread") * abs(slope.value) if text.endswith("%") else None
    if value == 0.0:
        raise ParameterError(
            f"spread: {text} of {asked.metric}, which is 0 on the nominal die; write a spread"
        )
    value = parse_quantity(text, unit, "spread") if value is None else value
    if not value > 0.0:
        raise ParameterError(f"spread: {asked.spread}, must be above 0; write as in 5%")
    return value


def _share(text: str, name: str) -> float:
    number = parse_quantity(text.strip().removesuffix("%"), "", name)
    share = number / 100.0 if text.strip().endswith("%") else number
    if not share > 0.0:
        raise ParameterError(f"{name}: {text}, must be above 0; write as in 10%")
    return share


def _checks(asked: Match, slopes: Slopes, found: Matched) -> dict[str, tuple[int, Estimate]]:
    """Dies with the metric, and its spread, as devices are and as they should be, on the same draws."""
    if asked.check == 0:
        return {}
    if asked.check < 10:
        raise ParameterError(f"check: {asked.check}, must be at least 10 dies for a spread; take more")
    rng = np.random.Generator(np.random.Philox(key=asked.seed))
    rows = rng.standard_normal((asked.check, len(slopes.labels)))
    return {
        "sampled spread now": _spread(slopes.values(rows)),
        "sampled spread with the wanted areas": _spread(slopes.values(scaled_rows(slopes, found, rows))),
    }


def _spread(values: F64) -> tuple[int, Estimate]:
    known = values[np.isfinite(values)]
    rng = np.random.Generator(np.random.Philox(key=0))
    sigma = float(known.std(ddof=1)) if len(known) > 1 else float("nan")
    return len(known), Estimate(sigma, sigma_interval(known, rng))


def _document(
    asked: Match,
    slopes: Slopes,
    slope: Slope,
    found: Matched,
    checks: dict[str, tuple[int, Estimate]],
) -> dict[str, Any]:
    quantity = quantity_of(slopes.target, slopes.metric)
    total = found.spread_now**2
    return {
        "block": asked.block,
        "metric": quantity.name,
        "unit": quantity.limit_unit,
        "temperature_C": slopes.condition.temperature_c,
        "value": slope.value,
        "note": slope.note,
        "by": by_what(slopes),
        "runs": slopes.runs,
        "spread": found.spread_now,
        "spread_fixed": found.fixed**0.5,
        "spread_wanted": found.spread,
        "area_m2": float(found.area.sum()),
        "area_wanted_m2": float(found.wanted.sum()),
        "devices": [
            {
                "device": found.devices[k],
                "share": float(found.variance[k] / total) if total > 0.0 else 0.0,
                "area_m2": float(found.area[k]),
                "area_wanted_m2": float(found.wanted[k]),
            }
            for k in order(found)
        ],
        "checks": [
            {
                "name": name,
                "defined": defined,
                "spread": e.value,
                "interval": {"low": _ends(e)[0], "high": _ends(e)[1]},
            }
            for name, (defined, e) in checks.items()
        ],
    }


def _print(slopes: Slopes, slope: Slope, found: Matched, wanted: float, unit: str) -> None:
    value, now, then, asked, fixed = (
        format_quantity(x, unit)
        for x in (slope.value, found.spread_now, found.spread, wanted, found.fixed**0.5)
    )
    reached = then if math.isclose(wanted, found.spread, rel_tol=1e-6) else f"{asked}, {then} by least areas"
    print_line(f"{slopes.metric} {value}, spread over dies {now}, of which {fixed} are the process's")
    print_line(f"wanted spread {reached}; gradient by {by_what(slopes)}, {slopes.runs} runs\n")
    total = found.spread_now**2 or 1.0
    rows = [
        (
            found.devices[k], f"{100.0 * found.variance[k] / total:.1f} %",
            *(f"{x / SQUARE_MICROMETRE:.3g}" for x in (found.area[k], found.wanted[k])),
            f"{found.wanted[k] / found.area[k]:.3g}",
        )
        for k in order(found)[:LISTED]
    ]  # fmt: skip
    heads = ("device", "share of the variance:", "area, um^2:", "wanted, um^2:", "times:")
    print_table("devices, the most first", heads, rows)
    if len(found.devices) > LISTED:
        print_line(f"{len(found.devices) - LISTED} more devices; --json has all")
    before, after = (float(x.sum()) / SQUARE_MICROMETRE for x in (found.area, found.wanted))
    print_line(f"area of all devices {before:.4g} um^2, wanted {after:.4g} um^2, {after / before:.3g} times")
    if slope.note:
        print_line(f"{slopes.metric}: {slope.note}")
