"""Shortest paths, and distances between paths."""

from __future__ import annotations

import math

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.bug import path as bug_path
from system.bug.map import load_map, read_map
from system.bug.path import median_distance, path_length, shortest_path
from system.bug.world import build_world

BLOCK = build_world(read_map("S    G\n      \n  ##  \n  ##  \n      \n", "block"))


def test_around_a_block() -> None:
    found = shortest_path(BLOCK, (1.0, 2.0), (5.0, 2.0))
    assert found is not None
    assert len(found) == 4
    assert path_length(found) == pytest.approx(2.0 * math.sqrt(2.0) + 2.0)


def test_along_a_side() -> None:
    found = shortest_path(BLOCK, (0.5, 3.0), (5.5, 3.0))
    assert found is not None
    assert path_length(found) == pytest.approx(5.0)


def test_no_way() -> None:
    world = build_world(load_map("bug-sealed"))
    assert shortest_path(world, world.map.starts[0], world.map.goals[0]) is None


def test_no_way_between_walls_that_touch() -> None:
    world = build_world(read_map("S#\n#G\n", "corner"))
    assert shortest_path(world, (0.5, 1.5), (1.5, 0.5)) is None


def test_too_many_corners_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bug_path, "MOST_CORNERS", 3)
    with pytest.raises(ParameterError, match="block: 4 corners, must be at most 3"):
        shortest_path(BLOCK, (1.0, 2.0), (5.0, 2.0))


def test_median_distance() -> None:
    line = np.stack([np.linspace(0.0, 1.0, 101), np.zeros(101)], axis=1)
    assert median_distance(line, line) == 0.0
    assert median_distance(line + np.array([0.0, 0.3]), line) == pytest.approx(0.3)
