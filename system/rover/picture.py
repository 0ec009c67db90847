"""Pictures of a rover: the cost map in m, planned and driven ways on it, and a scale bar."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from system.plot import COLOURS, INK
from system.rover.cost_map import MAX_CODE, CostMap
from system.view.film import Shape

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

matplotlib, colors = later("matplotlib"), later("matplotlib.colors")
patheffects = later("matplotlib.patheffects")

_SCALE_BAR = 10.0  # m, as in the paper's Figures 7 to 10
_BLOCKED = "#4A4A4A"
_LISTED = 12  # different costs that the colour bar names one by one


def draw_map(cost_map: CostMap, figure: Figure | None, ax: Axes) -> None:
    """Draw costs as shades, alike on all maps, low is pale; blocked cells are dark grey.

    With `figure` a colour bar names the costs.
    """
    rows, columns = cost_map.shape
    levels = np.unique(cost_map.costs)
    if len(levels) > _LISTED:
        levels = np.unique(np.geomspace(1, max(int(levels[-1]), 1), _LISTED).round()).astype(np.int64)
        levels = np.concatenate([[0], levels]) if (cost_map.costs == 0).any() else levels
    place = np.searchsorted(levels, cost_map.costs, side="right") - 1
    norm = colors.BoundaryNorm(np.arange(len(levels) + 1) - 0.5, len(levels))
    palette = colors.ListedColormap([_shade(int(level)) for level in levels])
    image = ax.imshow(place, cmap=palette, norm=norm, extent=_extent(cost_map), zorder=0)
    if figure is not None:
        bar = figure.colorbar(image, ax=ax, shrink=0.7, label="cost of a cell")
        bar.set_ticks(list(range(len(levels))), labels=[str(v) if v else "blocked" for v in levels.tolist()])
        bar.minorticks_off()
    ax.set_xlim(0.0, columns * cost_map.cell_width)
    ax.set_ylim(0.0, rows * cost_map.cell_height)
    ax.set_aspect("equal")


def _shade(cost: int) -> tuple[float, float, float, float] | str:
    """Colour of a cost: its logarithm, up to the largest code of a chip."""
    if cost == 0:
        return _BLOCKED
    red, green, blue, alpha = matplotlib.colormaps["YlOrBr"](
        0.03 + 0.8 * min(math.log(cost) / math.log(MAX_CODE), 1.0)
    )
    return red, green, blue, alpha


def draw_ways(planned: F64, driven: Sequence[F64], ax: Axes, reach: float | None = None) -> None:
    """Draw a planned way in black, driven ones in colours, float64[n, 2] in m each; mark start and goal.

    reach: m about the goal, within which a fix means that the rover has arrived; None draws no circle.
    """
    for k, way in enumerate(driven):
        ax.plot(*way.T, color=COLOURS[k % 4], linewidth=1.3, zorder=3, label="driven" if k == 0 else None)
    reached = np.concatenate([planned, *driven])
    ax.set_xlim(*_covering(ax.get_xlim(), reached[:, 0]))
    ax.set_ylim(*_covering(ax.get_ylim(), reached[:, 1]))
    ax.plot(*planned.T, color=INK, linewidth=1.4, zorder=2, label="planned", path_effects=_halo())
    for point, mark, name in ((planned[0], "o", "start"), (planned[-1], "*", "goal")):
        size = 6.0 if mark == "o" else 11.0
        ax.plot(*point, marker=mark, color=INK, markersize=size, linestyle="", zorder=4, label=name)
    if reach is not None:
        turn = np.linspace(0.0, 2.0 * np.pi, 100)
        circle = planned[-1] + reach * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        label = f"arrived with a fix within {reach:g} m"
        ax.plot(*circle.T, color=INK, linestyle="--", linewidth=1.0, zorder=4, label=label)


def draw_scale_bar(cost_map: CostMap, ax: Axes, *, label: bool = True) -> None:
    """Draw 10 m along each axis in the south-west corner."""
    rows, columns = cost_map.shape
    east, north = 0.03 * columns * cost_map.cell_width, 0.03 * rows * cost_map.cell_height
    ways = [east, east, east + _SCALE_BAR], [north + _SCALE_BAR, north, north]
    ax.plot(*ways, color=INK, linewidth=2.0, zorder=5, path_effects=_halo())
    if label:
        at = ax.annotate(f"{_SCALE_BAR:g} m", (east + _SCALE_BAR, north), (4, 2), textcoords="offset points")
        at.set(fontsize=8, zorder=5, path_effects=_halo())


def _covering(limits: tuple[float, float], values: F64) -> tuple[float, float]:
    """Limits that hold all values too, with a metre to spare beyond the map."""
    low, high = float(values.min()) - 1.0, float(values.max()) + 1.0
    return min(limits[0], low), max(limits[1], high)


def _extent(cost_map: CostMap) -> tuple[float, float, float, float]:
    rows, columns = cost_map.shape
    return 0.0, columns * cost_map.cell_width, 0.0, rows * cost_map.cell_height


def map_shapes(cost_map: CostMap) -> list[Shape]:
    """Return a map's costs as areas for a film: cells beside each other of one cost are one."""
    rows, _ = cost_map.shape
    wide, high = cost_map.cell_width, cost_map.cell_height
    found = []
    for row in range(rows):
        costs, low = cost_map.costs[row], (rows - 1 - row) * high
        edges = np.concatenate([[0], np.flatnonzero(np.diff(costs)) + 1, [costs.size]])
        for begin, end in pairwise(edges.tolist()):
            left, right = begin * wide, end * wide
            corners = ((left, low), (right, low), (right, low + high), (left, low + high))
            cost = int(costs[begin])
            name = f"cost {cost}" if cost else "blocked"
            found.append(Shape(role="shade", points=corners, colour=colors.to_hex(_shade(cost)), name=name))
    return found


def _halo() -> list[Any]:
    """White about lines and letters, so that they stand out."""
    return [patheffects.withStroke(linewidth=3.0, foreground="white")]
