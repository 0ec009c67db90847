"""What second-order effects of silicon do to every block: each effect by itself, and all together.

No figure of a paper. Every block runs its own testbench on the nominal die at 27 degC under the ideal law,
the papers' equations, and under the full law of its process (`circuits.silicon.process`). In these rows
`paper` is the number under the ideal law and the rule tells how far the full law moves it; none passes or
fails. The picture has the first number of each block that is no count, with each effect alone: body effect,
Early effect, mobility reduction, and leakage of junctions with what gates induce.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.colors import SymLogNorm
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.blocks.block import Block
from circuits.registry import block_names, load_block
from circuits.silicon.process import SECOND_ORDER, Process, TransistorModel
from circuits.silicon.process_file import process_under
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from system.experiment import Experiment, Progress, Report, with_progress
from system.rule import unjudged
from system.statement import Statement

EFFECTS: Mapping[str, tuple[str, ...]] = {
    "body effect": ("law",),
    "Early effect": ("early_field", "early_rise"),
    "mobility": ("mobility_reduction",),
    "leakage": ("junction_leakage", "gate_induced_leakage"),
    "all": ("law", *SECOND_ORDER),
}
LARGEST = 100.0  # %, end of the picture's colours
LINEAR = 1.0  # %, up to where they are linear


def run(progress: Progress) -> Report:
    """Run every block under every effect by itself, and under all."""
    rows: list[Statement] = []
    shifts: dict[str, list[float]] = {}
    for name in with_progress(block_names(), progress):
        block = load_block(name)
        ideal, *others = [_measured(block, fields) for fields in ((), *EFFECTS.values())]
        rows += [_row(name, metric, value, others[-1].get(metric)) for metric, value in ideal.items()]
        first = next((m for m, value in ideal.items() if value and not float(value).is_integer()), None)
        if first is not None:
            shifts[f"{name}: {first}"] = [percent(ideal[first], found.get(first)) for found in others]
    return Report(tuple(rows), lambda figure: draw_shifts(shifts, figure))


def _measured(block: Block, fields: tuple[str, ...]) -> dict[str, float | None]:
    """Numbers of a block's testbench with some fields of its process's law, the others ideal."""
    silicon = Silicon(with_effects(process_under(block.process, None, "full"), fields))
    found: Mapping[str, Any] = block.measures(simulate(block.bench(), silicon))
    return {name: value for name, value in found.items() if value is None or isinstance(value, int | float)}


def with_effects(process: Process, fields: tuple[str, ...]) -> Process:
    """Return a process with some of its second-order effects, by their fields."""

    def model(whole: TransistorModel) -> TransistorModel:
        kept: dict[str, Any] = {name: getattr(whole, name) for name in fields}
        return replace(whole.ideal(), **kept)

    return replace(process, n=model(process.n), p=model(process.p))


def percent(ideal: float | None, full: float | None) -> float:
    """Return by how much a number is moved from the ideal law's, %, nan where there is none."""
    return 100.0 * (full / ideal - 1.0) if ideal and full is not None else float("nan")


def _row(block: str, metric: str, ideal: float | None, full: float | None) -> Statement:
    moved = percent(ideal, full)
    text = f"moved by {moved:+.3g} %" if np.isfinite(moved) else "no share of it is defined"
    return Statement(f"{block.replace('-', '_')}_{metric}", ideal, full, unjudged(text))


def draw_shifts(shifts: Mapping[str, list[float]], figure: Figure) -> None:
    """Draw how far each effect moves each number, %, by name."""
    figure.set_size_inches(7.0, 1.2 + 0.24 * len(shifts))
    ax = figure.add_subplot()
    values: F64 = np.array(list(shifts.values()))
    norm = SymLogNorm(LINEAR, vmin=-LARGEST, vmax=LARGEST)
    image = ax.imshow(values, aspect="auto", cmap="PuOr", norm=norm)
    for (row, column), value in np.ndenumerate(values):
        dark = abs(norm(value) - 0.5) > 0.35
        text = f"{value:+.1f}" if np.isfinite(value) else "none"
        ax.text(column, row, text, ha="center", va="center", fontsize=7, color="white" if dark else "black")
    ax.set_xticks(range(len(EFFECTS)), EFFECTS)
    ax.set_yticks(range(len(shifts)), [name.replace("_", " ") for name in shifts], fontsize=7)
    ax.xaxis.tick_top()
    ax.set_title("change from the ideal law, %", pad=22)
    figure.colorbar(image, ax=ax, label="%", extend="both", ticks=[-100, -10, -1, 0, 1, 10, 100], format="%g")


EXPERIMENT = Experiment("second-order", "what second-order effects of silicon do to every block", run)
