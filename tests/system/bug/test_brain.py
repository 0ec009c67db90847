"""What brains share: the way along a wall."""

from __future__ import annotations

import numpy as np
import pytest

from system.bug.body import RADIUS, RANGE, RAYS
from system.bug.brain import GAIN, along_wall, nearness


def test_nearness_is_one_at_the_body_and_nothing_out_of_range() -> None:
    assert nearness(np.array([RADIUS, RANGE])).tolist() == [1.0, 0.0]


@pytest.mark.parametrize("ray", range(8))
def test_one_ray_draws_by_its_direction_turned_by_45_degrees(ray: int) -> None:
    ranges = np.full(8, RANGE)
    ranges[ray] = 0.5 * (RADIUS + RANGE)  # halfway: a quarter of the weight
    x, y = along_wall(ranges)
    assert np.hypot(x, y) == pytest.approx(0.25 * GAIN)
    turned = (RAYS[ray] - np.arctan2(y, x)) % (2.0 * np.pi)
    assert turned == pytest.approx(np.pi / 4.0)


def test_no_wall_no_motion() -> None:
    assert along_wall(np.full(8, RANGE)).tolist() == [0.0, 0.0]
