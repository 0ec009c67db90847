"""The renderer against closed forms, and against rays."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from circuits.arrays import F64, Bools
from system.worlds.arena.motion import place_bodies
from system.worlds.arena.scene import Body, Scene, Shade, Tape, Wall
from system.worlds.camera.project import sketch_of
from system.worlds.camera.render import render
from system.worlds.camera.sensor import Dvs, camera_of
from system.worlds.camera.stage import darkest, stage_of

FLOOR = ((-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0))
EMPTY = Scene("empty", "", 1.0, FLOOR, (0.0, 0.0, 0.0), (), (), floor=0.8, sky=0.8)
DVS = Dvs(ahead=0.0)
FOCAL = 64.0 / math.tan(math.radians(30.0))


def seen(scene: Scene, pose: tuple[float, float, float] = (0.0, 0.0, 0.0), dvs: Dvs = DVS) -> F64:
    """Intensity, float64[rows, columns]."""
    stage, camera = stage_of(scene), camera_of(dvs)
    sketch = sketch_of(stage, camera)
    place_bodies(stage.motions, 0.0, sketch.pose)
    render(stage, camera, sketch, *pose)
    return sketch.light.reshape(dvs.columns, dvs.rows).T


def coverage(image: F64, background: float, value: float) -> F64:
    return (background - image) / (background - value)


def block(distance: float, width: float, height: float, *, left: float = 0.0, base: float = 0.0) -> Body:
    return Body("block", (distance + 0.05, left), (0.1, width), height, 0.2, base=base)


def test_nothing_is_seen_where_nothing_stands() -> None:
    assert np.all(seen(EMPTY) == 0.8)


@pytest.mark.parametrize(
    ("distance", "width", "height", "left"),
    [(1.0, 0.025, 0.10, 0.0), (0.5, 0.025, 0.10, 0.0), (0.4, 0.06, 0.5, 0.0), (2.0, 0.3, 0.08, 0.0)],
)
def test_a_block_covers_its_rows_and_columns(
    distance: float, width: float, height: float, left: float
) -> None:
    image = seen(replace(EMPTY, bodies=(block(distance, width, height, left=left),)))
    share = coverage(image, 0.8, float(image.min()))
    scale = FOCAL / distance
    # the front is a rectangle: exact coverage up to rounding
    left_edge, right_edge = 64.0 - 0.5 * width * scale, 64.0 + 0.5 * width * scale
    bottom, top = 64.0 - 0.075 * scale, min(64.0 + (height - 0.075) * scale, 128.0)
    edges = np.arange(129.0)
    columns = np.clip(np.minimum(edges[1:], right_edge) - np.maximum(edges[:-1], left_edge), 0.0, 1.0)
    rows = np.clip(np.minimum(edges[1:], top) - np.maximum(edges[:-1], max(bottom, 0.0)), 0.0, 1.0)
    assert share == pytest.approx(np.outer(rows, columns), abs=1e-9)


def test_a_cylinder_covers_its_tangents() -> None:
    cup = Body("cup", (0.6, 0.2), (0.1, 0.1), 0.15, 0.2, is_round=True)
    image = seen(replace(EMPTY, bodies=(cup,)))
    distance, middle = math.hypot(0.6, 0.2), math.atan2(0.2, 0.6)
    half = math.asin(0.05 / distance)
    left, right = (64.0 - FOCAL * math.tan(middle + s * half) for s in (1.0, -1.0))
    row = image[63]
    dark = row < 0.8 - 1e-12
    assert np.flatnonzero(dark)[[0, -1]].tolist() == [int(left), int(right)]


def test_an_edge_moves_without_jumps() -> None:
    # by 0.02 pixel a picture: no pixel may change by more than that share of the contrast
    scene = replace(EMPTY, bodies=(block(0.8, 0.03, 0.10),))
    images = [seen(scene, (0.0, k * 0.02 * 0.8 / FOCAL, 0.0)) for k in range(60)]
    changes = np.abs(np.diff(np.array(images), axis=0)).max()
    assert changes <= 0.02 * (0.8 - images[0].min()) * (1.0 + 1e-6)


def test_an_edge_a_hair_beside_a_column_leaves_nothing_of_the_last_picture() -> None:
    # its left part is narrower than what is painted
    scene = replace(EMPTY, bodies=(block(1.0, 2.0 * (4.0 - 2e-10) / FOCAL, 0.10),))
    stage, camera = stage_of(scene), camera_of(DVS)
    sketch = sketch_of(stage, camera)
    place_bodies(stage.motions, 0.0, sketch.pose)
    pictures = []
    for _ in range(2):
        render(stage, camera, sketch, 0.0, 0.0, 0.0)
        pictures.append(sketch.light.copy())
    assert 60.0 < sketch.edges[60, 0] < 60.0 + 1e-9
    assert np.array_equal(*pictures)


def test_a_low_block_shows_its_top() -> None:
    low = Body("block", (0.5, 0.0), (0.2, 0.3), 0.05, 0.2, top=0.5)
    column = seen(replace(EMPTY, bodies=(low,)))[:, 64]
    near, far = FOCAL / 0.4, FOCAL / 0.6
    rows = [64.0 - near * 0.075, 64.0 - near * 0.025, 64.0 - far * 0.025]  # bottom, front edge, back edge
    assert column[math.ceil(rows[0]) : math.floor(rows[1])] == pytest.approx(column[int(rows[0]) + 2])
    assert column[math.ceil(rows[1]) : math.floor(rows[2])] == pytest.approx(0.5)
    assert np.all(column[math.ceil(rows[2]) :] == 0.8)
    assert np.all(column[: math.floor(rows[0])] == 0.8)


def test_what_is_nearer_hides_what_is_farther() -> None:
    far, near = block(1.0, 0.5, 0.3), replace(block(0.5, 0.1, 0.10), reflectance=0.5)
    image = seen(replace(EMPTY, bodies=(near, far)))
    top = 64.0 + (0.10 - 0.075) * FOCAL / 0.5
    # facing the lamp's back the front of both is shaded alike
    assert image[int(top) - 1, 64] / image[int(top) + 2, 64] == pytest.approx(0.5 / 0.2)


def test_a_textured_wall_keeps_its_mean() -> None:
    tape = Tape(low=0.0, high=0.15, cell=0.003, dark=0.2, pale=0.6, seed=3)
    wall = Wall((1.0, 1.0), (1.0, -1.0), 0.15, 0.8, tape)
    image = seen(replace(EMPTY, walls=(wall,)))
    shades = np.random.default_rng((3, 2)).uniform(0.2, 0.6, 256)
    # 1.15 m of 3 mm cells are seen, the 256 cells one and a half times over: two means of 192 cells, 5 sigma
    assert image[64].mean() == pytest.approx(shades.mean(), abs=5.0 * 0.4 / math.sqrt(12.0 * 192))
    assert image[64].std() > 0.0


def test_shade_lies_where_it_should() -> None:
    shade = Shade(((0.5, -2.0), (1.0, -2.0), (1.0, 2.0), (0.5, 2.0)), 0.25)
    column = seen(replace(EMPTY, shades=(shade,)))[:, 64]
    near, far = 64.0 - FOCAL * 0.075 / 0.5, 64.0 - FOCAL * 0.075 / 1.0
    share = coverage(column, 0.8, 0.2)
    edges = np.arange(129.0)
    assert share == pytest.approx(
        np.clip(np.minimum(edges[1:], far) - np.maximum(edges[:-1], near), 0.0, 1.0)
    )


def test_light_scales_the_picture() -> None:
    scene = replace(EMPTY, bodies=(block(1.0, 0.1, 0.1),))
    assert seen(replace(scene, light=20.0)) == pytest.approx(20.0 * seen(scene))


def test_nothing_is_darker_than_the_darkest() -> None:
    tape = Tape(0.0, 0.1, 0.02, 0.3, 0.8, 1)
    scene = replace(
        EMPTY, bodies=(block(0.7, 0.1, 0.1),), walls=(Wall((1.0, 1.0), (1.0, -1.0), 0.15, 0.8, tape),)
    )
    assert darkest(stage_of(scene)) <= seen(scene).min()


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (0.3, -0.4, 0.5), (-0.2, 0.6, -0.7), (0.35, 0.0, 0.1)])
def test_pictures_agree_with_rays(pose: tuple[float, float, float]) -> None:
    bodies = (
        replace(block(0.8, 0.2, 0.2), heading=0.4),
        replace(block(1.2, 0.3, 0.05, left=0.3), reflectance=0.5),
        replace(block(1.0, 0.4, 0.6, left=-0.4, base=0.3), reflectance=0.4),
    )
    scene = replace(EMPTY, bodies=bodies, walls=(Wall((2.0, 2.0), (2.0, -2.0), 0.4, 0.6),))
    dvs = Dvs(columns=32, rows=32, ahead=0.0)
    off = np.abs(seen(scene, pose, dvs) - by_rays(scene, pose, dvs, 24))
    # Where ends of two solids share a pixel they are composited as if independent, which may be off by up to
    # a quarter of the contrast; with more rays the worst of these pixels stays at 0.047. Rays find an edge to
    # 1/48 of a pixel, a corner to 1/24.
    assert off.max() < 0.06
    assert np.mean(off > 0.62 / 24.0) < 0.01
    assert off.mean() < 0.001


def by_rays(scene: Scene, pose: tuple[float, float, float], dvs: Dvs, fine: int) -> F64:
    """Mean of fine x fine rays a pixel, each against all sides, tops and undersides."""
    n = dvs.columns * fine
    camera = camera_of(dvs)
    slope = (0.5 * n - np.arange(n) - 0.5) / (camera.focal * fine)
    across, up = np.meshgrid(slope, -slope)  # row 0 at the bottom
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    dx, dy = cos - across * sin, sin + across * cos
    nearest = np.full((n, n), np.inf)
    image = np.full((n, n), scene.sky)
    stage = stage_of(scene)
    for face, k in enumerate(stage.owner):
        x, y, heading = stage.motions.rest[k]
        c, s = math.cos(heading), math.sin(heading)
        ends = stage.side[face].reshape(2, 2) @ np.array([[c, s], [-s, c]]) + (x, y)
        (x0, y0), (ex, ey) = ends[0] - pose[:2], ends[1] - ends[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (x0 * ey - y0 * ex) / (dx * ey - dy * ex)
            share = np.where(abs(ex) > abs(ey), (t * dx - x0) / ex, (t * dy - y0) / ey)
        z = dvs.height + t * up
        hit = (t > 0.0) & (share >= 0.0) & (share <= 1.0) & (z >= stage.base[k]) & (z <= stage.height[k])
        lit = 1.0
        if stage.closed[k]:
            lit = 1.0 - 0.04 * (1.0 - math.cos(math.atan2(-ex, ey) - math.radians(60.0)))
        keep(nearest, image, hit, t, lit * stage.band[stage.band_begin[face], 2])
    for k, body in enumerate(scene.bodies):
        for level in (body.base, body.height):
            with np.errstate(divide="ignore"):
                t = (level - dvs.height) / up
            px, py = t * dx + pose[0] - body.at[0], t * dy + pose[1] - body.at[1]
            c, s = math.cos(body.heading), math.sin(body.heading)
            inside = (abs(c * px + s * py) <= 0.5 * body.size[0]) & (
                abs(c * py - s * px) <= 0.5 * body.size[1]
            )
            keep(nearest, image, inside & (t > 0.0), t, stage.top[k])
    mean: F64 = image.reshape(dvs.rows, fine, dvs.columns, fine).mean(axis=(1, 3))
    return mean


def keep(nearest: F64, image: F64, hit: Bools, t: F64, value: float) -> None:
    first = hit & (t < nearest)
    nearest[first] = t[first]
    image[first] = value
