"""The picture of a circuit as a schematic, by matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from circuits.catalogue import later
from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.errors import ParameterError
from circuits.units import format_quantity
from system.plot import COLOURS, INK, entitle
from system.schematic.geometry import FONT, Layout, Rail, Symbol, lay_out
from system.schematic.part import MANY, cells_of, parts_of, rails_of, source_part
from system.schematic.placement import place
from system.schematic.symbol import bars_of, circles_of, lines_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

patches = later("matplotlib.patches")

_POINTS = 72.0  # to an inch
_RIM, _LEAST = 8.0, 144.0  # points: about all; of a figure
_WIDTH = 1.1  # points, of lines
_NET, _PORT = COLOURS[0], COLOURS[1]


@dataclass(frozen=True, slots=True)
class Solved:
    """What is written into a schematic: V by node, magnitudes in A by device, and a note below the title."""

    voltages: Mapping[str, float] = field(default_factory=dict)
    currents: Mapping[str, float] = field(default_factory=dict)
    note: str = ""


def layout_of(
    circuit: Circuit, sources: Sequence[Source] = (), solved: Solved = Solved(), most: float = MANY
) -> Layout:
    """Lay a circuit out.

    Parameters
    ----------
    circuit
        The circuit.
    sources
        Sources of a testbench that are to be drawn with it.
    solved
        Voltages and currents, nothing where nothing is solved.
    most
        Devices beyond which an array is drawn by its first cell.

    Raises
    ------
    ParameterError
        The circuit has no device.
    """
    rails = rails_of(circuit)
    parts = (*parts_of(circuit, solved.currents, most), *(source_part(s) for s in sources))
    if not parts:
        raise ParameterError(f"{circuit.name}: 0 devices, a schematic must have one; add a device")
    inputs = [p.name for p in circuit.ports if p.direction == "in" and p.kind not in {"supply", "bias"}]
    volts = solved.voltages

    def written(net: str) -> str:
        if net not in volts:
            return net
        volt = round(float(f"{volts[net]:.4g}"), 6)  # below a microvolt only the solver's tolerance is seen
        return f"{net} {format_quantity(volt + 0.0, 'V')}"

    return lay_out(parts, place(parts, rails, inputs), rails, written)


def draw_schematic(
    circuit: Circuit, figure: Figure, sources: Sequence[Source] = (), solved: Solved = Solved()
) -> None:
    """Fill `figure`, whose size follows, with the schematic of a circuit; the rest is that of `layout_of`."""
    layout = layout_of(circuit, sources, solved)
    ports = {p.name for p in circuit.ports}
    ax = figure.subplots()
    for wire in layout.wires:
        ax.plot((wire.x0, wire.x1), (wire.y0, wire.y1), color=INK, linewidth=_WIDTH, solid_capstyle="round")
    for symbol in layout.symbols:
        _draw_symbol(symbol, ax)
    for rail in layout.rails:
        _draw_rail(rail, ax)
    for x, y in layout.dots:
        ax.add_patch(patches.Circle((x, y), 1.9, color=INK))
    for label in layout.labels:
        base = label.net.partition("[")[0]
        colour = INK if not label.net else _PORT if base in ports else _NET
        middle = 0.5 * (label.box.bottom + label.box.top)
        ax.text(
            label.box.left, middle, label.text, family="DejaVu Sans Mono", fontsize=FONT, color=colour,
            va="center_baseline",
        )  # fmt: skip
    _fit(layout, ax, figure)
    entitle(_title(circuit, solved.note), ax)


def _title(circuit: Circuit, note: str) -> str:
    cells = [f"{path} x{count}" for path, count in cells_of(circuit).items()]
    first = [f"one cell of each array: {', '.join(cells)}"] if cells else []
    return "\n".join([circuit.name.replace("_", " "), *first, *([note] if note else [])])


def _draw_symbol(symbol: Symbol, ax: Axes) -> None:
    for line, filled in lines_of(symbol):
        if filled:
            ax.add_patch(patches.Polygon(line, color=INK))
        else:
            ax.plot(*zip(*line, strict=True), color=INK, linewidth=_WIDTH, solid_capstyle="round")
    for x, y, radius in circles_of(symbol):
        ax.add_patch(patches.Circle((x, y), radius, fill=False, color=INK, linewidth=_WIDTH))


def _draw_rail(rail: Rail, ax: Axes) -> None:
    for bar in bars_of(rail):
        ax.plot(*zip(*bar, strict=True), color=INK, linewidth=1.3 * _WIDTH)


def _fit(layout: Layout, ax: Axes, figure: Figure) -> None:
    box = layout.extent
    width, height = box.right - box.left + 2.0 * _RIM, box.top - box.bottom + 2.0 * _RIM
    title = 40.0
    figure.set_layout_engine("none")
    figure.set_size_inches(max(width, _LEAST) / _POINTS, (height + title) / _POINTS)
    ax.set_position((0.0, 0.0, min(1.0, width / _LEAST), height / (height + title)))
    ax.set(xlim=(box.left - _RIM, box.right + _RIM), ylim=(box.bottom - _RIM, box.top + _RIM))
    ax.set_axis_off()
