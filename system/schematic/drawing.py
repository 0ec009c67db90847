"""A circuit's schematic as the drawing of a film (`system.view.drawing`), with room for its numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from circuits.circuit import GROUND, Circuit
from circuits.devices import Source
from circuits.lowering.flatten import flatten
from circuits.units import format_quantity
from system.schematic.geometry import Label, Layout
from system.schematic.picture import Solved, layout_of
from system.schematic.symbol import bars_of, circles_of, lines_of
from system.view.drawing import Drawing, Point, Stroke, Text

_RIM, _DOT = 8.0, 1.9  # points about all; radius of a dot
_VOLT, _AMPERE = -8.888, -8.88e-9  # numbers that are as wide as any that is shown


def drawing_of(circuit: Circuit, sources: Sequence[Source] = ()) -> Drawing:
    """Draw a circuit, with room for the voltage of each net and the current of each device.

    sources: those of a testbench that are drawn with it. Raises `ParameterError` for one without a device.
    """
    flat = flatten(circuit)
    volts = dict.fromkeys((n for n in flat.node_names() if n != GROUND), _VOLT)
    devices = [g.label(k) for g in flat.groups for k in range(g.nodes.shape[1])]
    layout = layout_of(circuit, sources, Solved(volts, dict.fromkeys(devices, _AMPERE)))
    box = layout.extent
    left, top = box.left - _RIM, box.top + _RIM

    def at(x: float, y: float) -> Point:
        return round(x - left, 2), round(top - y, 2)

    strokes = [
        *(Stroke(points=(at(w.x0, w.y0), at(w.x1, w.y1)), net=w.net) for w in layout.wires),
        *(Stroke(points=tuple(at(*p) for p in bar), net=r.net) for r in layout.rails for bar in bars_of(r)),
        *(
            Stroke(points=(at(*dot),), radius=_DOT, net=_net_at(dot, layout), filled=True)
            for dot in layout.dots
        ),
        *(
            Stroke(points=tuple(at(*p) for p in line), device=symbol.part.name, filled=filled)
            for symbol in layout.symbols
            for line, filled in lines_of(symbol)
        ),
        *(
            Stroke(points=(at(x, y),), radius=radius, device=symbol.part.name)
            for symbol in layout.symbols
            for x, y, radius in circles_of(symbol)
        ),
    ]
    return Drawing(
        width=round(box.right - box.left + 2.0 * _RIM, 2),
        height=round(box.top - box.bottom + 2.0 * _RIM, 2),
        strokes=tuple(strokes),
        texts=tuple(_text(label, device, at(label.box.left, 0.5 * (label.box.bottom + label.box.top)))
                    for label, device in _labels(layout)),
    )  # fmt: skip


def _net_at(point: Point, layout: Layout) -> str:
    """The net of the wires that meet at a point."""
    return next(w.net for w in layout.wires if point in {(w.x0, w.y0), (w.x1, w.y1)})


def _labels(layout: Layout) -> Iterator[tuple[Label, str]]:
    """Yield every label with the device beside which it stands, empty for that of a net."""
    beside = (symbol.part.name for symbol in layout.symbols for _ in symbol.part.lines)
    for label in layout.labels:
        yield label, "" if label.net else next(beside)


def _text(label: Label, device: str, at: Point) -> Text:
    """A label without the number that kept its room."""
    unit, number = ("A", _AMPERE) if device else ("V", _VOLT)
    room = format_quantity(number, unit)
    return Text(
        text=label.text.removesuffix(room).rstrip(), at=at, net=label.net, device=device,
        value=label.text.endswith(room),
    )  # fmt: skip
