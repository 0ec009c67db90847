"""Boxes, wires and labels of a schematic in points: a pure function of its parts and their places.

Rows of symbols alternate with corridors. In a corridor the upper third has the names below the row above, the
lower third those above the row below, and the middle the wires across, so that nothing can overlap. A wire is
drawn where it is short and meets no other net; each group of joined terminals that is left bears its net's
name once, so every net is drawn or named. Rails are drawn at each terminal.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from circuits.circuit import GROUND
from system.schematic.part import Part, Rails
from system.schematic.placement import Place
from system.schematic.wiring import Joint, Pin, groups, pins_of, wire

FONT = 8.0
"""Size of all texts, points; of a font whose letters are equally wide, `LETTER` of its size."""
LETTER = 0.603
LINE = 10.0
GATE, HALF = 20.0, 28.0  # of a symbol: how far its side terminals are from its axis, and half its height
_CORRIDOR, _TEXT = 40.0, 8.0  # height of a corridor; of how far its names are from its rims
_GAP = 9.0  # between columns
_PAD = 4.0  # between an axis and the text beside it
_BAR = 8.0  # half width of a rail
_BANDS = 16.0  # between bands


class Box(NamedTuple):
    """A rectangle, points; y goes up."""

    left: float
    bottom: float
    right: float
    top: float

    def overlaps(self, other: Box) -> bool:
        """Whether the two have an inner point in common."""
        across = self.left < other.right and other.left < self.right
        return across and self.bottom < other.top and other.bottom < self.top


class Symbol(NamedTuple):
    """A part at its place: x, y of its centre; flipped if its side terminals are mirrored."""

    part: Part
    x: float
    y: float
    flipped: bool
    box: Box


class Label(NamedTuple):
    """A text in its box; `net` is that which it names, empty for a line beside a symbol."""

    text: str
    box: Box
    net: str = ""


class Rail(NamedTuple):
    """A rail at a terminal: its net, x, y of where it hangs, whether it is above, and its box."""

    net: str
    x: float
    y: float
    above: bool
    box: Box


class Wire(NamedTuple):
    """A straight piece of a net."""

    net: str
    x0: float
    y0: float
    x1: float
    y1: float


@dataclass(slots=True)
class Layout:
    """All that is drawn, points."""

    symbols: list[Symbol] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    rails: list[Rail] = field(default_factory=list)
    wires: list[Wire] = field(default_factory=list)
    dots: list[tuple[float, float]] = field(default_factory=list)

    @property
    def extent(self) -> Box:
        """The box about all."""
        boxes = [t.box for t in self.symbols] + [t.box for t in self.labels] + [t.box for t in self.rails]
        boxes += [_box_of(w) for w in self.wires]
        lefts, bottoms, rights, tops = zip(*boxes, strict=True)
        return Box(min(lefts), min(bottoms), max(rights), max(tops))


def _box_of(w: Wire) -> Box:
    return Box(min(w.x0, w.x1), min(w.y0, w.y1), max(w.x0, w.x1), max(w.y0, w.y1))


def width_of(text: str) -> float:
    """Width of a text, points."""
    return len(text) * FONT * LETTER


def lay_out(
    parts: Sequence[Part], places: Sequence[Place], rails: Rails, written: Callable[[str], str] = str
) -> Layout:
    """Lay a schematic out; `written` gives the text that names a net."""
    fixed = rails.high | rails.low
    wiring = wire(parts, places, fixed)
    namers = {min(group, key=_rank): group for group in groups(wiring, fixed)}
    texts = {pin: written(pin.net) for pin in namers}
    hung = [
        pin
        for k, part in enumerate(parts)
        for pin in pins_of(k, part, flipped=places[k].flipped)
        if pin.net in fixed
    ]
    faced = {pin for pair in wiring.facing for pin in pair}
    boxes = [(pin, _name_box(pin, (_side_x(pin), 0.0), text)) for pin, text in texts.items()]
    boxes += [(pin, _rail_box(pin, (_side_x(pin), 0.0), written(pin.net))) for pin in hung]
    at = _Places.of(parts, places, boxes)
    layout = Layout()
    for k, part in enumerate(parts):
        _add_part(layout, part, at.x[k], at.y[k], flipped=places[k].flipped)
    for pin in hung:
        _add_rail(layout, pin, at.of_pin(pin), written(pin.net))
    for a, b in (*wiring.columns, *wiring.facing, *wiring.inverters):
        layout.wires.append(Wire(a.net, *at.of_pin(a), *at.of_pin(b)))
    for left, right in wiring.across:
        _add_across(layout, at, left, right)
    for pin, text in texts.items():
        _add_name(layout, pin, at.of_pin(pin), text, raised=pin in faced)
    layout.dots = _dots(layout)
    return layout


@dataclass(frozen=True, slots=True)
class _Places:
    """Axes and centres of parts, and the middles of corridors, points."""

    x: list[float]
    y: list[float]
    tops: list[float]  # of bands

    @classmethod
    def of(cls, parts: Sequence[Part], places: Sequence[Place], boxes: Sequence[tuple[Pin, Box]]) -> _Places:
        left: dict[tuple[int, int], float] = {}
        right: dict[tuple[int, int], float] = {}
        for k, part in enumerate(parts):
            _, label = _boxes(part, 0.0, 0.0, flipped=places[k].flipped)
            _widen(places[k], label, left, right)
            _widen(places[k], _symbol_box(part, 0.0, 0.0, flipped=places[k].flipped), left, right)
        for pin, box in boxes:
            _widen(places[pin.part], box, left, right)
        rows = [0] * (1 + max(p.band for p in places))
        for p in places:
            rows[p.band] = max(rows[p.band], p.row + 1)
        tops = [0.0]
        for count in rows:
            tops.append(tops[-1] - count * (2.0 * HALF + _CORRIDOR) - _CORRIDOR - _BANDS)
        axes: dict[tuple[int, int], float] = {}
        for band in range(len(rows)):
            edge = 0.0
            for column in sorted(c for b, c in left if b == band):
                axes[band, column] = edge + left[band, column]
                edge = axes[band, column] + right[band, column] + _GAP
        y = [tops[p.band] - p.row * (2.0 * HALF + _CORRIDOR) - _CORRIDOR - HALF for p in places]
        return cls([axes[p.band, p.column] for p in places], y, tops)

    def of_pin(self, pin: Pin) -> tuple[float, float]:
        rise = {"top": HALF, "bottom": -HALF}.get(pin.side, pin.rise)
        return self.x[pin.part] + _side_x(pin), self.y[pin.part] + rise

    def middle(self, joint: Joint) -> float:
        return self.tops[joint.band] - joint.corridor * (2.0 * HALF + _CORRIDOR) - 0.5 * _CORRIDOR


def _rank(pin: Pin) -> tuple[int, Pin]:
    """Where a group is named: below a part, else above one, else at the gate whose wire has room above it."""
    return ("bottom", "top", "right", "left").index(pin.side), pin


def _side_x(pin: Pin) -> float:
    return {"left": -GATE, "right": GATE}.get(pin.side, 0.0)


def _widen(
    place: Place, box: Box, left: dict[tuple[int, int], float], right: dict[tuple[int, int], float]
) -> None:
    key = (place.band, place.column)
    left[key] = max(left.get(key, 0.0), -box.left)
    right[key] = max(right.get(key, 0.0), box.right)


def _symbol_box(part: Part, x: float, y: float, *, flipped: bool) -> Box:
    reach_left = GATE if (part.right if flipped else part.left) else _BAR
    reach_right = GATE if (part.left if flipped else part.right) else _BAR
    if part.is_transistor:  # nothing is behind the channel
        reach_left, reach_right = (1.0, GATE) if flipped else (GATE, 1.0)
    return Box(x - reach_left, y - HALF, x + reach_right, y + HALF)


def _boxes(part: Part, x: float, y: float, *, flipped: bool) -> tuple[float, Box]:
    """Middle of the first line of a part's label, and the box about all lines."""
    wide, high = max(map(width_of, part.lines), default=0.0), LINE * len(part.lines)
    box = _symbol_box(part, x, y, flipped=flipped)
    low = y + 0.6 * LINE if part.right else y - 0.5 * high  # beside an output, above it
    near = x - _PAD - wide if flipped else box.right + _PAD
    return low + high - 0.5 * LINE, Box(near, low, near + wide, low + high)


def _add_part(layout: Layout, part: Part, x: float, y: float, *, flipped: bool) -> None:
    layout.symbols.append(Symbol(part, x, y, flipped, _symbol_box(part, x, y, flipped=flipped)))
    first, box = _boxes(part, x, y, flipped=flipped)
    for n, line in enumerate(part.lines):
        middle = first - n * LINE
        left = box.right - width_of(line) if flipped else box.left
        layout.labels.append(
            Label(line, Box(left, middle - 0.5 * LINE, left + width_of(line), middle + 0.5 * LINE))
        )
    if part.is_diode:
        side, end = (x + (GATE if flipped else -GATE)), y + (-HALF if part.source_up else HALF)
        layout.wires += [Wire(part.drain, side, y, side, end), Wire(part.drain, side, end, x, end)]


def _name_box(pin: Pin, at: tuple[float, float], text: str, *, raised: bool = False) -> Box:
    x, y = at
    middle = y + {"top": _TEXT, "bottom": -_TEXT}.get(pin.side, 0.6 * LINE if raised else 0.0)
    wide = width_of(text)
    left = x - _PAD - wide if pin.side == "left" else x + _PAD
    if pin.side in {"top", "bottom"}:
        left = x + _PAD
    return Box(left, middle - 0.5 * LINE, left + wide, middle + 0.5 * LINE)


def _add_name(layout: Layout, pin: Pin, at: tuple[float, float], text: str, *, raised: bool) -> None:
    box = _name_box(pin, at, text, raised=raised)
    layout.labels.append(Label(text, box, pin.net))
    if pin.side in {"top", "bottom"}:
        end = at[1] + (_TEXT if pin.side == "top" else -_TEXT)
        layout.wires.append(Wire(pin.net, *at, at[0], end))


def _add_across(layout: Layout, at: _Places, a: Joint, b: Joint) -> None:
    middle = at.middle(a)
    ends = []
    for joint in (a, b):
        x, y = at.of_pin(joint.pin)
        ends.append(x)
        layout.wires.append(Wire(joint.pin.net, x, y, x, middle))
    if ends[0] != ends[1]:
        layout.wires.append(Wire(a.pin.net, ends[0], middle, ends[1], middle))


def _rail_text(pin: Pin, text: str) -> str:
    """What stands beside a rail: nothing beside ground at the bottom, whose symbol says it."""
    return "" if pin.side == "bottom" and pin.net == GROUND else text


def _rail_box(pin: Pin, at: tuple[float, float], text: str) -> Box:
    """Box about a rail and its text."""
    if pin.side in {"left", "right"}:
        return _name_box(pin, at, text)
    name = _name_box(pin, (at[0] + _BAR - 1.0, at[1]), _rail_text(pin, text))
    return Box(at[0] - _BAR, name.bottom, name.right, name.top)


def _add_rail(layout: Layout, pin: Pin, at: tuple[float, float], text: str) -> None:
    """Hang a rail at a terminal; at a gate it is a name."""
    if pin.side in {"left", "right"}:
        layout.labels.append(Label(text, _name_box(pin, at, text), pin.net))
        return
    sign = 1.0 if pin.side == "top" else -1.0
    end = at[1] + sign * _TEXT
    bar = Box(at[0] - _BAR, end - 0.5 * LINE, at[0] + _BAR, end + 0.5 * LINE)
    layout.rails.append(Rail(pin.net, at[0], end, pin.side == "top", bar))
    layout.wires.append(Wire(pin.net, *at, at[0], end))
    said = _rail_text(pin, text)
    if said:
        box = _name_box(pin, (at[0] + _BAR - 1.0, at[1]), said)
        layout.labels.append(Label(said, box, pin.net))


def _dots(layout: Layout) -> list[tuple[float, float]]:
    """Points where a net leaves in three directions or more."""
    ways: dict[tuple[float, float], set[tuple[int, int]]] = {}
    across: dict[float, list[Wire]] = {}
    upright: dict[float, list[Wire]] = {}
    for wire_ in layout.wires:
        for point in ((wire_.x0, wire_.y0), (wire_.x1, wire_.y1)):
            ways.setdefault(point, set())
        if wire_.y0 == wire_.y1:
            across.setdefault(wire_.y0, []).append(wire_)
        if wire_.x0 == wire_.x1:
            upright.setdefault(wire_.x0, []).append(wire_)
    for x, y in ways:
        for w in (*across.get(y, ()), *upright.get(x, ())):
            ways[x, y] |= _ways_from(x, y, w)
    for s in layout.symbols:
        for sign in (1, -1):
            ways.get((s.x, s.y + sign * HALF), set()).add((0, -sign))
        if s.part.is_transistor:
            side = 1 if s.flipped else -1
            ways.get((s.x + side * GATE, s.y), set()).add((-side, 0))
    return sorted(point for point, found in ways.items() if len(found) > 2)


def _ways_from(x: float, y: float, w: Wire) -> set[tuple[int, int]]:
    """Directions in which a wire leaves a point, of those right, left, up and down."""
    found = set()
    low_x, high_x = sorted((w.x0, w.x1))
    low_y, high_y = sorted((w.y0, w.y1))
    if low_y == high_y == y and low_x <= x <= high_x:
        found |= {(d, 0) for d, there in ((1, high_x > x), (-1, low_x < x)) if there}
    if low_x == high_x == x and low_y <= y <= high_y:
        found |= {(0, d) for d, there in ((1, high_y > y), (-1, low_y < y)) if there}
    return found
