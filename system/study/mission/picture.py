"""Pictures of a mission: its yields over temperature, and what its failures come from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import F64
from system.plot import COLOURS, entitle
from system.study.mission.found import Found

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIDE = 0.12  # degC between kinds of bias at one temperature, times their number; of sight alone


def draw_mission(found: Sequence[Found], figure: Figure, title: str = "") -> None:
    """Fill a figure with the yields of a mission's ways over temperature, and with their failures' causes.

    Parameters
    ----------
    found
        What was found of each way.
    figure
        An empty figure, which is filled.
    title
        What stands above it.
    """
    figure.set_size_inches(9.0, 3.6)
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    entitle(title, left)
    draw_yields(found, left)
    draw_causes(found, right)


def draw_yields(found: Sequence[Found], ax: Axes) -> None:
    """Draw yields with their intervals.

    Over several temperatures there is a line for each kind of bias and each change, else a point for each.
    """
    lines: dict[str, list[Found]] = {}
    for each in found:
        name = ", ".join(filter(None, (each.way.bias_kind, each.way.change))) or "yield"
        lines.setdefault(name, []).append(each)
    if len({each.way.temperature_c for each in found}) > 1:
        _lines(lines, ax)
    else:
        _points({name: row[0] for name, row in lines.items()}, ax)


def _lines(lines: Mapping[str, Sequence[Found]], ax: Axes) -> None:
    for k, (name, row) in enumerate(lines.items()):
        values, reach = _reach(row)
        at = np.array([each.way.temperature_c for each in row]) + _SIDE * (k - 0.5 * (len(lines) - 1))
        style = "o--" if row[0].way.change else "o-"
        colour = COLOURS[k % len(COLOURS)]
        ax.errorbar(at, values, reach, fmt=style, color=colour, label=name, capsize=3, lw=1.2)
    ax.set_xlabel("temperature (°C)")
    ax.set_ylabel("yield (%)")
    ax.set_ylim(0.0, 103.0)
    ax.legend(fontsize=8)


def _points(ways: Mapping[str, Found], ax: Axes) -> None:
    values, reach = _reach(list(ways.values()))
    ax.errorbar(values, range(len(ways)), xerr=reach, fmt="o", color=COLOURS[0], capsize=3, lw=1.2)
    ax.set_yticks(range(len(ways)), list(ways), fontsize=8)
    ax.set_ylim(len(ways) - 0.5, -0.5)
    ax.set_xlim(0.0, 103.0)
    celsius = next((each.way.temperature_c for each in ways.values()), 0.0)
    ax.set_xlabel(f"yield at {celsius:g} °C (%)")


def _reach(row: Sequence[Found]) -> tuple[F64, F64]:
    """Yields in percent, float64[n], and how far their intervals reach below and above, float64[2, n]."""
    estimates = [each.estimate for each in row]
    values = np.array([100.0 * e.value for e in estimates])
    ends = np.array([[100.0 * e.interval.low, 100.0 * e.interval.high] for e in estimates])
    return values, np.abs(ends - values[:, None]).T


def draw_causes(found: Sequence[Found], ax: Axes) -> None:
    """Draw for each way without a change what share of its failures die, world and noise caused."""
    rows = [(each, each.causes) for each in found if not each.way.change]
    names = list(dict.fromkeys(cause.name for _, causes in rows for cause in causes))
    left = np.zeros(len(rows))
    for k, name in enumerate(names):
        shares = np.array(
            [next((100.0 * c.share for c in causes if c.name == name), 0.0) for _, causes in rows]
        )
        ax.barh(range(len(rows)), shares, 0.5, left=left, color=COLOURS[k % len(COLOURS)], label=name)
        left += shares
    ax.set_yticks(range(len(rows)), [each.way.name for each, _ in rows], fontsize=8)
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.set_xlim(0.0, 100.0)
    ax.set_xlabel("failures caused by (%)")
    if names:
        ax.legend(fontsize=8, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
