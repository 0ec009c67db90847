"""What a brain of the Bug robot is, and the two behaviours that all of them share (Stöckel 2017, III.B).

Towards the goal, v is the compass. Along a wall, each range ray draws the robot by a vector turned by 45
degrees from the ray, the more the nearer its wall:

    v = GAIN sum_i (1 - (d_i - r) / (R - r))^2 e(rays_i - 45 degrees)

with range R and radius r. The paper's rule has no factor GAIN; ours is one half, for a wall at the side then
makes |v| just above 1, the speed towards the goal. Turned clockwise, as here, it keeps the wall on the left,
which is the paper's counterclockwise way around an obstacle; the sense of the paper's rotation is not in its
text.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from circuits.arrays import F64
from system.bug.body import RADIUS, RANGE, RAYS, Senses

GAIN = 0.5
_ROTATION = -np.pi / 4.0
PULLS = GAIN * np.stack([np.cos(RAYS + _ROTATION), np.sin(RAYS + _ROTATION)], axis=1)  # float64[8, 2]

CONTACT_FILTER = 0.1  # s, low-pass of the contact sensor; ours
TEST_RATE = 1.0  # Hz, of the oscillator that makes the robot try the way to the goal; the paper's
TEST_SHARE = 0.2  # of a period in which it tries; ours

AGENTS = ("bug0", "bug1", "bug2")
MEMORISE, GO, STORE, FOLLOW = "memorise", "go", "store", "follow"  # the four states of Bug 2, in order
STATES = (MEMORISE, GO, STORE, FOLLOW)
UNREACHABLE = "unreachable"


class Brain(Protocol):
    """Turns what is sensed every 10 ms into a steering vector.

    state: what it is doing, one of `STATES`; verdict: `UNREACHABLE` once it knows, else empty.
    """

    @property
    def state(self) -> str:
        """What the brain is doing, one of `STATES`."""

    @property
    def verdict(self) -> str:
        """What the brain has found out about the goal, empty for nothing."""

    def step(self, senses: Senses) -> F64:
        """Steering vector for the next 10 ms, float64[2]."""


def nearness(ranges: F64) -> F64:
    """1 where a wall touches the body, 0 where there is none in range."""
    return np.asarray(1.0 - (ranges - RADIUS) / (RANGE - RADIUS))


def along_wall(ranges: F64) -> F64:
    """Steering vector along the wall, float64[2]."""
    return np.asarray(nearness(ranges) ** 2 @ PULLS)
