"""Robot of the Bug paper: steering, senses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from system.bug.body import FASTEST, RADIUS, RANGE, RAYS, STEP, TURN, Robot
from system.bug.map import read_map
from system.bug.world import build_world

YARD = read_map("S         \n          \n          \n         G\n", "yard")
START, GOAL = (3.5, 1.5), (7.5, 1.5)


@pytest.fixture
def robot() -> Robot:
    return Robot(build_world(YARD), START, GOAL)


def test_it_turns_in_proportion_to_the_angle_of_v(robot: Robot) -> None:
    robot.step(0.5 * np.array([math.cos(0.7), math.sin(0.7)]))
    assert robot.heading == pytest.approx(TURN * 0.7 * STEP)
    assert np.hypot(*(robot.place - START)) == pytest.approx(0.5 * STEP)


def test_it_is_no_faster_than_its_limit(robot: Robot) -> None:
    robot.step(np.array([7.0, 0.0]))
    assert robot.place[0] - START[0] == pytest.approx(FASTEST * STEP)


def test_no_vector_no_motion(robot: Robot) -> None:
    robot.step(np.zeros(2))
    assert (robot.place.tolist(), robot.heading) == ([3.5, 1.5], 0.0)


def test_compasses_and_distance(robot: Robot) -> None:
    robot.heading = math.pi / 2.0
    found = robot.sense()
    assert found.north == pytest.approx([1.0, 0.0])
    assert found.ahead == pytest.approx([0.0, -1.0])  # it looks north, the goal is to the right
    assert found.distance == pytest.approx(4.0 / math.hypot(10.0, 4.0))


def test_ranges_end_at_the_range(robot: Robot) -> None:
    assert (robot.sense().ranges == RANGE).all()


def test_contact_and_ranges_at_a_wall() -> None:
    robot = Robot(build_world(YARD), (3.5, 0.5), (3.5, 3.5))
    robot.heading = -math.pi / 2.0
    for _ in range(60):
        robot.step(np.array([1.0, 0.0]))
    assert robot.contact
    assert robot.place[1] == pytest.approx(RADIUS)
    nearest = np.argmin(np.abs(RAYS))
    assert robot.sense().ranges[nearest] == pytest.approx(RADIUS / math.cos(RAYS[nearest]))


def test_rays_are_not_symmetric() -> None:
    turned = np.sort((-RAYS) % (2.0 * np.pi))
    assert np.abs(turned - np.sort(RAYS % (2.0 * np.pi))).max() > np.deg2rad(2.0)
