"""Bodies on their paths, and robots on arcs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from system.worlds.arena.motion import STRIDES, go_along_arc, motions_of, place_bodies
from system.worlds.arena.scene import Body, Motion, Repeat

PATH = ((0.0, 0.0), (3.0, 0.0), (3.0, 4.0))


def pose_at(time: float, repeat: Repeat = "stop", *, swing: float = 0.0) -> list[float]:
    body = Body("a", (9.0, 9.0), (0.1, 0.1), 0.1, 0.5, motion=Motion(PATH, 0.5, 2.0, repeat), swing=swing)
    rest = Body("b", (1.0, 2.0), (0.1, 0.1), 0.1, 0.5, heading=0.3)
    pose = np.zeros((2, 3))
    place_bodies(motions_of((body, rest)), time, pose)
    assert pose[1].tolist() == [1.0, 2.0, 0.3]
    found: list[float] = pose[0].tolist()
    return found


@pytest.mark.parametrize(
    ("time", "repeat", "pose"),
    [
        (0.0, "stop", (0.0, 0.0, 0.0)),
        (2.0, "stop", (0.0, 0.0, 0.0)),
        (4.0, "stop", (1.0, 0.0, 0.0)),
        (10.0, "stop", (3.0, 1.0, math.pi / 2)),
        (99.0, "stop", (3.0, 4.0, math.pi / 2)),
        (18.0, "shuttle", (3.0, 3.0, 1.5 * math.pi)),  # 8 m gone, of 7 and then back
        (30.0, "shuttle", (0.0, 0.0, 0.0)),
        (18.0, "loop", (2.4, 3.2, math.atan2(-4.0, -3.0))),  # a metre on the way back to the first point
        (26.0, "loop", (0.0, 0.0, 0.0)),
    ],
)
def test_paths(time: float, repeat: Repeat, pose: tuple[float, float, float]) -> None:
    assert pose_at(time, repeat) == pytest.approx(pose, abs=1e-12)


def test_legs_swing_along_the_way() -> None:
    time = 2.0 + 1.0 / STRIDES
    x, y, _ = pose_at(time, swing=0.1)
    phase = 2.0 * math.pi * STRIDES * time
    assert (x, y) == pytest.approx((0.5 / STRIDES + 0.1 * math.sin(phase), 0.0))


def test_an_arc_in_parts_is_the_arc() -> None:
    whole, part = np.array([1.0, 2.0, 0.4]), np.array([1.0, 2.0, 0.4])
    go_along_arc(whole, 0.35, 1.3, 0.5)
    for _ in range(10):
        go_along_arc(part, 0.35, 1.3, 0.05)
    assert part == pytest.approx(whole)
    assert whole[2] == pytest.approx(0.4 + 0.65)


def test_a_full_circle_returns() -> None:
    pose = np.array([1.0, 2.0, 0.0])
    go_along_arc(pose, 0.35, 2.0 * math.pi, 0.5)
    assert pose[:2] == pytest.approx([1.0, 2.0 + 2.0 * 0.35 / (2.0 * math.pi)])  # half a circle to the left
