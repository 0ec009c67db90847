"""Symbols of a schematic as lines and circles about a centre, points.

They are our own, not schemdraw's: the layout must know each symbol's box and terminals, and these are all.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from circuits.circuit import GROUND
from system.schematic.geometry import GATE, HALF, Rail, Symbol
from system.schematic.part import Part

Line = tuple[tuple[float, float], ...]


class Shape(NamedTuple):
    """Lines, circles (x, y, radius) and filled polygons."""

    lines: tuple[Line, ...]
    circles: tuple[tuple[float, float, float], ...] = ()
    filled: tuple[Line, ...] = ()


def shape_of(part: Part) -> Shape:
    """Shape of a part's symbol about its centre, its gate at the left."""
    if part.is_transistor:
        return _transistor(part)
    return _SHAPES[part.kind]


def lines_of(symbol: Symbol) -> Iterator[tuple[Line, bool]]:
    """Yield the lines of a symbol at its place, and whether each is the rim of a filled area."""
    shape, turn = shape_of(symbol.part), -1.0 if symbol.flipped else 1.0
    for lines, filled in ((shape.lines, False), (shape.filled, True)):
        for line in lines:
            yield tuple((symbol.x + turn * x, symbol.y + y) for x, y in line), filled


def circles_of(symbol: Symbol) -> Iterator[tuple[float, float, float]]:
    """Yield the circles of a symbol at its place: x, y and radius."""
    turn = -1.0 if symbol.flipped else 1.0
    for x, y, radius in shape_of(symbol.part).circles:
        yield symbol.x + turn * x, symbol.y + y, radius


def bars_of(rail: Rail) -> Iterator[Line]:
    """Yield the bars of a rail: one; for ground at the bottom three, each shorter than the last."""
    ground = rail.net == GROUND and not rail.above
    for n, half in enumerate((8.0, 5.0, 2.0) if ground else (8.0,)):
        y = rail.y - (2.2 * n if ground else 0.0)
        yield (rail.x - half, y), (rail.x + half, y)


def _transistor(part: Part) -> Shape:
    """Gate, channel, and an arrow at the source along the current; the gate of a pFET has a circle."""
    gate_end = -12.0 if part.kind == "nfet" else -17.0
    lines: tuple[Line, ...] = (
        ((0.0, HALF), (0.0, 9.0), (-8.0, 9.0)),
        ((0.0, -HALF), (0.0, -9.0), (-8.0, -9.0)),
        ((-8.0, -12.0), (-8.0, 12.0)),
        ((-12.0, -10.0), (-12.0, 10.0)),
        ((-GATE, 0.0), (gate_end, 0.0)),
    )
    circles = () if part.kind == "nfet" else ((-14.5, 0.0, 2.5),)
    y = 9.0 if part.source_up else -9.0
    tip, base = (-1.5, -6.5) if part.kind == "nfet" else (-7.0, -2.0)
    return Shape(lines, circles, (((tip, y), (base, y + 2.8), (base, y - 2.8)),))


def _leads(reach: float) -> tuple[Line, ...]:
    return (((0.0, HALF), (0.0, reach)), ((0.0, -HALF), (0.0, -reach)))


def _diode(down: float) -> Shape:
    """Triangle from the anode and bar at the cathode; down: 1.0 for the anode above."""
    bar = ((-8.0, -7.0 * down), (8.0, -7.0 * down))
    triangle = ((-7.0, 6.0 * down), (7.0, 6.0 * down), (0.0, -7.0 * down))
    return Shape((*_leads(6.5), bar), (), (triangle,))


_CONTROLS: tuple[Line, ...] = (((-GATE, 10.0), (-12.0, 10.0)), ((-GATE, -10.0), (-12.0, -10.0)))
_ARROW: tuple[Line, ...] = (((0.0, -6.0), (-3.0, 0.0), (3.0, 0.0)),)
_SHAPES: dict[str, Shape] = {
    "capacitor": Shape((*_leads(2.5), ((-8.0, 2.5), (8.0, 2.5)), ((-8.0, -2.5), (8.0, -2.5)))),
    "diode": _diode(1.0),
    "diode up": _diode(-1.0),
    "resistor": Shape(
        (
            *_leads(14.0),
            (
                (0.0, 14.0),
                (5.0, 11.5),
                (-5.0, 7.0),
                (5.0, 2.5),
                (-5.0, -2.5),
                (5.0, -7.0),
                (-5.0, -11.5),
                (0.0, -14.0),
            ),
        )
    ),
    "voltage source": Shape(
        (*_leads(8.0), ((-2.5, 3.5), (2.5, 3.5)), ((0.0, 6.0), (0.0, 1.0)), ((-2.5, -4.0), (2.5, -4.0))),
        ((0.0, 0.0, 8.0),),
    ),
    "current source": Shape(
        (*_leads(8.0), ((0.0, -5.0), (0.0, 5.0))),
        ((0.0, 0.0, 8.0),),
        (((0.0, 6.0), (-3.0, 0.0), (3.0, 0.0)),),
    ),
    "controlled source": Shape(
        (
            *_leads(12.0),
            ((0.0, 12.0), (8.0, 0.0), (0.0, -12.0), (-8.0, 0.0), (0.0, 12.0)),
            ((0.0, 6.0), (0.0, -2.0)),
            *_CONTROLS,
            ((-15.0, 13.0), (-11.0, 13.0)),
            ((-13.0, 15.0), (-13.0, 11.0)),
            ((-15.0, -13.0), (-11.0, -13.0)),
        ),
        (),
        _ARROW,
    ),
    "operational amplifier": Shape(
        (
            ((-15.0, 17.0), (-15.0, -17.0), (16.0, 0.0), (-15.0, 17.0)),
            ((0.0, HALF), (0.0, 8.8)),
            ((0.0, -HALF), (0.0, -8.8)),
            ((-GATE, 10.0), (-15.0, 10.0)),
            ((-GATE, -10.0), (-15.0, -10.0)),
            ((16.0, 0.0), (GATE, 0.0)),
            ((-13.0, 9.0), (-8.0, 9.0)),
            ((-10.5, 11.5), (-10.5, 6.5)),
            ((-13.0, -9.0), (-8.0, -9.0)),
        )
    ),
}
