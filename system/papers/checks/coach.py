"""A process and a die from measurements of a teaching chip, judged on what each fit has not seen.

The measurements (`circuits/extraction/coach/data/fit`) are fitted together. Then each sweep of a transistor,
each repeated calibration, each of 16 cells and every fifth point of every other curve is left out in turn
and predicted with a band. In these rows `paper` is what was measured, or what is noted of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.extraction.coach.chip import Chip, extract_chip
from circuits.extraction.coach.conditions import Condition, read_conditions
from circuits.extraction.coach.left_out import SIGMAS, LeftOut, fitted_curve, left_out, share_inside
from circuits.extraction.coach.metrics import metrics_of
from circuits.extraction.coach.models import complete, measured
from circuits.extraction.coach.table import Table, read_folder
from circuits.silicon.process import ROLLS_180
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS, PALE, entitle
from system.rule import at_least, unjudged, within
from system.statement import Statement

GOAL = 0.90  # share of points inside the band
# what a good model is within, as the conditions of the measurements have it: relative, and A or V
TOLERANCES = {
    "fet_n_output_family": (0.03, 1e-6), "fet_n_ohmic_vg": (0.0, 1e-6), "fet_n_sat_vg": (0.0, 1.5e-6),
    "fet_n_sub_vg": (0.05, 15e-9), "fet_n_backgate": (0.0, 3e-3), "fet_p_ohmic_vg": (0.0, 2e-6),
    "fet_p_sat_vg": (0.0, 2e-6), "fet_p_sub_vg": (0.05, 20e-9), "fet_p_backgate": (0.0, 3e-3),
}  # fmt: skip
_COLUMNS = 5
_CUBIC = 3
_KAPPA = 0.02

Data = Mapping[str, tuple[Condition, Table]]


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A column of a measurement: measured, fitted, and predicted where left out, with half its band."""

    name: str
    measured: F64
    fitted: F64
    predicted: F64
    half: F64


def reproduce(progress: Progress, only: tuple[str, ...] = ()) -> Report:
    """Fit the measurements, leave each out in turn, and say where the prediction fails.

    Parameters
    ----------
    progress
        Is told the share that is done.
    only
        Names of the measurements; all unless given.
    """
    known = read_conditions()
    data = {n: d for n, d in read_folder(None, "fit", known).items() if not only or n in only}
    chip = extract_chip(data, known, ROLLS_180, "coach")
    progress(0.9)
    rows = list(left_out(chip.fit, known))
    curves = list(_curves(chip, data, rows))
    progress(1.0)
    statements = (*_coverage(rows, known), *_tolerances(chip, data), *_pair(chip, data), *_process(chip))
    return Report(statements, lambda figure: draw(curves, figure), notes=_notes(rows))


def _coverage(rows: list[LeftOut], known: Mapping[str, Condition]) -> Iterator[Statement]:
    yield Statement("points_inside_the_band_share", None, share_inside(rows), at_least(GOAL))
    for kind, names in (
        ("transistors", ("nfet", "pfet")), ("calibrations", ("converter",)), ("cells", ("ring-inputs",)),
        ("others", ()),
    ):  # fmt: skip
        named = ("nfet", "pfet", "converter", "ring-inputs")
        circuits = {r.key: known[r.key[0]].circuit for r in rows}
        rest = [r for r in rows if circuits[r.key] not in named]
        own = [r for r in rows if circuits[r.key] in names] if names else rest
        if own:
            yield Statement(
                f"inside_of_{kind}_share", None, share_inside(own), unjudged("a part of the above")
            )


def _tolerances(chip: Chip, data: Data) -> Iterator[Statement]:
    """Share of the usable points of each transistor's sweep that the fit itself has within its tolerance."""
    for m in measured(data):
        if m.condition.name not in TOLERANCES:
            continue
        ((column, kept),) = m.kept.items()
        block = chip.fit.blocks[m.condition.name, column]
        value, _ = fitted_curve(block, m.table[column], kept)
        relative, floor = TOLERANCES[m.condition.name]
        allowed = (
            np.maximum(relative * np.abs(m.table[column][kept]), floor)
            if relative < 0.05
            else (relative * np.abs(m.table[column][kept]) + floor)
        )
        share = float((np.abs(value - m.table[column][kept]) <= allowed).mean())
        yield Statement(f"{m.condition.name}_within_tolerance_share", 1.0, share, at_least(GOAL), fitted=True)
        if relative == 0.0 and column != "v_s_V":
            yield _scatter(m.condition.name, m.table["v_g_V"][kept], m.table[column][kept], floor)


def _scatter(name: str, gate: F64, read: F64, allowed: float) -> Statement:
    """Share of readings that a right curve has within a tolerance, A, by what a cubic leaves of them."""
    left = read - np.polyval(np.polyfit(gate, read, _CUBIC), gate)
    spread = float(np.sqrt((left**2).sum() / (gate.size - _CUBIC - 1)))
    text = unjudged(f"what readings that scatter by {1e6 * spread:.2g} uA about a cubic allow any curve")
    return Statement(
        f"{name}_scatter_allows_share", None, math.erf(allowed / (math.sqrt(2.0) * spread)), text
    )


def _pair(chip: Chip, data: Data) -> Iterator[Statement]:
    if "ndp_run1" not in data:
        return
    condition, table = data["ndp_run1"]
    found: dict[str, F64] = {}
    for name in ("n1_counts", "n2_counts"):
        block, kept = chip.fit.blocks["ndp_run1", name], np.abs(table["v1_V"] - table["v2_V"]) < 0.15
        found[name] = np.full(kept.size, np.nan)
        found[name][kept] = fitted_curve(block, table[name], kept)[0]
    ours = metrics_of(condition, Table({**table, **complete(condition, found)}))["kappa"].value
    theirs = metrics_of(condition, table)["kappa"].value
    yield Statement("ndp_run1_kappa", theirs, ours, within(_KAPPA), fitted=True)


def _process(chip: Chip) -> Iterator[Statement]:
    posterior = chip.fit.posterior
    for k, unknown in enumerate(posterior.unknowns):
        if unknown.kind == "process" and unknown.name not in chip.free:
            text = f"standard error {posterior.sd[k]:.2g}"
            name, value = unknown.name.replace(" ", "_"), float(posterior.mean[k])
            yield Statement(name, None, value, unjudged(text), fitted=True)
    if chip.a_vt is not None:
        error = unjudged(f"standard error {1e9 * chip.a_vt[1]:.2g}")
        yield Statement("pair_a_vt_mV_um", None, 1e9 * chip.a_vt[0], error, fitted=True)


def _notes(rows: list[LeftOut]) -> tuple[str, ...]:
    """Where the band fails: groups of which fewer than nine in ten points lie inside."""
    by_name: dict[str, list[LeftOut]] = {}
    for row in rows:
        by_name.setdefault(row.key[0], []).append(row)
    bad = {name: share_inside(own) for name, own in by_name.items() if share_inside(own) < GOAL}
    said = [f"{name}: {100 * share:.0f} % of points inside the band" for name, share in sorted(bad.items())]
    return (*said, "leaving out is one step of Gauss and Newton from the fit of all, not a fit of its own")


def _curves(chip: Chip, data: Data, rows: list[LeftOut]) -> Iterator[Curve]:
    for m in measured(data):
        for column, kept in m.kept.items():
            key = m.condition.name, column
            block = chip.fit.blocks[key]
            fitted, noise = fitted_curve(block, m.table[column], kept)
            predicted, half = np.full(noise.size, np.nan), np.full(noise.size, np.nan)
            for row in rows:
                if row.key == key:
                    points = row.points
                    predicted[points] = m.table[column][kept][points] - row.off * noise[points]
                    half[points] = SIGMAS * row.sd * noise[points]
            yield Curve(f"{m.condition.name} {column}", m.table[column][kept], fitted, predicted, half)


def draw(curves: list[Curve], figure: Figure) -> None:
    """Fill a figure with all curves: measured as points, predicted as a line, its band.

    Parameters
    ----------
    curves
        What was measured and what was predicted, a panel each.
    figure
        The figure, empty.
    """
    rows = math.ceil(len(curves) / _COLUMNS)
    figure.set_size_inches(3.4 * _COLUMNS, 2.1 * rows)
    grid = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
    for axes, curve in zip(grid, curves, strict=False):
        x = np.arange(curve.measured.size)
        low, high = curve.predicted - curve.half, curve.predicted + curve.half
        if x.size == 1:  # a number, of which neither a band nor a line would be seen
            axes.errorbar(
                x, curve.predicted, curve.half, color=COLOURS[0], ecolor=PALE, elinewidth=6, marker="_"
            )
            axes.set_xticks([0])
        axes.fill_between(x, low, high, color=PALE, linewidth=0, label="95 % band")
        axes.plot(x, curve.predicted, "-", color=COLOURS[0], linewidth=0.8, label="predicted without it")
        axes.plot(x, curve.measured, ".", color=COLOURS[1], markersize=2.5, label="measured")
        entitle(curve.name, axes)
        axes.set_xlabel("point")
    grid[0].legend(fontsize="small", frameon=False)
    for axes in grid[len(curves) :]:
        axes.set_axis_off()


EXPERIMENT = Experiment(
    "coach", "a process and a die from a teaching chip's measurements, each left out in turn", reproduce
)
