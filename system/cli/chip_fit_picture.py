"""The picture of a fit to a chip's measurements: the residuals of each column over its points."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from circuits.extraction.coach.conditions import Condition
from circuits.extraction.coach.joint import Fit
from circuits.extraction.coach.table import Table
from system.plot import COLOURS, INK, PALE, entitle

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS = 5
_BAND = 1.96  # standard deviations


def draw_fit(fit: Fit, data: Mapping[str, tuple[Condition, Table]], figure: Figure) -> None:
    """Fill a figure with residuals over their noise, an axes a measurement.

    Parameters
    ----------
    fit
        The fit.
    data
        Its measurements, by name.
    figure
        The figure.
    """
    names = [name for name in data if any(key[0] == name for key in fit.blocks)]
    rows = math.ceil(len(names) / _COLUMNS)
    figure.set_size_inches(3.0 * _COLUMNS, 2.2 * rows)
    grid = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
    for axes, name in zip(grid, names, strict=False):
        own = [block.residual for key, block in fit.blocks.items() if key[0] == name]
        for colour, residual in zip(COLOURS * (1 + len(own) // len(COLOURS)), own, strict=False):
            axes.plot(np.arange(residual.size), residual, ".", color=colour, markersize=3)
        axes.axhspan(-_BAND, _BAND, color=PALE, linewidth=0.0)
        axes.axhline(0.0, color=INK, linewidth=0.5)
        entitle(name, axes)
    for axes in grid[len(names) :]:
        axes.set_axis_off()
    figure.supxlabel("point that was fitted")
    figure.supylabel("residual over its noise")
