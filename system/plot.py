"""Pictures: waveforms of a run, graph of a circuit, and files of them.

Every drawing takes the axes or the figure that it fills. matplotlib's Agg draws, so no display is needed; the
bytes of a file depend on the picture alone.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.lowering.graph import to_graph, to_instance_graph
from circuits.measure.branch import waveform
from circuits.silicon.course import Points
from circuits.silicon.die import Die
from circuits.solver.transient import Result
from system.files.writing import check_folder, replace_atomic
from system.options.temperature import temperature_text
from system.rule import Estimated

if TYPE_CHECKING:
    import networkx as nx
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
else:
    nx = later("networkx")

# many a command draws nothing
matplotlib, figures, lines_of = later("matplotlib"), later("matplotlib.figure"), later("matplotlib.lines")
agg, patches, ticker = (later(f"matplotlib.{name}") for name in ("backends.backend_agg", "patches", "ticker"))

SUFFIXES = ("png", "svg", "pdf")
_MANY_DEVICES = 80  # beyond this a graph shows instances, for its labels would not be legible

# Okabe and Ito (2008): told apart by readers with any kind of colour vision.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442")
Dashes = Literal["-", "--", "-.", ":"]
DASHES: tuple[Dashes, ...] = ("-", "--", "-.", ":")  # beside colours, for who prints in grey
INK, PALE = "#333333", "#B8B8B8"

Point = tuple[float, float]
Look = tuple[str, Dashes]  # colour and dashes
_EDGE, _PORT = "#8A8A8A", "#E4E4E4"
_NAME = 9.0  # points, of the names in a graph
_PITCH, _WIDER = 0.54, 1.25  # inches between vertices, and how much wider than high a graph is
_GAP, _RIM, _KEY, _LEAST = 0.08, 0.1, 2.2, 2.4  # inches: between boxes, about all, of a legend, of a figure
_ROUNDS, _STEP = 500, 0.6  # of pushing boxes apart, and what share of an overlap goes in one

_TITLE = 9.0  # points, of a title and of the label of an axis
_TICKS = 3  # steps of an axis of volts, at most
_LONG = 9  # letters of a name whose unit has a line of its own
_LETTER, _OVER = 0.55, 1.15  # mean width of a letter over its size; of a title over its axes
_LEGEND = 48  # letters of a legend's entry that two columns have room for; ours

_DECADES = 2.0  # of a logarithmic axis on which 1, 2 and 5 are labelled; on a longer one decades are
_PASSES = 4  # of the layout at most
_STILL = 1e-4  # of the figure: axes that move by less stand still; a tenth of a pixel

STYLE: Any = {
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "figure.autolayout": False,
    "figure.constrained_layout.use": False,
    "font.size": 9,
    "legend.frameon": False,
    "pdf.fonttype": 42,
    "savefig.dpi": 150,
    "svg.hashsalt": "noctule",
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
}
_UNDATED: dict[str, dict[str, None]] = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}


def check_picture(path: str | None) -> None:
    """Raise before anything is computed if a picture cannot be written to `path`, None where none is wanted.

    Raises
    ------
    ParameterError
        The suffix names no known format.
    DataError
        There is no such folder.
    """
    if path is None:
        return
    if Path(path).suffix.removeprefix(".").lower() not in SUFFIXES:
        raise ParameterError(f"plot: {path}, must end with .{', .'.join(SUFFIXES)}; choose one of them")
    check_folder(path)


def save_picture(path: str | None, draw: Callable[[Figure], None]) -> None:
    """Make a figure, let `draw` fill it, and write it whole in the format of the suffix of `path`.

    Nothing is drawn where `path` is None.
    """
    check_picture(path)
    if path is None:
        return
    suffix = Path(path).suffix.removeprefix(".").lower()
    with matplotlib.rc_context(STYLE):
        # as fine as it is written: at another resolution ticks come and go, and the layout with them
        figure = figures.Figure(figsize=(7.0, 4.5), dpi=STYLE["savefig.dpi"], layout="constrained")
        agg.FigureCanvasAgg(figure)
        draw(figure)
        for ax in figure.axes:
            _space(ax.xaxis)
            _space(ax.yaxis)
        settle(figure)
        with replace_atomic(path) as temporary:
            figure.savefig(temporary, format=suffix, metadata=_UNDATED[suffix])


def _space(axis: Axis) -> None:
    """Label few ticks of a logarithmic axis whose ticks nobody chose: matplotlib's own run together."""
    if axis.get_scale() != "log" or not axis.isDefault_majloc or not axis.isDefault_minfmt:
        return
    axis.set_minor_formatter(ticker.NullFormatter())
    low, high = sorted(np.log10(axis.get_view_interval()))
    if high - low >= _DECADES:
        return
    few = ticker.LogLocator(subs=(1.0, 2.0, 5.0), numticks=15)
    axis.set_major_locator(few if high - low >= 0.5 * _DECADES else ticker.MaxNLocator(5))
    if low > -3.5 and high < 5.5:
        axis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))


def sized_axes(figure: Figure, width: float, height: float) -> Axes:
    """Give an empty figure its width and height, in inches, and return the one pair of axes in it."""
    figure.set_size_inches(width, height)
    return figure.subplots()


def settle(figure: Figure) -> None:
    """Lay a figure out until nothing moves, for good: what writes it does not lay it out again.

    One pass is enough but beside axes of equal scales.
    """
    engine, placed = figure.get_layout_engine(), np.empty(0)
    if engine is None or not figure.axes:
        return
    passes = _PASSES if any(ax.get_aspect() != "auto" for ax in figure.axes) else 1
    for _ in range(passes):
        engine.execute(figure)
        before, placed = placed, np.array([ax.get_position().bounds for ax in figure.axes])
        if before.shape == placed.shape and np.abs(placed - before).max(initial=0.0) < _STILL:
            break
    figure.set_layout_engine(None)  # "none" is an engine too, for which what writes draws twice


def entitle(text: str, ax: Axes) -> None:
    """Set the title of `ax`, whose lines are broken where they would be much wider than the axes.

    matplotlib's own `wrap` hangs a second line into the axes.
    """
    figure = ax.get_figure(root=True)
    inches = 6.0 if figure is None else ax.get_position(original=True).width * figure.get_figwidth()
    columns = int(_OVER * inches * 72.0 / (_LETTER * _TITLE))
    lines = [part for line in text.split("\n") for part in textwrap.wrap(line, columns) or [""]]
    ax.set_title("\n".join(lines), fontsize=_TITLE)


def silicon_text(
    die: Die, temperature_c: float, bias_kind: str | None = None, course: Points = (), law: str = "full"
) -> str:
    """Die, temperature (degC) and kind of biases for a title: `die A/1003, 27 °C, biases of kind gate`.

    Of a course of temperature, its lowest and highest points; the law is named where it is not the full one.
    """
    kind = "" if bias_kind is None else f", biases of kind {bias_kind}"
    named = "" if law == "full" else f", {law} law"
    return f"{die}, {temperature_text(temperature_c, course)} °C{kind}{named}"


def die_label(die: Die) -> str:
    """A die in a legend, as in a title; of edits that are longer than a legend is wide, only their number."""
    text = str(die)
    if len(text) <= _LEGEND:
        return text
    return f"{replace(die, edits=())}, edited in {sum(len(edit.paths) for edit in die.edits)} places"


def mark_end(at: F64, ax: Axes, *, succeeded: bool | None) -> None:
    """Mark where a way ended, float64[2]: a green diamond for success, an orange cross for failure.

    None is for a way that was neither: a part of one, or of a run that does not say.
    """
    marker, colour = {True: ("D", COLOURS[2]), False: ("x", COLOURS[1]), None: ("s", INK)}[succeeded]
    label = {True: "end: succeeded", False: "end: failed", None: "end"}[succeeded]
    ax.plot(*at, marker=marker, color=colour, markersize=6, linestyle="", zorder=5, label=label)


def draw_estimates(
    at: Sequence[float],
    estimates: Sequence[Estimated],
    look: Mapping[str, Any],
    ax: Axes,
    scale: float = 1.0,
) -> None:
    """Draw estimates at their places on the x axis, with their intervals, in units of 1 / `scale`.

    look: what `Axes.errorbar` takes, as colour, marker and label.
    """
    y = scale * np.array([e.value for e in estimates])
    ends = scale * np.array([(e.interval.low, e.interval.high) for e in estimates]).reshape(-1, 2)
    ax.errorbar(at, y, np.abs(ends.T - y), **look)


def draw_waveforms(result: Result, nodes: Sequence[str], figure: Figure, title: str = "") -> None:
    """Draw waveforms over one time axis in ms, a panel for each node, top to bottom; spikes are marked.

    Parameters
    ----------
    result
        The run.
    nodes
        Paths of the nodes.
    figure
        An empty figure, which is filled.
    title
        What stands above the panels.
    """
    panels = len(nodes)
    figure.set_size_inches(7.0, max(_panel(nodes) * panels + 0.8, 2.2))
    stack = figure.subplots(panels, 1, sharex=True, squeeze=False)[:, 0]
    for k, (node, ax) in enumerate(zip(nodes, stack, strict=True)):
        told = waveform(result, node)
        draw_waveform(result.time, told.values, told.name, ax, COLOURS[k % 5], told.unit)
        mark_spikes(result.spikes.get(node, np.zeros(0)), float(result[node].max()), ax)
        ax.tick_params(axis="x", bottom=k == panels - 1)
    stack[-1].set_xlabel("time (ms)")
    stack[-1].set_xlim(0.0, 1e3 * float(result.time[-1]))
    entitle(title, stack[0])
    figure.align_ylabels(stack)


def draw_runs(runs: Mapping[str, Result], nodes: Sequence[str], figure: Figure) -> None:
    """Fill `figure` with a panel a node, in which each run has a colour and dashes of its own, by label."""
    figure.set_size_inches(7.0, max(_panel(nodes) * len(nodes) + 1.0, 2.2))
    stack = figure.subplots(len(nodes), 1, sharex=True, squeeze=False)[:, 0]
    for node, ax in zip(nodes, stack, strict=True):
        for (label, run), look in zip(runs.items(), looks(len(runs)), strict=True):
            told = waveform(run, node)
            ax.plot(1e3 * run.time, told.values, linewidth=1.2, label=label, **look)
            ax.set_ylabel(_axis(told.name, told.unit))
        ax.tick_params(axis="x", bottom=ax is stack[-1])
    stack[-1].set_xlabel("time (ms)")
    stack[-1].set_xlim(0.0, 1e3 * max(float(run.time[-1]) for run in runs.values()))
    figure.legend(*stack[0].get_legend_handles_labels(), loc="outside upper left", ncols=3, fontsize=8)
    figure.align_ylabels(stack)


def _panel(nodes: Sequence[str]) -> float:
    """Height of a panel, in inches, beside which the longest of the names has room."""
    return max(1.05, max(map(len, nodes)) * _LETTER * _TITLE / 72.0 + 0.25)


def _axis(name: str, unit: str) -> str:
    """Label of an axis; the unit of a long name has a line of its own."""
    return f"{name}\n({unit})" if len(name) > _LONG else f"{name} ({unit})"


def looks(count: int) -> list[dict[str, Any]]:
    """Colour and dashes of each of `count` lines, told apart in grey too; beyond the colours all are pale."""
    if count > len(COLOURS):
        return [{"color": PALE, "linestyle": "-"} for _ in range(count)]
    return [{"color": COLOURS[k], "linestyle": DASHES[k % len(DASHES)]} for k in range(count)]


def draw_waveform(
    time: F64, voltage: F64, label: str, ax: Axes, colour: str = COLOURS[0], unit: str = "V"
) -> None:
    """Draw a voltage (V), or something else of a unit, over time (s, drawn in ms)."""
    ax.plot(1e3 * time, voltage, color=colour, linewidth=1.2)
    ax.set_ylabel(_axis(label, unit))
    # of its own accord the number of ticks follows the layout
    ax.yaxis.set_major_locator(ticker.MaxNLocator(_TICKS))
    low, high = float(voltage.min()), float(voltage.max())
    room = max(0.08 * (high - low), 0.02 if unit == "V" else 1e-15)
    ax.set_ylim(low - room, high + 2.0 * room)


def mark_spikes(times: F64, height: float, ax: Axes) -> None:
    """Mark spikes (s) with a triangle above the trace."""
    if times.size:
        marks = ax.plot(1e3 * times, np.full(times.size, height), linestyle="", marker="v", markersize=5)
        marks[0].set(color=INK, clip_on=False, zorder=3)
        words = "1 spike" if times.size == 1 else f"{times.size} spikes"
        ax.annotate(words, (1.0, 1.0), xycoords="axes fraction", ha="right", va="top", fontsize=8)


def draw_circuit(circuit: Circuit, figure: Figure) -> None:
    """Fill `figure` with the graph of `circuit`: its devices, or its instances where devices are many."""
    if any(instance.shape for instance in circuit.instances):  # a chip's devices may be millions
        _draw_graph(to_instance_graph(circuit), figure)
        return
    graph = to_graph(circuit)
    devices = sum(1 for _, kind in graph.nodes(data="kind") if kind == "device")
    _draw_graph(to_instance_graph(circuit) if devices > _MANY_DEVICES else graph, figure)


def _draw_graph(graph: nx.MultiGraph, figure: Figure) -> None:
    """Draw a circuit's graph: boxes are devices or instances, in a colour each part; names are nodes.

    Ground and supplies reach nearly everything, so they are left out. Where only a gate or a bulk touches a
    node the edge is dotted: no current flows there. The figure is as large as its labels need.
    """
    rails = [v for v, port in graph.nodes(data="port") if port in {"ground", "supply"}]
    shown = graph.copy()  # a subgraph view would lose the order of the vertices, and with it the picture's
    shown.remove_nodes_from(rails)
    sizes = {v: _box_size(data) for v, data in shown.nodes(data=True)}
    place = _layout(nx.Graph(shown), sizes)
    parts = sorted({d["instance"] for _, d in shown.nodes(data=True) if d["kind"] == "device"})
    looks_of: dict[str, Look] = {
        part: (COLOURS[k % len(COLOURS)], DASHES[k // len(COLOURS) % len(DASHES)])
        for k, part in enumerate(parts)
    }
    ax = figure.subplots()
    for a, b in nx.Graph(shown).edges:  # what is drawn is within its axes (`_fit`), and so in no layout
        terminals = {data["terminal"] for data in shown.get_edge_data(a, b).values()}
        style = ":" if terminals <= {"gate", "bulk"} else "-"
        ends = zip(place[a], place[b], strict=True)
        ax.plot(*ends, color=_EDGE, linewidth=1.0, linestyle=style, zorder=1, in_layout=False)
    for vertex, data in shown.nodes(data=True):
        if data["kind"] == "node":
            _draw_node(place[vertex], data, ax)
        else:
            _draw_box(place[vertex], data, looks_of.get(data.get("instance", ""), (COLOURS[0], "-")), ax)
    kinds = {bool(d["port"]) for _, d in shown.nodes(data=True) if d["kind"] == "node"}
    dotted = any(line.get_linestyle() == ":" for line in ax.lines)
    _draw_key(looks_of, [graph.nodes[v]["label"] for v in rails], kinds, ax, dotted=dotted)
    _fit(place, sizes, ax, figure)
    entitle(str(graph.graph["name"]).replace("_", " "), ax)


def _fit(place: Mapping[Any, Point], sizes: Mapping[Any, Point], ax: Axes, figure: Figure) -> None:
    """Give axes and figure the size of what is drawn, whose places are in inches, and room for the legend."""
    at, half = np.array([place[v] for v in place]), 0.5 * np.array([sizes[v] for v in place])
    low, high = (at - half).min(axis=0) - _RIM, (at + half).max(axis=0) + _RIM
    width, height = high - low
    figure.set_size_inches(max(width + _KEY, _LEAST), max(height + 0.5, _LEAST))
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    ax.set_axis_off()


def _box_size(data: Mapping[str, Any]) -> Point:
    """Width and height, in inches, of what is drawn for a vertex."""
    return (len(_with_shape(data)) * _LETTER * _NAME / 72.0 + 0.16, _NAME / 72.0 + 0.13)


def _layout(graph: nx.Graph, sizes: Mapping[Any, Point]) -> dict[Any, Point]:
    """Place vertices, in inches: distance follows the number of edges between them; parts side by side."""
    place: dict[Any, Point] = {}
    left = 0.0
    for members in sorted(nx.connected_components(graph), key=lambda found: (-len(found), min(found))):
        part = nx.Graph()
        part.add_nodes_from(sorted(members))
        part.add_edges_from(graph.subgraph(members).edges)
        spread = _PITCH * float(np.sqrt(len(members)))
        found = nx.kamada_kawai_layout(part, scale=spread)
        boxes = np.array([sizes[v] for v in part])
        points = _apart(np.array([found[v] for v in part]) * (_WIDER, 1.0), boxes)
        points[:, 0] += left - (points - 0.5 * boxes)[:, 0].min()
        place |= {v: (float(x), float(y)) for v, (x, y) in zip(part, points, strict=True)}
        left = float((points + 0.5 * boxes)[:, 0].max()) + _GAP
    return place


def _apart(points: F64, boxes: F64) -> F64:
    """Move boxes about points until none overlap, each pair by the shorter way; float64[n, 2], inches."""
    moved = points.copy()
    room = 0.5 * (boxes[:, None, :] + boxes[None, :, :]) + _GAP
    same = np.eye(len(moved), dtype=bool)
    order = np.sign(np.subtract.outer(np.arange(len(moved)), np.arange(len(moved))))[..., None]
    for _ in range(_ROUNDS):
        gap = moved[:, None, :] - moved[None, :, :]
        over = np.where(same[..., None], -1.0, room - np.abs(gap))
        hit = (over > 0.0).all(axis=2)
        if not hit.any():
            break
        shorter = over[..., 1] <= over[..., 0]
        side = np.where(gap != 0.0, np.sign(gap), order)
        push = 0.5 * _STEP * np.where(hit, np.where(shorter, over[..., 1], over[..., 0]), 0.0)
        moved[:, 0] += (np.where(shorter, 0.0, push) * side[..., 0]).sum(axis=1)
        moved[:, 1] += (np.where(shorter, push, 0.0) * side[..., 1]).sum(axis=1)
    return moved


def _draw_node(at: Point, data: dict[str, Any], ax: Axes) -> None:
    """Write a node's name where it is: a port's on grey and in bold."""
    port = bool(data["port"])
    box = {"boxstyle": "round,pad=0.2", "facecolor": _PORT if port else "white", "edgecolor": "none"}
    weight = "bold" if port else "normal"
    text = ax.text(*at, _with_shape(data), ha="center", va="center", fontsize=_NAME, zorder=3, bbox=box)
    text.set(fontweight=weight, in_layout=False)


def _draw_box(at: Point, data: dict[str, Any], look: Look, ax: Axes) -> None:
    colour, dashes = look
    box = {"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": colour, "linewidth": 1.6,
           "linestyle": dashes}  # fmt: skip
    text = ax.text(*at, _with_shape(data), ha="center", va="center", fontsize=_NAME, zorder=4, bbox=box)
    text.set_in_layout(False)


def _with_shape(data: Mapping[str, Any]) -> str:
    """The label, and how many there are of an array."""
    return " ×".join([data["label"], *map(str, data.get("shape", ()))])


def _draw_key(
    looks_of: Mapping[str, Look], rails: list[str], kinds: set[bool], ax: Axes, *, dotted: bool
) -> None:
    """Add the legend: parts, kinds of nodes (whether ports), edges without current, and rails left out."""
    lines = [
        lines_of.Line2D([], [], color=colour, linewidth=2.0, linestyle=dashes, label=part or "top level")
        for part, (colour, dashes) in looks_of.items()
    ]
    handles: list[Any] = [*lines]
    if True in kinds:
        handles.append(patches.Patch(facecolor=_PORT, edgecolor="none", label="port"))
    if False in kinds:
        handles.append(lines_of.Line2D([], [], linestyle="", label="inner node: its name alone"))
    if dotted:
        handles.append(lines_of.Line2D([], [], color=_EDGE, linestyle=":", label="gate or bulk only"))
    note = f"not drawn: {', '.join('ground' if r == '0' else r for r in rails)}" if rails else None
    figure = ax.get_figure(root=True)
    if figure is not None:
        figure.legend(handles=handles, title=note, loc="outside right upper", fontsize=8, title_fontsize=8)
