"""Where the faces of a stage lie in a picture, and which columns their edges divide, compiled.

A pinhole camera that looks straight ahead from `height` above the floor has, for a point ahead by x, to the
left by y and z above the floor (m),

    u = columns / 2 - f y / x,    v = rows / 2 + f (z - height) / x,    f = columns / (2 tan(field / 2))

u counts columns from the left, v rows from the bottom, both in pixels. Over a plane 1/x is linear in u.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled
from system.worlds.camera.stage import LAMP, SHADING, Stage

NEAR = 0.01  # m; nothing nearer is seen
EDGES = 24  # in one column; those beyond are left out
_STEEP = 20.0  # tangent beyond which an edge counts as outside the picture
(
    U_LOW, U_HIGH, DEPTH_0, DEPTH_1, X0, Y0, ALONG_X, ALONG_Y, LIT,
) = range(9)  # fmt: skip
_compiled = compiled()


class Camera(NamedTuple):
    """The optics of a sensor.

    columns, rows : of pixels; focal : length in pixels; height : above the floor, m; ahead : before the
    robot's middle, m.

    blur: pixels, sigma of a point of light.
    """

    columns: int
    rows: int
    focal: float
    height: float
    ahead: float
    blur: float


class Sketch(NamedTuple):
    """Arrays in which one picture is made.

    pose: float64[solids, 3]; seen: float64[faces, 9], each face in the picture; span: float64[solids, 2],
    columns that each solid covers; edges: float64[columns, EDGES] with edge_count; hit: float64[solids, 2], m
    where a ray enters and leaves; hit_face, order, shown (those in the picture): [solids]; line:
    float64[rows]; light: float64[columns * rows], lux times reflectance, column after column.
    """

    pose: F64
    seen: F64
    span: F64
    edges: F64
    edge_count: I64
    hit: F64
    hit_face: I64
    order: I64
    shown: I64
    line: F64
    light: F64


def sketch_of(stage: Stage, camera: Camera) -> Sketch:
    """Return the arrays for pictures of a stage."""
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
        shown=np.zeros(solids + 1, dtype=np.int64),
        line=np.zeros(camera.rows),
        light=np.zeros(camera.columns * camera.rows),
    )


@_compiled
def project_solid(
    stage: Stage, camera: Camera, s: Sketch, k: int, eye_x: float, eye_y: float, heading: float
) -> None:
    """Put a solid's faces into the picture, and their edges into its columns."""
    cos, sin = math.cos(heading), math.sin(heading)
    bx, by = s.pose[k, 0] - eye_x, s.pose[k, 1] - eye_y
    mx, my = cos * bx + sin * by, cos * by - sin * bx
    turn = s.pose[k, 2] - heading
    c, n = math.cos(turn), math.sin(turn)
    s.span[k, 0], s.span[k, 1] = np.inf, -np.inf
    for face in range(stage.begin[k], stage.begin[k + 1]):
        seen = s.seen[face]
        seen[U_LOW], seen[U_HIGH] = np.inf, -np.inf
        if stage.radius[k] > 0.0:
            _project_round(camera, seen, mx, my, stage.radius[k])
        else:
            side = stage.side[face]
            _project_flat(
                camera, seen, mx + c * side[0] - n * side[1], my + n * side[0] + c * side[1],
                mx + c * side[2] - n * side[3], my + n * side[2] + c * side[3],
            )  # fmt: skip
            seen[LIT] = 1.0
            if stage.closed[k] == 1 and seen[U_LOW] < camera.columns and seen[U_HIGH] > 0.0:
                # outward normal of a side that runs counter-clockwise: to its right
                seen[LIT] = lit(math.atan2(-seen[ALONG_X], seen[ALONG_Y]) + heading)
        if seen[U_LOW] < seen[U_HIGH]:
            s.span[k, 0] = min(s.span[k, 0], seen[U_LOW])
            s.span[k, 1] = max(s.span[k, 1], seen[U_HIGH])
            _note_edge(camera, s, seen[U_LOW])
            _note_edge(camera, s, seen[U_HIGH])


@_compiled
def _project_flat(camera: Camera, seen: F64, x0: float, y0: float, x1: float, y1: float) -> None:
    """A plane from (x0, y0) to (x1, y1), m ahead and to the left."""
    if x0 < NEAR and x1 < NEAR:
        return
    length = math.hypot(x1 - x0, y1 - y0)
    ax, ay = (x1 - x0) / length, (y1 - y0) / length
    seen[X0], seen[Y0], seen[ALONG_X], seen[ALONG_Y] = x0, y0, ax, ay
    apart = x0 * ay - y0 * ax  # of the eye from the plane
    if abs(apart) < 1e-9:
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
def lit(normal: float) -> float:
    """Share of the light on a side whose outward normal points to `normal` rad."""
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
