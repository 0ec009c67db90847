"""Outlines: what a robot touches, and how far it is from it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from system.worlds.arena.file import load_scene
from system.worlds.arena.geometry import clearance, collision, obstacles_of, robot_outline
from system.worlds.arena.scene import Body, Scene

BLOCK = Body("block", (1.0, 0.5), (0.1, 0.2), 0.1, 0.5)
CUP = Body("cup", (1.5, 0.5), (0.2, 0.2), 0.1, 0.5, is_round=True)
SCENE = Scene("bare", "", 500.0, ((0, 0), (2, 0), (2, 1), (0, 1)), (0.5, 0.5, 0.0), (BLOCK, CUP), ())


@pytest.mark.parametrize(
    ("pose", "touched"),
    [
        ((0.5, 0.5, 0.0), None),
        ((0.899, 0.5, 0.0), None),  # chassis ends at 0.949, the block begins at 0.95
        ((0.901, 0.5, 0.0), "block"),
        ((1.0, 0.66, 0.0), None),  # 5 + 10 cm, and 1 cm to spare
        ((1.0, 0.66, math.radians(45.0)), "block"),  # a corner reaches 7.07 cm
        ((0.051, 0.5, 0.0), None),
        ((0.049, 0.5, 0.0), "wall"),
        ((0.06, 0.5, math.radians(45.0)), "wall"),
        ((1.651, 0.5, 0.0), None),
        ((1.649, 0.5, 0.0), "cup"),
        ((3.0, 0.5, 0.0), "wall"),
    ],
)
def test_collisions(pose: tuple[float, float, float], touched: str | None) -> None:
    assert collision(obstacles_of(SCENE), pose, 0.0) == touched


def test_what_hangs_above_the_robot_is_not_touched() -> None:
    scene = replace(SCENE, bodies=(replace(BLOCK, base=0.2, height=0.3),))
    assert collision(obstacles_of(scene), (1.0, 0.5, 0.0), 0.0) is None


def test_clearance_is_between_outlines() -> None:
    obstacles = obstacles_of(SCENE)
    assert clearance(obstacles, (0.8, 0.5, 0.0), 0.0) == pytest.approx(0.1)
    assert clearance(obstacles, (0.8, 0.5, 0.0), 0.0, "cup") == pytest.approx(0.55)
    assert clearance(obstacles, (0.8, 0.5, 0.0), 0.0, "chair") == math.inf


def test_a_moving_cup_is_met_where_it_is() -> None:
    # 0.3 s after which it goes from y = 0.45 to 1.0 at 0.2 m/s: 2.75 s
    obstacles = obstacles_of(load_scene("moving"))
    met = [collision(obstacles, (1.5, 1.0, 0.0), t) for t in (0.0, 2.5, 3.05)]
    # touched once the rim, 4 cm about the middle, is within 5 cm: from y = 0.91 on, after 2.6 s
    assert met == [None, None, "cup[0]"]


def test_the_chassis_is_ten_centimetres() -> None:
    outline = robot_outline((1.0, 2.0, 0.3))
    assert outline.area == pytest.approx(0.01)
    assert (outline.centroid.x, outline.centroid.y) == pytest.approx((1.0, 2.0))


@pytest.mark.parametrize("name", ["clutter", "office", "moving", "chase"])
def test_what_was_free_before_hides_no_collision(name: str) -> None:
    scene = load_scene(name, seed=7)
    skips, looks = obstacles_of(scene), obstacles_of(scene)
    x, y, heading = scene.start
    random, names, looked = np.random.default_rng(1), set[str | None](), 0
    for k in range(3000):
        # a random walk in steps of a centimetre and 5 ms, which is put back to its start now and then
        heading += random.normal(0.0, 0.05)
        x, y = x + 0.01 * np.cos(heading), y + 0.01 * np.sin(heading)
        if k % 600 == 0:
            x, y, heading = scene.start
        before = list(skips.free)
        found = collision(skips, (x, y, heading), 5e-3 * k)
        looked += skips.free != before or found is not None
        looks.free[3] = -np.inf
        assert found == collision(looks, (x, y, heading), 5e-3 * k)
        names.add(found)
    assert len(names) > 1
    assert looked < 2500
