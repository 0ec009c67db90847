"""Ranges and sliding: exact geometry beside shapely's, and the paper's misprint."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from circuits.arrays import F64
from system.bug.kernel import look, slide
from system.bug.map import load_map
from system.bug.world import World, build_world

WALL = np.array([[-10.0, 0.0, 0.0, 0.0], [0.0, 0.0, 10.0, 0.0]])  # along x, in two pieces
RADIUS = 0.15


def stopping_distance(direction: F64, wall: F64) -> float:
    """Distance to a wall, along the motion, at which a disc touches it: r / sin of the angle between both."""
    return RADIUS / math.sqrt(1.0 - cosine(direction, wall) ** 2)


def printed_stopping_distance(direction: F64, wall: F64) -> float:
    """The same as the paper prints it, with |cos| in the place of cos^2."""
    return RADIUS / math.sqrt(1.0 - abs(cosine(direction, wall)))


def cosine(a: F64, b: F64) -> float:
    """Of the angle between two vectors."""
    return float(np.dot(a, b) / (np.hypot(*a) * np.hypot(*b)))


def moved(pieces: F64, x: float, y: float, dx: float, dy: float) -> tuple[float, float, bool]:
    place = np.array([x, y])
    touched = slide(pieces, place, dx, dy, RADIUS, np.empty(3))
    return float(place[0]), float(place[1]), touched


@pytest.fixture(scope="module")
def world() -> World:
    return build_world(load_map("bug-field"))


def test_ranges_are_those_of_shapely(world: World) -> None:
    random, rays, ranges = np.random.default_rng(1), np.linspace(-3.0, 3.0, 8), np.empty(8)
    for _ in range(40):
        x, y = random.uniform((0.0, 0.0), (world.map.width, world.map.height))
        if world.clearance((x, y)) == 0.0:
            continue
        heading = random.uniform(-4.0, 4.0)
        look(world.near((x, y), 1.0), x, y, heading, rays, 1.0, ranges)
        for ray, found in zip(rays, ranges, strict=True):
            end = (x + math.cos(heading + ray), y + math.sin(heading + ray))
            free = shapely.LineString([(x, y), end]).difference(world.obstacles)
            parts = getattr(free, "geoms", [free])
            # rounding of shapely's overlay
            assert found == pytest.approx(
                next(p.length for p in parts if p.distance(shapely.Point(x, y)) < 1e-9)
            )


@pytest.mark.parametrize("degrees", [10.0, 45.0, 80.0, 90.0])
def test_a_disc_stops_at_the_corrected_distance(degrees: float) -> None:
    angle = math.radians(degrees)
    d = np.array([math.cos(angle), -math.sin(angle)])
    far = stopping_distance(d, np.array([3.0, 0.0]))
    assert far == pytest.approx(RADIUS / math.sin(angle))
    x, y, touched = moved(WALL, 0.0, 0.45, 2.0 * d[0], 2.0 * d[1])
    assert touched
    assert y == pytest.approx(RADIUS)  # far * sin is the radius
    assert x == pytest.approx(2.0 * d[0])  # what is left of the way goes on along the wall


def test_the_printed_distance_is_too_long() -> None:
    wall, steep = np.array([1.0, 0.0]), np.array([0.0, -1.0])
    assert printed_stopping_distance(steep, wall) == pytest.approx(RADIUS)
    for degrees in (5.0, 45.0, 85.0):
        d = np.array([math.cos(math.radians(degrees)), -math.sin(math.radians(degrees))])
        ratio = printed_stopping_distance(d, wall) / stopping_distance(d, wall)
        assert ratio == pytest.approx(math.sqrt(1.0 + abs(float(d[0]))))


def test_a_disc_slides_off_a_corner() -> None:
    wall = np.array([[-1.0, 0.0, 0.0, 0.0]])
    x, y, touched = moved(wall, 0.1, 1.0, 0.0, -2.0)
    assert touched
    assert x > 0.1
    assert math.hypot(x, max(y, 0.0)) >= RADIUS - 1e-12 or y < 0.0


def test_a_disc_rests_in_a_corner() -> None:
    walls = np.array([[-5.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 5.0]])
    x, y, touched = moved(walls, -1.0, 1.0, 3.0, -2.0)
    assert touched
    assert [x, y] == pytest.approx([-RADIUS, RADIUS])


def test_away_from_a_wall_is_no_contact() -> None:
    assert moved(WALL, 0.0, RADIUS, 0.1, 0.2) == (0.1, RADIUS + 0.2, False)
    assert not moved(WALL, 0.0, RADIUS, 0.1, 0.0)[2]


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_no_walk_enters_a_wall(world: World, seed: int) -> None:
    random = np.random.default_rng(seed)
    place, angle, scratch = np.array([20.5, 11.5]), random.uniform(0.0, 6.0), np.empty(3)
    for _ in range(300):
        angle += random.normal(0.0, 0.2)
        pieces = world.near((place[0], place[1]), 0.5)
        slide(pieces, place, 0.05 * math.cos(angle), 0.05 * math.sin(angle), RADIUS, scratch)
    # a contact is left within rounding of the radius, which a step may add to
    assert world.clearance((place[0], place[1])) >= RADIUS - 1e-9
