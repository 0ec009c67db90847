"""Picture of a sweep: voltages, currents and measures over the innermost of what was swept."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import EngFormatter

from circuits.arrays import F64
from circuits.measure.unit import value_text
from circuits.sweep.axis import DIRECTION
from system.plot import COLOURS, PALE, entitle, looks

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

_DECADES = 100.0  # ratio of the largest to the smallest size of a current above which its axis has decades
_LEAST = 1e-18  # A; what is smaller has no place on an axis of decades
_SMALL = 0.01  # of a unit; ticks of smaller values have prefixes
_ARROWS = 4  # along a curve that goes there and back


def draw_sweep(
    data: xr.Dataset, nodes: Sequence[str], currents: Sequence[str], title: str, figure: Figure
) -> None:
    """Fill `figure` with a panel for the voltages, one for the currents, and one a measure.

    Parameters
    ----------
    data
        What was swept (`circuits.sweep`).
    nodes, currents
        Nodes, and devices or sources, that are drawn.
    title
        What stands above.
    figure
        An empty figure, which is filled.
    """
    measured = [
        str(name)
        for name in data.data_vars
        if "expression" in data[name].attrs and set(data[name].dims) - {DIRECTION}
    ]
    panels: list[tuple[str, list[tuple[str, xr.DataArray]], str]] = []
    if nodes:
        panels.append(("voltage", [(n, data.voltage.sel(node=n, drop=True)) for n in nodes], "V"))
    if currents:
        panels.append(("current", [(d, data.current.sel(device=d, drop=True)) for d in currents], "A"))
    # a measure of the one curve is a number, which is no picture
    panels += [(name, [(name, data[name])], data[name].attrs["units"]) for name in measured]
    figure.set_size_inches(7.5, 2.7 * len(panels) + 0.6)
    stack = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
    for (label, curves, unit), ax in zip(panels, stack, strict=True):
        _draw_panel(label, curves, unit, ax)
    entitle(title, stack[0])
    figure.align_ylabels(stack)


def _draw_panel(label: str, curves: Sequence[tuple[str, xr.DataArray]], unit: str, ax: Axes) -> None:
    """Curves over their first dimension: a colour a curve and value of the others, dashes a direction."""
    dims = [str(d) for d in curves[0][1].dims if d != DIRECTION]
    inner, others = dims[0], dims[1:]
    logarithmic = unit == "A" and _has_decades(curves)
    if logarithmic:
        curves = [(name, abs(array)) for name, array in curves]
        ax.set_yscale("log")
    x = curves[0][1][inner].to_numpy()
    places = list(product(*(curves[0][1][d].to_numpy().tolist() for d in others)))
    styles = looks(len(curves) * len(places))
    for k, ((name, array), place) in enumerate(product(curves, places)):
        at = array.sel(dict(zip(others, place, strict=True)))
        said = ", ".join([*([name] if len(curves) > 1 else []), *_said(array, others, place)])
        if bool(at.isnull().all()):
            said = f"{said}: none".removeprefix(": ")
        style = {**styles[k], "label": said if len(styles) <= len(COLOURS) else None}
        _draw_curve(x, at, inner, style, ax)
    named = label if len(curves) > 1 or label == curves[0][0] else f"{label} {curves[0][0]}"
    _label(ax, inner, curves[0][1][inner])
    _name_y(ax, f"|{named}|" if logarithmic else named, unit)
    if len(styles) > len(COLOURS):
        ax.plot([], [], color=PALE, label=f"{len(styles)} curves")
    if ax.get_legend_handles_labels()[1]:
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8)
    ax.grid(color=PALE, linewidth=0.4)


def _draw_curve(x: Any, at: xr.DataArray, inner: str, style: dict[str, Any], ax: Axes) -> None:
    """A curve; where there are two directions, the way up is a line and the way down dashed, with arrows."""
    values = np.arange(len(x)) if x.dtype.kind in "OU" else x
    marker = "o" if len(x) <= 12 else ""
    if DIRECTION not in at.dims:
        ax.plot(values, at.to_numpy(), marker=marker, markersize=3, linewidth=1.2, **style)
        return
    for way, dashes in (("up", "-"), ("down", "--")):
        y = at.sel({DIRECTION: way}).to_numpy()
        label = None if style["label"] is None else f"{style['label']} {way}".strip()
        ax.plot(values, y, linewidth=1.2, **{**style, "linestyle": dashes, "label": label})
        _arrows(values, y, way, style["color"], ax)


def _arrows(x: Any, y: F64, way: str, colour: str, ax: Axes) -> None:
    """Triangles that point along the way, and differ by shape for who sees no colours."""
    beside = len(x) // 12 if way == "down" else 0  # so that those of the two ways do not meet
    k = np.linspace(0, len(x) - 1, _ARROWS + 2).astype(int)[1:-1] + beside
    ax.plot(x[k], y[k], linestyle="", marker=">" if way == "up" else "<", markersize=5, color=colour)


def _has_decades(curves: Sequence[tuple[str, xr.DataArray]]) -> bool:
    """Whether currents span decades, each of one sign and never nothing."""
    values = [array.to_numpy()[np.isfinite(array.to_numpy())] for _, array in curves]
    one_sign = all(bool((v > 0.0).all() or (v < 0.0).all()) for v in values)
    sizes = np.abs(np.concatenate(values))
    return one_sign and sizes.size > 0 and bool(sizes.max() > _DECADES * max(sizes.min(), _LEAST))


def _said(array: xr.DataArray, others: Sequence[str], place: Sequence[Any]) -> list[str]:
    """Values of the other dimensions for the legend, as `vb 350mV`."""
    units = [array[d].attrs.get("units", "") for d in others]
    return [
        f"{d} {v if isinstance(v, str) else value_text(float(v), u).replace('degC', ' °C')}"
        for d, v, u in zip(others, place, units, strict=True)
    ]


def _label(ax: Axes, inner: str, coordinate: xr.DataArray) -> None:
    """The axis of what is swept: words for corners, decades for a wide range, prefixes for small numbers."""
    unit = coordinate.attrs.get("units", "").replace("degC", "°C")
    values = coordinate.to_numpy()
    if values.dtype.kind in "OU":
        ax.set_xlabel(inner)
        ax.set_xticks(range(len(values)), values.tolist())
        return
    if values.min() > 0.0 and values.max() > _DECADES * values.min():
        ax.set_xscale("log")
    elif values.size > 1:
        room = 0.03 * abs(values.max() - values.min())
        ax.set_xlim(values.min() - room, values.max() + room)
    prefixed = _with_prefixes(ax.xaxis, float(np.abs(values).max()), unit)
    ax.set_xlabel(inner if prefixed or not unit else f"{inner} ({unit})")


def _name_y(ax: Axes, what: str, unit: str) -> None:
    logarithmic = ax.get_yscale() == "log"
    prefixed = not logarithmic and _with_prefixes(ax.yaxis, max(map(abs, ax.get_ylim())), unit)
    ax.set_ylabel(what if prefixed or not unit else f"{what} ({unit})")


def _with_prefixes(axis: Axis, largest: float, unit: str) -> bool:
    """Write ticks as `500 fF` where plain numbers would have many zeros; whether that was done."""
    if not unit.isalpha() or unit == "deg" or _SMALL <= largest < 1.0 / _SMALL:
        return False
    axis.set_major_formatter(EngFormatter(unit))
    return True
