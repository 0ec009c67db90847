"""The obstacle line: where it is, and how a path passes it."""

import numpy as np
import pytest

from system.pushbot.course import course_of, passage
from system.worlds.arena.file import load_scene
from system.worlds.arena.geometry import obstacles_of


@pytest.mark.parametrize(("name", "distance"), [("single-block", 1.0), ("pair", 1.0), ("moving", 1.1)])
def test_the_line_is_as_far_ahead_as_its_obstacles(name: str, distance: float) -> None:
    course = course_of(load_scene(name))
    assert course is not None
    assert course.distance == pytest.approx(distance)


@pytest.mark.parametrize("name", ["clutter", "target", "chase", "office", "obstacle-against-target"])
def test_other_scenes_have_none(name: str) -> None:
    assert course_of(load_scene(name)) is None


def test_a_straight_path_beside_the_block() -> None:
    scene = load_scene("single-block")
    course = course_of(scene)
    assert course is not None
    x = np.linspace(0.4, 1.6, 121)
    path = np.stack([x, x, np.full(x.size, 1.2), np.zeros(x.size)], axis=1)
    found = passage(course, obstacles_of(scene), path)
    # 20 cm aside, half of the robot and half of the block off
    assert found.crossed
    assert found.side == 1
    assert not found.between
    assert found.distance == pytest.approx(0.2 - 0.05 - 0.0125, abs=1e-9)
    assert found.closest == pytest.approx(found.distance, abs=1e-9)


def test_a_path_between_the_pair_and_one_that_turns_back() -> None:
    scene = load_scene("pair")
    course = course_of(scene)
    assert course is not None
    obstacles = obstacles_of(scene)
    x = np.linspace(0.4, 1.6, 61)
    straight = np.stack([x, x, np.ones(x.size), np.zeros(x.size)], axis=1)
    assert passage(course, obstacles, straight).between
    short = passage(course, obstacles, straight[:20])
    assert not short.crossed
    assert (short.distance, short.side) == (None, None)
    assert short.closest > 0.5
