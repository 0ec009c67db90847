"""What each pixel sees of a stage: intensity by exact coverage, compiled.

A pinhole camera that looks straight ahead from `height` above the floor has, for a point ahead by x, to the
left by y and z above the floor (m),

    u = columns / 2 - f y / x,    v = rows / 2 + f (z - height) / x,    f = columns / (2 tan(field / 2))

u counts columns from the left, v rows from the bottom, both in pixels. Upright sides have upright edges in
the picture, so a column is divided where edges fall into it; in each part one ray meets all sides, and these
are painted from far to near with fractional rows at their ends. Over a plane 1/x is linear in u. So an edge
that moves by a tenth of a pixel changes the intensity by a tenth of the step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from circuits.compiled import compiled
from system.dvs_stage import CELLS, LAMP, SHADING, Stage

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

NEAR = 0.01  # m; nothing nearer is seen
EDGES = 24  # in one column; those beyond are left out
_STEEP = 20.0  # tangent beyond which an edge counts as outside the picture
(
    U_LOW, U_HIGH, DEPTH_0, DEPTH_1, X0, Y0, ALONG_X, ALONG_Y, LIT,
) = range(9)  # fmt: skip
_compiled = compiled()


class Camera(NamedTuple):
    """columns and rows; focal: pixels; height: m above the floor; ahead: m before the robot's middle.

    blur: pixels, sigma of a point of light.
    """

    columns: int
    rows: int
    focal: float
    height: float
    ahead: float
    blur: float


class Sketch(NamedTuple):
    """Room for one picture.

    pose: float64[solids, 3]; seen: float64[faces, 9], each face in the picture; span: float64[solids, 2],
    columns that each solid covers; edges: float64[columns, EDGES] with edge_count; hit: float64[solids, 2], m
    where a ray enters and leaves; hit_face, order: [solids]; line: float64[rows]; light: float64[columns *
    rows], lux times reflectance, column after column.
    """

    pose: F64
    seen: F64
    span: F64
    edges: F64
    edge_count: I64
    hit: F64
    hit_face: I64
    order: I64
    line: F64
    light: F64


def sketch_of(stage: Stage, camera: Camera) -> Sketch:
    """Room for pictures of a stage."""
    faces, solids = len(stage.side), len(stage.base)
    return Sketch(
        pose=np.zeros((solids, 3)),
        seen=np.zeros((faces, 9)),
        span=np.zeros((solids, 2)),
        edges=np.zeros((camera.columns, EDGES)),
        edge_count=np.zeros(camera.columns, dtype=np.int64),
        hit=np.zeros((solids + 1, 2)),
        hit_face=np.zeros(solids + 1, dtype=np.int64),
        order=np.zeros(solids + 1, dtype=np.int64),
        line=np.zeros(camera.rows),
        light=np.zeros(camera.columns * camera.rows),
    )


@_compiled
def render(stage: Stage, camera: Camera, s: Sketch, x: float, y: float, heading: float) -> None:
    """Fill the light on the pixels for a robot at (x, y) m and `heading` rad; `pose` must be filled."""
    cos, sin = math.cos(heading), math.sin(heading)
    eye_x, eye_y = x + camera.ahead * cos, y + camera.ahead * sin
    s.edge_count[:] = 0
    for k in range(stage.base.size):
        _project_solid(stage, camera, s, k, eye_x, eye_y, heading)
    for column in range(camera.columns):
        low = float(column)
        parts = s.edge_count[column]
        for part in range(parts + 1):
            high = column + 1.0 if part == parts else s.edges[column, part]
            if high - low > 1e-9:
                _paint_part(stage, camera, s, low, high, eye_x, eye_y, heading)
                _add_part(s.light, column * camera.rows, s.line, high - low, 0.0 if low == column else 1.0)
            low = max(high, low)


@_compiled
def _add_part(light: F64, first: int, line: F64, width: float, kept: float) -> None:
    """Add a part of a column, painted on the line, to `kept` (0 or 1) of what its pixels have."""
    for row in range(line.size):
        light[first + row] = width * line[row] + kept * light[first + row]


@_compiled
def _project_solid(
    stage: Stage, camera: Camera, s: Sketch, k: int, eye_x: float, eye_y: float, heading: float
) -> None:
    """Put a solid's faces into the picture, and their edges into its columns."""
    cos, sin = math.cos(heading), math.sin(heading)
    bx, by = s.pose[k, 0] - eye_x, s.pose[k, 1] - eye_y
    mx, my = cos * bx + sin * by, cos * by - sin * bx
    turn = s.pose[k, 2] - heading
    s.span[k, 0], s.span[k, 1] = np.inf, -np.inf
    for face in range(stage.begin[k], stage.begin[k + 1]):
        seen = s.seen[face]
        seen[U_LOW], seen[U_HIGH] = np.inf, -np.inf
        if stage.radius[k] > 0.0:
            _project_round(camera, seen, mx, my, stage.radius[k])
        else:
            side, c, n = stage.side[face], math.cos(turn), math.sin(turn)
            _project_flat(
                camera, seen, mx + c * side[0] - n * side[1], my + n * side[0] + c * side[1],
                mx + c * side[2] - n * side[3], my + n * side[2] + c * side[3],
            )  # fmt: skip
            # outward normal of a side that runs counter-clockwise: to its right
            normal = math.atan2(-seen[ALONG_X], seen[ALONG_Y]) + heading
            seen[LIT] = _lit(normal) if stage.closed[k] == 1 else 1.0
        if seen[U_LOW] < seen[U_HIGH]:
            s.span[k, 0] = min(s.span[k, 0], seen[U_LOW])
            s.span[k, 1] = max(s.span[k, 1], seen[U_HIGH])
            _note_edge(camera, s, seen[U_LOW])
            _note_edge(camera, s, seen[U_HIGH])


@_compiled
def _project_flat(camera: Camera, seen: F64, x0: float, y0: float, x1: float, y1: float) -> None:
    """A plane from (x0, y0) to (x1, y1), m ahead and to the left."""
    length = math.hypot(x1 - x0, y1 - y0)
    ax, ay = (x1 - x0) / length, (y1 - y0) / length
    seen[X0], seen[Y0], seen[ALONG_X], seen[ALONG_Y] = x0, y0, ax, ay
    apart = x0 * ay - y0 * ax  # of the eye from the plane
    if (x0 < NEAR and x1 < NEAR) or abs(apart) < 1e-9:
        return
    # 1/x = (ay + ax (u - middle) / f) / apart
    middle = 0.5 * camera.columns
    seen[DEPTH_1] = ax / (apart * camera.focal)
    seen[DEPTH_0] = ay / apart - middle * seen[DEPTH_1]
    u0, u1 = _column(camera, x0, y0, x1, y1), _column(camera, x1, y1, x0, y0)
    seen[U_LOW], seen[U_HIGH] = min(u0, u1), max(u0, u1)


@_compiled
def _column(camera: Camera, x: float, y: float, other_x: float, other_y: float) -> float:
    """Column of an end, which is moved along the side to the near plane if it is behind that."""
    if x < NEAR:
        share = (NEAR - x) / (other_x - x)
        x, y = NEAR, y + share * (other_y - y)
    slope = max(min(y / x, _STEEP), -_STEEP)
    return 0.5 * camera.columns - camera.focal * slope


@_compiled
def _project_round(camera: Camera, seen: F64, x: float, y: float, radius: float) -> None:
    """A cylinder about (x, y)."""
    distance = math.hypot(x, y)
    seen[X0], seen[Y0] = x, y
    if distance <= radius:
        return
    middle, half, most = math.atan2(y, x), math.asin(radius / distance), math.atan(_STEEP)
    left, right = min(middle + half, most), max(middle - half, -most)
    if left > right:
        seen[U_LOW] = 0.5 * camera.columns - camera.focal * math.tan(left)
        seen[U_HIGH] = 0.5 * camera.columns - camera.focal * math.tan(right)


@_compiled
def _lit(normal: float) -> float:
    return 1.0 - 0.5 * SHADING * (1.0 - math.cos(normal - LAMP))


@_compiled
def _note_edge(camera: Camera, s: Sketch, u: float) -> None:
    """Put an edge among those of its column, in order."""
    if not 0.0 < u < camera.columns:
        return
    column = int(u)
    k = s.edge_count[column]
    if k == EDGES:
        return
    edges = s.edges[column]
    while k > 0 and edges[k - 1] > u:
        edges[k] = edges[k - 1]
        k -= 1
    edges[k] = u
    s.edge_count[column] += 1


@_compiled
def _paint_part(
    stage: Stage,
    camera: Camera,
    s: Sketch,
    low: float,
    high: float,
    eye_x: float,
    eye_y: float,
    heading: float,
) -> None:
    """Paint what lies between columns `low` and `high` on the line."""
    u = 0.5 * (low + high)
    half = camera.rows // 2
    s.line[:half] = stage.light * stage.floor
    s.line[half:] = stage.light * stage.sky
    slope = (0.5 * camera.columns - u) / camera.focal
    for k in range(stage.shade_factor.size):
        _paint_shade(stage, camera, s, k, slope, eye_x, eye_y, heading)
    hits = 0
    for k in range(stage.base.size):
        if s.span[k, 0] <= u < s.span[k, 1] and meet(stage, s, k, u, slope):
            i = hits
            while i > 0 and s.hit[s.order[i - 1], 0] < s.hit[k, 0]:
                s.order[i] = s.order[i - 1]
                i -= 1
            s.order[i] = k
            hits += 1
    for i in range(hits):
        _paint_solid(stage, camera, s, s.order[i], low, high, heading)


@_compiled
def meet(stage: Stage, s: Sketch, k: int, u: float, slope: float) -> bool:
    """Where the ray through column u enters and leaves solid k, m ahead."""
    near, far, face = np.inf, 0.0, -1
    if stage.radius[k] > 0.0:
        face = stage.begin[k]
        x, y, radius = s.seen[face, X0], s.seen[face, Y0], stage.radius[k]
        a, b, c = 1.0 + slope * slope, x + slope * y, x * x + y * y - radius * radius
        root = math.sqrt(max(b * b - a * c, 0.0))
        near, far = (b - root) / a, (b + root) / a
    else:
        for i in range(stage.begin[k], stage.begin[k + 1]):
            seen = s.seen[i]
            if not seen[U_LOW] <= u < seen[U_HIGH]:
                continue
            inverse = seen[DEPTH_0] + seen[DEPTH_1] * u
            depth = 1.0 / max(inverse, 1e-6)
            far = max(far, depth)
            if depth < near:
                near, face = depth, i
    if face < 0:
        return False
    s.hit[k, 0], s.hit[k, 1], s.hit_face[k] = max(near, NEAR), max(far, NEAR), face
    return True


@_compiled
def _paint_solid(
    stage: Stage, camera: Camera, s: Sketch, k: int, low: float, high: float, heading: float
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
        _fill(s.line, joint, middle + far * above, stage.light * stage.top[k])
    if stage.closed[k] == 1 and below > 0.0:
        joint = min(math.ceil(middle + near * below), middle + near * above)
        _fill(s.line, middle + far * below, joint, stage.light * stage.top[k])
    lit = s.seen[face, LIT]
    if stage.radius[k] > 0.0:
        slope = (0.5 * camera.columns - 0.5 * (low + high)) / camera.focal
        dx, dy = s.hit[k, 0] - s.seen[face, X0], s.hit[k, 0] * slope - s.seen[face, Y0]
        lit = _lit(math.atan2(dy, dx) + heading)
    for i in range(stage.band_begin[face], stage.band_begin[face + 1]):
        band = stage.band[i]
        value = band[2]
        if stage.texture[i] >= 0:
            ends = _along(camera, s, face, low), _along(camera, s, face, high)
            value *= _mean(stage.weave[stage.texture[i]], ends[0] / band[3], ends[1] / band[3])
        bottom, top = band[0] - camera.height, band[1] - camera.height
        _fill(s.line, middle + near * bottom, middle + near * top, stage.light * lit * value)


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
    for row in range(first + 1, last):
        line[row] = value
    if last < line.size:
        line[last] += (high - last) * (value - line[last])


@_compiled
def _paint_shade(
    stage: Stage, camera: Camera, s: Sketch, k: int, slope: float, eye_x: float, eye_y: float, heading: float
) -> None:
    """Darken the floor where the ray crosses a shade, from the nearest to the farthest depth."""
    cos, sin = math.cos(heading), math.sin(heading)
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
        inside = turn * (ex * (eye_y - stage.shade[i, 1]) - ey * (eye_x - stage.shade[i, 0]))
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
        _fill(s.line, middle - drop / near, middle - drop / far, value)
