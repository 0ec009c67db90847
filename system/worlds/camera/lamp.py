"""Blinking lights in a picture, compiled: the pixels that they fall on, and what they add there while on.

A light is smaller than a pixel from 0.6 m on. It is seen as a square of the same area, blurred by a Gaussian
(the lens, and carriers that diffuse in the silicon) and integrated over each pixel, so that a moving light
goes over from pixel to pixel without jumps. Scenery is not blurred: its events are as many, a little later.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled
from system.worlds.camera.project import NEAR, Camera, Sketch
from system.worlds.camera.render import meet
from system.worlds.camera.stage import Stage

MOST = 4096  # pixels; those beyond stay dark
REACH = 4.0  # sigma of the blur that count; a millionth is beyond
HEIGHT, RADIUS, LUMINANCE, PERIOD, ON, BODY = range(6)
_compiled = compiled()


class Glow(NamedTuple):
    """Lit pixels: their numbers, lux that their light adds while on, its number; used: int64[1].

    tall: float64[rows], room for a light's share of each row.
    """

    pixel: I64
    lux: F64
    lamp: I64
    used: I64
    tall: F64


def no_glow(rows: int = 128) -> Glow:
    """Room for lit pixels of a sensor of so many rows."""
    return Glow(
        np.zeros(MOST, dtype=np.int64),
        np.zeros(MOST),
        np.zeros(MOST, dtype=np.int64),
        np.zeros(1, dtype=np.int64),
        np.zeros(rows),
    )


@_compiled
def find_lamps(
    stage: Stage, camera: Camera, s: Sketch, glow: Glow, x: float, y: float, heading: float
) -> None:
    """Fill in the pixels of the lights that nothing hides, after `render` at the same pose."""
    glow.used[0] = 0
    cos, sin = math.cos(heading), math.sin(heading)
    for k in range(stage.lamp.shape[0]):
        lamp = stage.lamp[k]
        body = int(lamp[BODY])
        dx, dy = s.pose[body, 0] - x - camera.ahead * cos, s.pose[body, 1] - y - camera.ahead * sin
        ahead, left = cos * dx + sin * dy, cos * dy - sin * dx
        if ahead < NEAR:
            continue
        u = 0.5 * camera.columns - camera.focal * left / ahead
        v = 0.5 * camera.rows + camera.focal * (lamp[HEIGHT] - camera.height) / ahead
        if not _is_hidden(stage, camera, s, body, u, v, ahead):
            _spread(camera, glow, k, lamp, u, v, camera.focal / ahead)


@_compiled
def _is_hidden(stage: Stage, camera: Camera, s: Sketch, body: int, u: float, v: float, ahead: float) -> bool:
    """Whether a solid other than the light's own stands before it."""
    slope = (0.5 * camera.columns - u) / camera.focal
    for k in range(stage.base.size):
        if k == body or not s.span[k, 0] <= u < s.span[k, 1] or not meet(stage, s, k, u, slope):
            continue
        scale = camera.focal / s.hit[k, 0]
        bottom = 0.5 * camera.rows + scale * (stage.base[k] - camera.height)
        top = 0.5 * camera.rows + scale * (stage.height[k] - camera.height)
        if s.hit[k, 0] < ahead and bottom <= v <= top:
            return True
    return False


@_compiled
def _spread(camera: Camera, glow: Glow, k: int, lamp: F64, u: float, v: float, scale: float) -> None:
    """Add a light to the pixels that its blurred square reaches; `scale` is pixels per m at its distance."""
    half = 0.5 * math.sqrt(math.pi) * lamp[RADIUS] * scale
    flux, reach = lamp[LUMINANCE] * (2.0 * half) ** 2, half + REACH * camera.blur
    first, last = max(math.floor(v - reach), 0), min(math.floor(v + reach) + 1, camera.rows)
    for row in range(first, last):
        glow.tall[row] = _share(row - v, half, camera.blur)
    for column in range(max(math.floor(u - reach), 0), min(math.floor(u + reach) + 1, camera.columns)):
        wide = _share(column - u, half, camera.blur)
        for row in range(first, last):
            i = glow.used[0]
            if i < glow.pixel.size:
                glow.pixel[i], glow.lux[i], glow.lamp[i] = (
                    column * camera.rows + row, flux * wide * glow.tall[row], k,
                )  # fmt: skip
                glow.used[0] += 1


@_compiled
def _share(left: float, half: float, sigma: float) -> float:
    """Share of a blurred line from -half to half that falls on a pixel from `left` to `left + 1`."""
    ends = _ramp(left + 1.0 + half, sigma) - _ramp(left + half, sigma)
    return float((ends - _ramp(left + 1.0 - half, sigma) + _ramp(left - half, sigma)) / (2.0 * half))


@_compiled
def _ramp(x: float, sigma: float) -> float:
    """Integral of a blurred step up to x: x Phi(x / sigma) + sigma phi(x / sigma)."""
    z = x / sigma
    bell = math.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi)
    return float(0.5 * x * (1.0 + math.erf(z / math.sqrt(2.0))) + sigma * bell)


@_compiled
def is_on(lamp: F64, time: float) -> bool:
    """Whether a light is on at `time` s; it goes on at whole periods."""
    return bool(time / lamp[PERIOD] - math.floor(time / lamp[PERIOD]) < lamp[ON])
