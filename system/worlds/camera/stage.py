"""What a camera can see of a scene, as arrays for the compiled renderer.

Every body is a solid with upright sides (a prism or a cylinder), every wall a plane. A side has bands: one
over the whole of it, and tape over that. A texture is kept as its integral along the side, so that the mean
over any stretch is exact and moves without jumps.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from shapely.geometry import Point as Spot
from shapely.geometry import Polygon

from circuits.arrays import F64, I64
from system.worlds.arena.motion import Motions, motions_of
from system.worlds.arena.scene import Body, Scene, Tape, Wall

CELLS = 256  # of a texture, after which it repeats
SHADING = 0.08  # share of the light that a side facing away from the lamp lacks; ours
LAMP = math.radians(60.0)  # direction in which the brightest light comes from, from x; ours
PLAIN = -1  # in the place of a texture


class Stage(NamedTuple):
    """The solids of a scene, then its walls, as arrays in SI units.

    Faces: side (float64[faces, 4], m: x, y of both ends in the body's frame), owner (its solid), band_begin
    ([faces + 1]). Solids: begin ([solids + 1], their faces), radius (m, 0 for prisms), base and height (m),
    top (reflectance), closed (1 where it has an inside). Bands: band (float64[bands, 4]: from and to m
    above the floor, reflectance, m of a cell), texture (number or `PLAIN`). weave: float64[textures, CELLS
    + 1], the integral of each in cells. Shades: shade (float64[corners, 2], m), shade_begin, shade_factor.
    Lights: lamp (float64[lights, 6]: height and radius m, luminance lux, period s, share on, body).
    """

    side: F64
    owner: I64
    band_begin: I64
    begin: I64
    radius: F64
    base: F64
    height: F64
    top: F64
    closed: I64
    band: F64
    texture: I64
    weave: F64
    shade: F64
    shade_begin: I64
    shade_factor: F64
    lamp: F64
    floor: float
    sky: float
    light: float
    motions: Motions


def stage_of(scene: Scene) -> Stage:
    """Return the arrays of a scene."""
    walls = [_as_body(w) for w in scene.walls]
    things = [*scene.bodies, *walls]
    sides = [_sides(b) for b in scene.bodies] + [np.array([[*w.start, *w.end]]) for w in scene.walls]
    factors = [_light_at(scene, b) for b in things]
    weaves, bands, textures, band_begin = _bands(scene, sides, factors)
    counts = [len(s) for s in sides]
    corners = [np.array(s.corners) for s in scene.shades]
    lamps = [
        [b.led.height, 0.5 * b.led.diameter, b.led.luminance, b.led.period, b.led.on, float(k)]
        for k, b in enumerate(scene.bodies)
        if b.led is not None
    ]
    return Stage(
        side=np.concatenate([np.empty((0, 4)), *sides]),
        owner=np.repeat(np.arange(len(things)), counts).astype(np.int64),
        band_begin=band_begin,
        begin=_begins(counts),
        radius=np.array([0.5 * b.size[0] if b.is_round else 0.0 for b in things]),
        base=np.array([b.base for b in things]),
        height=np.array([b.height for b in things]),
        top=np.array(
            [f * (b.reflectance if b.top is None else b.top) for b, f in zip(things, factors, strict=True)]
        ),
        closed=np.array([1] * len(scene.bodies) + [0] * len(walls), dtype=np.int64),
        band=bands,
        texture=textures,
        weave=weaves,
        shade=np.concatenate([np.empty((0, 2)), *corners]),
        shade_begin=_begins([len(c) for c in corners]),
        shade_factor=np.array([s.factor for s in scene.shades]),
        lamp=np.array(lamps, dtype=float).reshape(-1, 6),
        floor=scene.floor,
        sky=scene.sky,
        light=scene.light,
        motions=motions_of((*scene.bodies, *walls)),
    )


def darkest(stage: Stage) -> float:
    """Lux (times reflectance) below which nothing in a stage can be."""
    weaves = [float(np.diff(w).min()) for w in stage.weave]
    bands = stage.band[:, 2] * np.array([1.0 if t == PLAIN else weaves[t] for t in stage.texture])
    least = min(
        float(bands.min(initial=stage.floor)), float(stage.top.min(initial=stage.floor)), stage.floor,
        stage.sky, stage.floor * float(stage.shade_factor.min(initial=1.0)),
    )  # fmt: skip
    return stage.light * least * (1.0 - SHADING)


def _as_body(wall: Wall) -> Body:
    """A wall as a body whose frame is the world's."""
    return Body("wall", (0.0, 0.0), (0.0, 0.0), wall.height, wall.reflectance, base=wall.base)


def _sides(body: Body) -> F64:
    """Sides of a prism, counter-clockwise; a cylinder has one, without ends."""
    if body.is_round:
        return np.zeros((1, 4))
    x, y = 0.5 * body.size[0], 0.5 * body.size[1]
    return np.array([[-x, -y, x, -y], [x, -y, x, y], [x, y, -x, y], [-x, y, -x, -y]])


def _bands(scene: Scene, sides: list[F64], factors: list[float]) -> tuple[F64, F64, I64, I64]:
    """Textures, bands, the texture of each, and where each face's begin."""
    weaves: list[F64] = []
    bands: list[list[float]] = []
    textures: list[int] = []
    counts: list[int] = []
    for k, (side, factor) in enumerate(zip(sides, factors, strict=True)):
        thing: Body | Wall = scene.bodies[k] if k < len(scene.bodies) else scene.walls[k - len(scene.bodies)]
        tape = thing.tape if isinstance(thing, Wall) else None
        for _ in side:
            bands.append([thing.base, thing.height, factor * thing.reflectance, 1.0])
            textures.append(PLAIN)
            if tape is not None:
                bands.append([tape.low, tape.high, factor, tape.cell])
                textures.append(len(weaves))
                weaves.append(_weave(tape))
            counts.append(1 if tape is None else 2)
    return (
        np.array(weaves).reshape(-1, CELLS + 1),
        np.array(bands, dtype=float).reshape(-1, 4),
        np.array(textures, dtype=np.int64),
        _begins(counts),
    )


def _weave(tape: Tape) -> F64:
    """Integral of the shades of a tape's cells, float64[CELLS + 1]."""
    shades = np.random.default_rng((tape.seed, 2)).uniform(tape.dark, tape.pale, CELLS)
    return np.concatenate([[0.0], np.cumsum(shades)])


def _light_at(scene: Scene, body: Body) -> float:
    """Share of the light that falls on what stands still; what walks by is lit as in the open."""
    if body.motion is not None:
        return 1.0
    factors = [
        s.factor for s in scene.shades if body.base < _LOW and Polygon(s.corners).contains(Spot(body.at))
    ]
    return min(factors, default=1.0)


_LOW = 0.3  # m; what begins higher than this is lit from above


def _begins(counts: list[int]) -> I64:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
