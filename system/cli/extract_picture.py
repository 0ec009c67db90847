"""The picture of an extraction: currents over the gate on a logarithmic axis, and how far the law is off."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from circuits.extraction.extraction import Extraction
from circuits.extraction.fit import law_current
from circuits.extraction.points import Points
from circuits.silicon.process import Polarity
from system.plot import COLOURS, INK, PALE, entitle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIZES = 5  # that have a colour of their own
_NEAR = 1e-6  # V and K, within which points are of one curve


def draw_extraction(found: Extraction, figure: Figure) -> None:
    """Fill a figure with a row of two axes a polarity: currents at one condition, and errors at all.

    Parameters
    ----------
    found
        What was extracted; its sizes that were not fitted are drawn where there are some.
    figure
        The figure.
    """
    figure.set_size_inches(11.0, 4.2 * len(found.fitted))
    grid = figure.subplots(len(found.fitted), 2, squeeze=False)
    for (currents, errors), polarity in zip(grid, found.fitted, strict=True):
        points = found.held_out.get(polarity, found.points[polarity])
        _draw_currents(found, polarity, points, currents)
        _draw_errors(found, polarity, points, errors)


def _draw_currents(found: Extraction, polarity: Polarity, points: Points, axes: Axes) -> None:
    """Points and the law's lines at the middle temperature, the highest drain and the lowest source."""
    middle = np.median(np.unique(points.temperature_c))
    celsius = float(points.temperature_c[np.argmin(np.abs(points.temperature_c - middle))])
    here = points.where(np.abs(points.temperature_c - celsius) < _NEAR)
    here = here.where(np.abs(here.v_s - here.v_s.min()) < _NEAR)
    here = here.where(np.abs(here.v_d - here.v_d.max()) < _NEAR)
    for colour, size in zip(COLOURS[:_SIZES], here.sizes(), strict=False):
        own = here.of_size(size)
        label = f"{1e6 * size[0]:.3g} µm by {1e6 * size[1]:.3g} µm"
        axes.semilogy(own.v_g, own.current, ".", color=colour, markersize=4, label=label)
        law = law_current(found.process.model(polarity), found.process, own)
        axes.semilogy(own.v_g, law, "-", color=colour, linewidth=0.9)
    axes.set(xlabel="gate to bulk (V)", ylabel=f"drain current, {polarity}FET (A)")
    where = f"{celsius:g} °C, drain {here.v_d.max():.3g} V"
    entitle(f"{found.process.name}, {where}; law as lines", axes)
    axes.legend(fontsize=8)
    axes.grid(color=PALE, linewidth=0.4)


def _draw_errors(found: Extraction, polarity: Polarity, points: Points, axes: Axes) -> None:
    """Error of the law over the current at all conditions, a colour a size."""
    model = found.process.model(polarity)
    for colour, size in zip(COLOURS[:_SIZES], points.sizes(), strict=False):
        own = points.of_size(size)
        off = 100.0 * (law_current(model, found.process, own) / own.current - 1.0)
        axes.semilogx(own.current, off, ".", color=colour, markersize=2)
    away = found.judged(polarity)
    for level in (-10.0, 10.0):
        axes.axhline(level, color=INK, linewidth=0.5, linestyle="--")
    axes.set(xlabel="drain current (A)", ylabel="law off (%)")
    entitle(f"median {100 * away.median:.1f} %, worst {100 * away.worst:+.0f} %", axes)
    axes.grid(color=PALE, linewidth=0.4)
