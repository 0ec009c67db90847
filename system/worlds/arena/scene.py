"""Scenes for small robots: what stands where, how light it is, and what moves (Milde et al. 2017, section 3).

A scene is a floor plan with upright things on it: walls (with a band of textured tape), boxes and cylinders
with a height and a colour, which may move along a path; a room behind the walls; shade on the floor.

The paper names white floor and walls, tape with a contrastive texture, blocks 2.5 cm wide and 10 cm high or
of 2 x 5 cm, blue, red and yellow ones, normal, dark and very dark light, a cup moved at about 0.2 m/s, and
the target's LED, blinking at 200 Hz and on for 75 %. All other numbers of this file are ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.units import parse_quantity
from system.option import Checked, check_options, option, required
from system.worlds.arena.keys import from_zero, length, share, whole

Point = tuple[float, float]
Repeat = Literal["stop", "shuttle", "loop"]

# Share of the light that a sensor of silicon sees come back, without unit; ours. White to blue is a step of
# 1.7 in log light, to red 0.75, to yellow 0.53: two thresholds of the sensor (0.21 and 0.24). That was
# fitted to the yellow row of Table 1 of Milde et al. 2017, where two blocks of three are avoided in one cell
# of seven; below a threshold, at 0.17, none is in any.
COLOURS: dict[str, float] = {
    "white": 0.85,
    "yellow": 0.50,
    "wood": 0.50,
    "red": 0.40,
    "grey": 0.35,
    "blue": 0.15,
    "black": 0.06,
}
LIGHTS: dict[str, float] = {"normal": 500.0, "dark": 20.0, "very-dark": 1.0}  # lux on the floor; ours

_BLINK_PERIOD = 1.0 / 200.0  # s; the paper's
_BLINK_ON = 0.75  # of a period; the paper's
_TRIES = 10_000  # draws until what is scattered counts as too much


@dataclass(frozen=True, slots=True)
class Led(Checked):
    """A light on top of a body that blinks.

    A luminance of 5e4 lux is that of a light of 5 mm and 0.3 cd: L = 0.3 cd / (pi (2.5 mm)^2) = 1.5e4 cd/m^2,
    times pi; ours.
    """

    height: float = length(0.11, "Above the floor")
    diameter: float = length(0.005, "Of the light")
    luminance: float = option(5e4, "As of a white floor on which so much light falls", unit="lux", above=0.0)
    period: float = option(_BLINK_PERIOD, "From one flash to the next", unit="s", above=0.0)
    on: float = share(_BLINK_ON, "Share of the period for which it is lit")


@dataclass(frozen=True, slots=True)
class Motion:
    """A way that a body takes: along a path at a constant speed."""

    path: tuple[Point, ...] = required("Points [x, y] that it passes, from the first on", unit="m", fewest=2)
    speed: float = required("Along the path", unit="m/s", above=0.0)
    start: float = option(0.0, "When it sets out, below 0 if it is on its way at the beginning", unit="s")
    repeat: Repeat = option("stop", "What it does at the end: stop, go back, or begin again")

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self)
        if len(set(self.path)) == 1:
            raise ParameterError(f"path: {self.path[0]}, must lead somewhere; give two different points")


@dataclass(frozen=True, slots=True)
class Body:
    """Something upright that stands or moves on the floor.

    size: (length along its heading, width across), m; a cylinder has one diameter, twice.
    base, height: m above the floor of its underside and its top.
    reflectance: without unit; top: of its upper side.
    swing: m to and fro along its heading as it moves, at `swing_phase` rad: the legs of walking people.

    name : what it is called where something touches it.
    is_round : whether it is a cylinder.
    motion : how it moves; None where it stands.
    led : a light on top; None for none.
    """

    name: str
    at: Point
    size: tuple[float, float]
    height: float
    reflectance: float
    heading: float = 0.0
    base: float = 0.0
    top: float | None = None
    is_round: bool = False
    motion: Motion | None = None
    swing: float = 0.0
    swing_phase: float = 0.0
    led: Led | None = None


@dataclass(frozen=True, slots=True)
class Tape:
    """Textured tape on a wall: square cells, each of a random shade."""

    low: float = from_zero(0.01, "Lower edge above the floor")
    high: float = length(0.06, "Upper edge above the floor")
    cell: float = length(0.005, "Side of a cell")
    dark: float = share(0.30, "Reflectance of the darkest cell")
    pale: float = share(0.85, "Reflectance of the palest cell")
    seed: int = whole(0, "Of the shades")

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self)
        if self.low >= self.high:
            raise ParameterError(f"low: {self.low:g} m, must be below high, {self.high:g} m")


@dataclass(frozen=True, slots=True)
class Wall:
    """An upright plane between two points (m), seen from both sides.

    start : one end, m.
    end : the other end, m.
    height : of its upper edge above the floor, m.
    reflectance : without unit.
    tape : textured tape on it; None for none.
    base : of its lower edge above the floor, m.
    """

    start: Point
    end: Point
    height: float
    reflectance: float
    tape: Tape | None = None
    base: float = 0.0


@dataclass(frozen=True, slots=True)
class Shade:
    """A convex part of the floor on which less light falls."""

    corners: tuple[Point, ...] = required("Points [x, y] round it", unit="m", fewest=3)
    factor: float = required("Share of the light that falls there", unit="", above=0.0, most=1.0)


@dataclass(frozen=True, slots=True)
class Scene:
    """A world, and where the robot starts in it.

    Attributes
    ----------
    name : str
        What reports call it: the name of its file, without the ending.
    summary : str
        What it is, in a line.
    light : float
        Light on the floor, lux.
    corners : tuple of (float, float)
        Corners of the floor, which nobody leaves, m.
    start : tuple of float
        Place (m, m) of the robot at the start, and its heading (rad, counter-clockwise from x).
    bodies : tuple of Body
        Everything upright but walls.
    walls : tuple of Wall
        The walls.
    shades : tuple of Shade
        Parts of the floor with less light.
    floor : float
        Share of light that the floor reflects.
    sky : float
        Share of light that is reflected by what nothing stands before.
    partitions : tuple
        Corners (m) of the walls inside, which stand among `walls` too.
    duration : float or None
        Length of a run, s; None where the scene does not say.
    """

    name: str
    summary: str
    light: float
    corners: tuple[Point, ...]
    start: tuple[float, float, float]
    bodies: tuple[Body, ...]
    walls: tuple[Wall, ...]
    shades: tuple[Shade, ...] = ()
    floor: float = COLOURS["white"]
    sky: float = COLOURS["white"]
    partitions: tuple[tuple[Point, ...], ...] = ()
    duration: float | None = None


def light_of(light: str | float) -> float:
    """Lux of a light condition, of a number, or of a text such as `500lux`.

    Raises `ParameterError` for other names and for what is not above 0.
    """
    if isinstance(light, str) and light in LIGHTS:
        return LIGHTS[light]
    try:
        lux = parse_quantity(light, "lux", "light") if isinstance(light, str) else light
    except ParameterError:
        lux = math.nan
    if not (lux > 0.0 and math.isfinite(lux)):
        raise ParameterError(
            f"light: {light}, must be {', '.join(LIGHTS)} or an illuminance above 0; write as in 500lux"
        )
    return lux


def _reflectance_of(colour: str) -> float:
    """Reflectance of a colour's name; raises `ParameterError` for other names."""
    if colour not in COLOURS:
        raise ParameterError(f"colour: {colour}, must be one of {', '.join(COLOURS)}")
    return COLOURS[colour]


def recoloured(scene: Scene, colour: str) -> Scene:
    """Return the scene with its blocks in another colour."""
    reflectance = _reflectance_of(colour)
    bodies = tuple(
        replace(b, reflectance=reflectance, top=None) if b.name.startswith("block") else b
        for b in scene.bodies
    )
    return replace(scene, bodies=bodies)


def backdrop(corners: tuple[Point, ...], distance: float, seed: int) -> tuple[Wall, ...]:
    """A room about the floor, `distance` m beyond its bounds, with things of random shades along its walls.

    Each wall has three bands: furniture to 0.9 m, pictures and windows to 1.9 m, plain wall above; ours.
    """
    x, y = zip(*corners, strict=True)
    low, high = (min(x) - distance, min(y) - distance), (max(x) + distance, max(y) + distance)
    ring = (low, (high[0], low[1]), high, (low[0], high[1]))
    bands = ((0.0, 0.9, 0.45, 0.15, 0.6), (0.9, 1.9, 0.8, 0.3, 0.85), (1.9, 3.0, 5.0, 0.75, 0.75))
    return tuple(
        Wall(
            ring[k], ring[(k + 1) % 4], top, COLOURS["wood"],
            Tape(base, top, cell, dark, pale, seed=16 * seed + 4 * band + k), base,
        )
        for k in range(4)
        for band, (base, top, cell, dark, pale) in enumerate(bands)
    )  # fmt: skip


def scatter(
    random: np.random.Generator,
    count: int,
    bounds: tuple[Point, Point],
    spacing: float,
    start: Point,
    clear: float,
) -> F64:
    """Places (m, float64[count, 2]) in a rectangle, `spacing` apart, and `clear` from the start.

    Raises
    ------
    ParameterError
        So many find no place.
    """
    low, high = bounds
    places = np.empty((0, 2))
    for _ in range(_TRIES):
        if len(places) == count:
            return places
        point = random.uniform(low, high)
        near = np.hypot(*(places - point).T).min(initial=np.inf) < spacing
        if not near and math.dist(point, start) >= clear:
            places = np.vstack([places, point])
    raise ParameterError(
        f"clutter.count: {count}, must find room {spacing:g} m apart in {high[0] - low[0]:.3g} x"
        f" {high[1] - low[1]:.3g} m; ask for fewer or a smaller spacing"
    )
