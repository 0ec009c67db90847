"""Picture of what a script of the bench has measured: a panel a unit, over what was set."""

from __future__ import annotations

from typing import TYPE_CHECKING

from system.bench.run import Table
from system.plot import COLOURS, entitle

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_UNITS = {"V": "voltage (V)", "A": "current (A)", "counts": "counts"}


def draw_table(table: Table, title: str, figure: Figure) -> None:
    """Fill an empty figure with what was read over the first of what was set.

    Parameters
    ----------
    table
        What was measured.
    title
        What stands above.
    figure
        An empty figure, which is filled.
    """
    over, read = table.set_columns[0], [n for n in table.columns if n not in table.set_columns]
    units = [u for u in _UNITS if any(name.endswith(f"_{u}") for name in read)]
    figure.set_size_inches(7.5, 2.7 * len(units) + 0.6)
    stack = figure.subplots(len(units), 1, squeeze=False, sharex=True)[:, 0]
    for unit, ax in zip(units, stack, strict=True):
        for k, name in enumerate(n for n in read if n.endswith(f"_{unit}")):
            style = {"color": COLOURS[k % len(COLOURS)], "marker": ".", "markersize": 3.0, "linewidth": 1.0}
            ax.plot(table.columns[over], table.columns[name], label=name.rpartition("_")[0], **style)
        ax.set_ylabel(_UNITS[unit])
        ax.legend(frameon=False, fontsize="small")
    name, _, unit = over.rpartition("_")
    stack[-1].set_xlabel(f"{name} ({unit})")
    entitle(title, stack[0])
    figure.align_ylabels(stack)
