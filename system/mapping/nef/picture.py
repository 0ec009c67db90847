"""Pictures of a network of values on the NEF chip: its neurons, what is decoded of them, and a run of it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from chips.nef.network.kernel import DT
from chips.nef.network.network import Connection, Probe, label
from chips.nef.population import Population
from circuits.arrays import F64
from system.mapping.nef.findings import decoded
from system.mapping.nef.mapped import MappedValues
from system.mapping.nef.run import ValueRun
from system.plot import COLOURS, INK, PALE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

SHOWN = 24  # neurons of an ensemble whose curves are drawn; ours
_LOOKS = {"asked": (PALE, "-", 2.2), "ideal": (INK, "--", 0.8), "chip": (COLOURS[0], "-", 0.9)}
_NAMES = {"asked": "asked for", "ideal": "ideal neurons", "chip": "on the die"}


def draw_values(mapped: MappedValues, figure: Figure) -> None:
    """Fill `figure` with the nominal die's tuning curves, and with what is decoded beside what should be."""
    held = list(mapped.built.populations.items())
    ways = list(_ways(mapped))
    figure.set_size_inches(max(2.4 * max(len(held), len(ways)), 5.0), 5.2)
    parts = figure.subfigures(2, 1, squeeze=False)[:, 0]
    for ax, (name, (p,)) in zip(_row(parts[0], len(held)), held, strict=True):
        _draw_curves(p, name, ax)
    for ax, (name, wanted, got) in zip(_row(parts[1], len(ways)), ways, strict=True):
        _draw_decoded(name, wanted, got, ax)


def _row(part: SubFigure, count: int) -> list[Axes]:
    return list(part.subplots(1, count, squeeze=False)[0]) if count else []


def _ways(mapped: MappedValues) -> Iterator[tuple[str, F64, F64]]:
    """Each connection and probe, with what should be decoded and what is."""
    every: list[Connection | Probe] = [*mapped.built.network.connections, *mapped.built.network.probes]
    for one in every:
        if one in mapped.built.solved:
            name = one.name if isinstance(one, Probe) else label(one)
            yield name, *decoded(mapped.built, one, name)


def _draw_curves(p: Population, name: str, ax: Axes) -> None:
    """Rates of some neurons over x along their encoders, in radii."""
    for k in np.linspace(0, p.ensemble.neurons - 1, min(SHOWN, p.ensemble.neurons)).astype(int):
        along = p.points @ p.encoders[k] / p.ensemble.radius
        order = np.argsort(along)
        ax.plot(along[order], p.rates[order, k], linewidth=0.6, color=COLOURS[k % len(COLOURS)])
    ax.set(title=f"{name}, {p.ensemble.neurons} neurons", xlabel="x along the encoder (radii)")
    ax.set_ylabel("rate (Hz)")


def _draw_decoded(name: str, wanted: F64, got: F64, ax: Axes) -> None:
    low, high = float(wanted.min()), float(wanted.max())
    ax.plot([low, high], [low, high], color=PALE, linewidth=2.0)
    for k in range(wanted.shape[1]):
        ax.plot(wanted[:, k], got[:, k], ".", markersize=1.5, color=COLOURS[k % len(COLOURS)])
    ax.set(title=name, xlabel="f(x)", ylabel="decoded")


def draw_value_run(run: ValueRun, title: str, figure: Figure) -> None:
    """Fill `figure` with each output in all three runs."""
    figure.set_size_inches(8.0, 1.2 + 1.9 * max(len(run.chip), 1))
    axes = figure.subplots(max(len(run.chip), 1), 1, sharex=True, squeeze=False)[:, 0]
    for ax, name in zip(axes, run.chip, strict=False):
        for key, (colour, dashes, width) in _LOOKS.items():
            values: F64 = getattr(run, key)[name]
            times = DT * np.arange(1, len(values) + 1)
            lines = ax.plot(times, values, color=colour, linestyle=dashes, linewidth=width)
            lines[0].set_label(_NAMES[key])
        ax.set_ylabel(name)
    axes[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=8, ncols=3)  # above, off the curves
    axes[-1].set_xlabel("time (s)")
    figure.suptitle(title, fontsize=10)
