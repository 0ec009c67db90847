"""What each pixel sees of a stage: intensity by exact coverage, compiled.

Upright sides have upright edges in the picture, so a column is divided where edges fall into it; in each part
one ray meets all sides, and these are painted from far to near with fractional rows at their ends. So an edge
that moves by a tenth of a pixel changes the intensity by a tenth of the step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from system.worlds.camera.project import (
    ALONG_X,
    ALONG_Y,
    DEPTH_0,
    DEPTH_1,
    LIT,
    NEAR,
    U_HIGH,
    U_LOW,
    X0,
    Y0,
    Camera,
    Sketch,
    lit,
    project_solid,
)
from system.worlds.camera.stage import CELLS, Stage

_compiled = compiled()
# without a call, for which the hundred numbers that say where all arrays are would be copied each time
_inlined = compiled(forceinline=True)


class View(NamedTuple):
    """Where the lens is (m, m, rad), and how many solids are in the picture.

    x : of the lens, m.
    y : of the lens, m.
    heading : rad.
    shown : solids in the picture.
    """

    x: float
    y: float
    heading: float
    shown: int


@_compiled
def render(stage: Stage, camera: Camera, s: Sketch, x: float, y: float, heading: float) -> None:
    """Fill the light on the pixels for a robot at (x, y) m and `heading` rad; `pose` must be filled."""
    cos, sin = math.cos(heading), math.sin(heading)
    eye_x, eye_y = x + camera.ahead * cos, y + camera.ahead * sin
    s.edge_count[:] = 0
    shown = 0
    for k in range(stage.base.size):
        project_solid(stage, camera, s, k, eye_x, eye_y, heading)
        if s.span[k, 0] < camera.columns and s.span[k, 1] > 0.0:
            s.shown[shown] = k
            shown += 1
    view = View(eye_x, eye_y, heading, shown)
    for column in range(camera.columns):
        light = s.light[column * camera.rows : (column + 1) * camera.rows]
        parts = s.edge_count[column]
        line, low = light, float(column)
        if parts > 0:
            line = s.line
            _level(light, 0.0)
        for part in range(parts + 1):
            high = column + 1.0 if part == parts else s.edges[column, part]
            if high - low > 1e-9:
                _paint_part(stage, camera, s, line, low, high, view)
                if parts > 0:
                    _add_part(light, line, high - low)
            low = max(high, low)


@_compiled
def _add_part(light: F64, line: F64, width: float) -> None:
    """Add a part of a column, painted on the line, to what its pixels have."""
    for row in range(light.size):
        light[row] = width * line[row] + light[row]


@_inlined
def _paint_part(
    stage: Stage, camera: Camera, s: Sketch, line: F64, low: float, high: float, view: View
) -> None:
    """Paint what lies between columns `low` and `high` on a line."""
    u = 0.5 * (low + high)
    half = camera.rows // 2
    _level(line[:half], stage.light * stage.floor)
    _level(line[half:], stage.light * stage.sky)
    slope = (0.5 * camera.columns - u) / camera.focal
    for k in range(stage.shade_factor.size):
        _paint_shade(stage, camera, line, k, slope, view)
    hits = 0
    for j in range(view.shown):
        k = s.shown[j]
        if s.span[k, 0] <= u < s.span[k, 1] and meet(stage, s, k, u, slope):
            i = hits
            while i > 0 and s.hit[s.order[i - 1], 0] < s.hit[k, 0]:
                s.order[i] = s.order[i - 1]
                i -= 1
            s.order[i] = k
            hits += 1
    for i in range(hits):
        _paint_solid(stage, camera, s, line, s.order[i], low, high, view.heading)


@_compiled
def _level(part: F64, value: float) -> None:
    for row in range(part.size):
        part[row] = value


@_compiled
def meet(stage: Stage, s: Sketch, k: int, u: float, slope: float) -> bool:
    """Where the ray through column u enters and leaves solid k, m ahead."""
    first, last = stage.begin[k], stage.begin[k + 1]
    if stage.radius[k] > 0.0:
        x, y, radius = s.seen[first, X0], s.seen[first, Y0], stage.radius[k]
        a, b, c = 1.0 + slope * slope, x + slope * y, x * x + y * y - radius * radius
        root = math.sqrt(max(b * b - a * c, 0.0))
        s.hit[k, 0], s.hit[k, 1] = max((b - root) / a, NEAR), max((b + root) / a, NEAR)
        s.hit_face[k] = first
        return True
    # where 1/x is greatest the side is nearest
    most, least, face = -np.inf, np.inf, -1
    for i in range(first, last):
        if s.seen[i, U_LOW] <= u < s.seen[i, U_HIGH]:
            inverse = max(s.seen[i, DEPTH_0] + s.seen[i, DEPTH_1] * u, 1e-6)
            least = min(least, inverse)
            if inverse > most:
                most, face = inverse, i
    if face < 0:
        return False
    s.hit[k, 0], s.hit[k, 1], s.hit_face[k] = max(1.0 / most, NEAR), max(1.0 / least, NEAR), face
    return True


@_compiled
def _paint_solid(
    stage: Stage, camera: Camera, s: Sketch, line: F64, k: int, low: float, high: float, heading: float
) -> None:
    """Paint a solid that the ray meets: its upper or under side if that shows, then its near side."""
    face = s.hit_face[k]
    near = camera.focal / s.hit[k, 0]
    far = camera.focal / s.hit[k, 1]
    middle = 0.5 * camera.rows
    below, above = stage.base[k] - camera.height, stage.height[k] - camera.height
    if stage.closed[k] == 1 and above < 0.0:
        # begins at a whole row inside the near side, so that no gap shows between the two
        joint = max(math.floor(middle + near * above), middle + near * below)
        _fill(line, joint, middle + far * above, stage.light * stage.top[k])
    if stage.closed[k] == 1 and below > 0.0:
        joint = min(math.ceil(middle + near * below), middle + near * above)
        _fill(line, middle + far * below, joint, stage.light * stage.top[k])
    shade = s.seen[face, LIT]
    if stage.radius[k] > 0.0:
        slope = (0.5 * camera.columns - 0.5 * (low + high)) / camera.focal
        dx, dy = s.hit[k, 0] - s.seen[face, X0], s.hit[k, 0] * slope - s.seen[face, Y0]
        shade = lit(math.atan2(dy, dx) + heading)
    for i in range(stage.band_begin[face], stage.band_begin[face + 1]):
        band = stage.band[i]
        value = band[2]
        if stage.texture[i] >= 0:
            ends = _along(camera, s, face, low), _along(camera, s, face, high)
            value *= _mean(stage.weave[stage.texture[i]], ends[0] / band[3], ends[1] / band[3])
        bottom, top = band[0] - camera.height, band[1] - camera.height
        _fill(line, middle + near * bottom, middle + near * top, stage.light * shade * value)


@_compiled
def _along(camera: Camera, s: Sketch, face: int, u: float) -> float:
    """How far along a plane (m from its first end) column u meets it."""
    seen = s.seen[face]
    depth = 1.0 / max(seen[DEPTH_0] + seen[DEPTH_1] * u, 1e-6)
    y = depth * (0.5 * camera.columns - u) / camera.focal
    return float((depth - seen[X0]) * seen[ALONG_X] + (y - seen[Y0]) * seen[ALONG_Y])


@_compiled
def _mean(weave: F64, a: float, b: float) -> float:
    """Mean of a texture between two places, in cells."""
    if math.floor(a) == math.floor(b):  # exactly alike from picture to picture, so that pixels stay steady
        i = math.floor(a) % CELLS
        return float(weave[i + 1] - weave[i])
    return (_integral(weave, b) - _integral(weave, a)) / (b - a)


@_compiled
def _integral(weave: F64, a: float) -> float:
    turns = math.floor(a / CELLS)
    rest = a - turns * CELLS
    i = min(int(rest), CELLS - 1)
    return float(turns * weave[CELLS] + weave[i] + (rest - i) * (weave[i + 1] - weave[i]))


@_compiled
def _fill(line: F64, low: float, high: float, value: float) -> None:
    """Paint rows from `low` to `high`, the ends by their share."""
    low, high = max(low, 0.0), min(high, float(line.size))
    if high <= low:
        return
    first, last = int(low), int(high)
    if first == last:
        line[first] += (high - low) * (value - line[first])
        return
    line[first] += (first + 1.0 - low) * (value - line[first])
    _level(line[first + 1 : last], value)
    if last < line.size:
        line[last] += (high - last) * (value - line[last])


@_compiled
def _paint_shade(stage: Stage, camera: Camera, line: F64, k: int, slope: float, view: View) -> None:
    """Darken the floor where the ray crosses a shade, from the nearest to the farthest depth."""
    cos, sin = math.cos(view.heading), math.sin(view.heading)
    dx, dy = cos - slope * sin, sin + slope * cos  # of the ray on the floor, a metre ahead
    near, far = NEAR, np.inf
    first, last = stage.shade_begin[k], stage.shade_begin[k + 1]
    area = 0.0
    for i in range(first, last):
        j = i + 1 if i + 1 < last else first
        area += stage.shade[i, 0] * stage.shade[j, 1] - stage.shade[j, 0] * stage.shade[i, 1]
    turn = 1.0 if area > 0.0 else -1.0
    for i in range(first, last):
        j = i + 1 if i + 1 < last else first
        ex, ey = stage.shade[j, 0] - stage.shade[i, 0], stage.shade[j, 1] - stage.shade[i, 1]
        inside = turn * (ex * (view.y - stage.shade[i, 1]) - ey * (view.x - stage.shade[i, 0]))
        change = turn * (ex * dy - ey * dx)
        if abs(change) < 1e-12:
            if inside < 0.0:
                return
        elif change > 0.0:
            near = max(near, -inside / change)
        else:
            far = min(far, -inside / change)
    if far > near:
        middle, drop = 0.5 * camera.rows, camera.focal * camera.height
        value = stage.light * stage.floor * stage.shade_factor[k]
        _fill(line, middle - drop / near, middle - drop / far, value)
