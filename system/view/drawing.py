"""A schematic as strokes and texts with places: plain data, points, the origin at the top left, y down.

Each piece knows the device or the net that it is of, so that a page can say what happens there at a time. A
text of a `value` has room behind it for one. `system.schematic.drawing` makes it of a circuit.
"""

from __future__ import annotations

from dataclasses import dataclass

Point = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Stroke:
    """A line through points, or a circle about one.

    Attributes
    ----------
    points : tuple of (float, float)
        Its corners, points, or its centre.
    radius : float
        Of a circle, points; 0 for a line.
    device, net : str
        The device or the net that it is of; one of them is empty.
    filled : bool
        Whether it is the rim of a filled area.
    """

    points: tuple[Point, ...]
    radius: float = 0.0
    device: str = ""
    net: str = ""
    filled: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    """A line of text of a net, or of a device where that is named.

    Attributes
    ----------
    text : str
        What stands there; empty where there is a value alone.
    value : bool
        Whether a voltage or a current has room behind it.
    at : (float, float)
        Its left end, in the middle of its height, points.
    net, device : str
        Which it is of; one of them is empty.
    """

    text: str
    value: bool = False
    at: Point = (0.0, 0.0)
    net: str = ""
    device: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawing:
    """A schematic.

    Attributes
    ----------
    width, height : float
        Points.
    strokes : tuple of Stroke
        Its lines and circles.
    texts : tuple of Text
        What is written.
    """

    width: float
    height: float
    strokes: tuple[Stroke, ...]
    texts: tuple[Text, ...]
