"""Pictures of a study: its outcomes, and a histogram of each metric with the limits of the specifications."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, MaxNLocator
from scipy.special import ndtri

from system.plot import COLOURS, INK, PALE
from system.study.specification import Limits, Specification
from system.study.table import Table, counted
from system.study.target import Quantity

MOST_BINS = 60
TICKS = 5


def draw_study(
    table: Table, quantities: Sequence[Quantity], specifications: Sequence[Specification], figure: Figure
) -> None:
    """Draw the samples of a study: the outcomes as bars, and a histogram of each of the quantities.

    Parameters
    ----------
    table
        The samples.
    quantities
        Metrics with a histogram each.
    specifications
        Limits that the histograms show.
    figure
        An empty figure, which is filled.
    """
    axes = figure.subplots(1 + len(quantities), 1, squeeze=False)[:, 0]
    outcomes(table, axes[0])
    for ax, quantity in zip(axes[1:], quantities, strict=True):
        histogram(table, quantity, specifications, ax)
    figure.align_ylabels(axes)


def outcomes(table: Table, ax: Axes) -> None:
    """Draw the number of samples of each class as bars, the most frequent class on top."""
    counts = counted(table.outcome)
    ax.barh(list(counts), list(counts.values()), color=COLOURS[0])
    ax.invert_yaxis()
    ax.set_xlabel(f"samples of {len(table)}")
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))


def histogram(table: Table, quantity: Quantity, specifications: Sequence[Specification], ax: Axes) -> None:
    """Draw the histogram of a metric with its mean and limits; a yes-or-no metric is drawn as two bars."""
    x = table.column(quantity.name)
    x = x[np.isfinite(x)]
    ax.set_ylabel("samples")
    ax.yaxis.set_major_locator(MaxNLocator(TICKS, integer=True))
    if quantity.yes_no:
        ax.bar(["no", "yes"], [int((x == value).sum()) for value in (0.0, 1.0)], color=COLOURS[0])
        ax.set_xlabel(quantity.name)
        return
    if x.size:
        edges = np.histogram_bin_edges(x, "auto") if x.size > 1 else np.array([])
        bins = min(max(edges.size - 1, 1), MOST_BINS)
        ax.hist(x, bins=bins, color=COLOURS[0])
        ax.axvline(float(x.mean()), color=INK, lw=1, ls="--")
    for limits in specifications:
        if isinstance(limits, Limits) and limits.metric == quantity.name:
            for end in (limits.low, limits.high):
                if math.isfinite(end):
                    ax.axvline(end, color=COLOURS[1], lw=1.5)
    _name(ax.xaxis, quantity)


def normal_quantiles(table: Table, quantity: Quantity, ax: Axes) -> None:
    """Draw the sorted values of a metric against the normal quantiles of their ranks.

    A line shows the normal distribution of the same mean and standard deviation.
    """
    x = table.column(quantity.name)
    x = np.sort(x[np.isfinite(x)])
    if x.size < 3:
        ax.text(0.5, 0.5, "fewer than three defined values", ha="center", transform=ax.transAxes)
        return
    z = ndtri((np.arange(x.size) + 0.5) / x.size)
    ax.plot(z, x, ".", color=COLOURS[0], ms=3)
    ax.plot(z[[0, -1]], x.mean() + x.std(ddof=1) * z[[0, -1]], color=PALE, lw=2)
    ax.set_xlabel("normal quantile (sigma)")
    _name(ax.yaxis, quantity)


def _name(axis: Axis, quantity: Quantity) -> None:
    """Label an axis, its few ticks in the quantity's unit with a prefix."""
    axis.set_label_text(quantity.name)
    axis.set_major_locator(MaxNLocator(TICKS))
    axis.set_major_formatter(EngFormatter(unit=quantity.unit))
