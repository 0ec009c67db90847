"""Pictures of a study: its outcomes, and a histogram of each metric with the limits of the specifications."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from system.plot import COLOURS, INK, PALE, entitle
from system.study.specification import Limits, Specification
from system.study.table import Table, counted
from system.study.target import Quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ticker, special, stats = later("matplotlib.ticker"), later("scipy.special"), later("scipy.stats")

MOST_BINS = 60
TICKS = 5
_FEWEST = 3  # values of which a distribution can be told
_DASHES = {"at least": "-", "at most": "-."}


def draw_study(
    table: Table,
    quantities: Sequence[Quantity],
    specifications: Sequence[Specification],
    figure: Figure,
    title: str = "",
) -> None:
    """Fill a figure with the outcomes as bars, and a histogram of each of the quantities.

    Parameters
    ----------
    table
        Samples of the study.
    quantities
        What was measured.
    specifications
        Limits that are drawn.
    figure
        An empty figure, which is filled.
    title
        What stands above it.
    """
    panels = 1 + len(quantities)
    figure.set_size_inches(8.0, max(2.2 * panels, 4.5))
    axes = figure.subplots(panels, 1, squeeze=False)[:, 0]
    entitle(title, axes[0])
    outcomes(table, axes[0])
    for ax, quantity in zip(axes[1:], quantities, strict=True):
        histogram(table, quantity, specifications, ax)
        if ax.get_legend_handles_labels()[0]:
            ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8)
    figure.align_ylabels(axes)


def outcomes(table: Table, ax: Axes) -> None:
    """Draw the number of samples of each class as bars, the most frequent class on top."""
    counts = counted(table.outcome)
    ax.barh(list(counts), list(counts.values()), color=COLOURS[0])
    ax.invert_yaxis()
    ax.set_xlabel(f"samples of {len(table)}")
    ax.xaxis.set_major_locator(ticker.MaxNLocator(integer=True))


def histogram(table: Table, quantity: Quantity, specifications: Sequence[Specification], ax: Axes) -> None:
    """Draw the histogram of a metric with its mean and limits; a yes-or-no metric is drawn as two bars.

    The axis is logarithmic where `is_log_normal`; whole numbers have a bar each.
    """
    x = values_of(table, quantity)
    ax.set_ylabel("samples")
    ax.yaxis.set_major_locator(ticker.MaxNLocator(TICKS, integer=True))
    if quantity.yes_no:
        ax.bar(["no", "yes"], [int((x == value).sum()) for value in (0.0, 1.0)], color=COLOURS[0])
        ax.set_xlabel(quantity.name)
        return
    if x.size:
        ax.hist(x, bins=_edges(x).tolist(), color=COLOURS[0], rwidth=0.8 if _whole(x) else None)
        mean = float(x.mean())
        ax.axvline(mean, color=INK, lw=1, ls="--", label=f"mean {_text(mean, quantity)}")
    for limits in specifications:
        if isinstance(limits, Limits) and limits.metric == quantity.name:
            for end, word in ((limits.low, "at least"), (limits.high, "at most")):
                if math.isfinite(end):
                    label = f"{word} {_text(end, quantity)}"
                    ax.axvline(end, color=COLOURS[1], lw=1.5, ls=_DASHES[word], label=label)
    _name(ax, "x", quantity, x)


def normal_quantiles(table: Table, quantity: Quantity, ax: Axes) -> None:
    """Draw the sorted values of a metric against the normal quantiles of their ranks.

    A line shows the normal distribution of the same mean and standard deviation, of the logarithms where
    `is_log_normal`.
    """
    x = np.sort(values_of(table, quantity))
    if x.size < _FEWEST:
        ax.text(0.5, 0.5, "fewer than three defined values", ha="center", transform=ax.transAxes)
        return
    z = special.ndtri((np.arange(x.size) + 0.5) / x.size)
    ax.plot(z, x, ".", color=COLOURS[0], ms=3)
    logs = is_log_normal(x)
    y = np.log(x) if logs else x
    line = y.mean() + y.std(ddof=1) * z[[0, -1]]
    ax.plot(z[[0, -1]], np.exp(line) if logs else line, color=PALE, lw=2)
    ax.set_xlabel("normal quantile (sigma)")
    _name(ax, "y", quantity, x)


def values_of(table: Table, quantity: Quantity) -> F64:
    """Values of a metric that are defined and finite, float64[n]."""
    x = table.column(quantity.name)
    return x[np.isfinite(x)]


def is_log_normal(values: F64) -> bool:
    """Say whether the logarithms of values, float64[n], are nearer to a normal distribution than the values.

    Both are judged by the correlation with the quantiles of a normal distribution (Filliben 1975). Values
    that are not above 0, whole, few, or within a factor of two stay as they are.
    """
    if values.size < _FEWEST or values.min() <= 0.0 or values.max() < 2.0 * values.min() or _whole(values):
        return False
    plain, logs = (float(stats.probplot(y)[1][2]) for y in (values, np.log(values)))
    return logs > plain


def _whole(x: F64) -> bool:
    return bool(x.size) and bool((x == np.round(x)).all())


def _edges(x: F64) -> F64:
    """Edges of the bars: one for each of a few whole numbers, even on a logarithmic axis too."""
    if _whole(x) and np.ptp(x) < MOST_BINS:
        return np.arange(x.min() - 0.5, x.max() + 1.0)
    if np.ptp(x) == 0.0:  # as wide as matplotlib shows about a line; numpy's bar is 1 wide, whatever the unit
        return np.sort(x[0] * np.array([0.95, 1.05]))
    logs = is_log_normal(x)
    y = np.log(x) if logs else x
    found = np.histogram_bin_edges(y, "auto") if y.size > 1 else np.histogram_bin_edges(y, 1)
    if found.size - 1 > MOST_BINS:
        found = np.histogram_bin_edges(y, MOST_BINS)
    if logs:
        found = np.exp(found)
        found[[0, -1]] = x.min(), x.max()  # which rounding may have left outside
    return np.asarray(found)


def _text(value: float, quantity: Quantity) -> str:
    """A value with three digits, in the quantity's unit with a prefix."""
    return ticker.EngFormatter(quantity.unit, places=2)(value) if quantity.unit else f"{value:.3g}"


def _name(ax: Axes, side: Literal["x", "y"], quantity: Quantity, x: F64) -> None:
    """Label an axis; its few ticks are in the quantity's unit with a prefix, or plain numbers."""
    axis = ax.xaxis if side == "x" else ax.yaxis
    axis.set_label_text(quantity.name.replace("_", " "))
    if is_log_normal(x):
        ax.set(**{f"{side}scale": "log"})
        axis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0), numticks=3 * TICKS))
        axis.set_major_formatter(
            ticker.EngFormatter(quantity.unit) if quantity.unit else ticker.StrMethodFormatter("{x:g}")
        )
        axis.set_minor_formatter(ticker.NullFormatter())
        return
    axis.set_major_locator(ticker.MaxNLocator(TICKS, integer=_whole(x), min_n_ticks=1))
    if quantity.unit:
        axis.set_major_formatter(ticker.EngFormatter(quantity.unit))
