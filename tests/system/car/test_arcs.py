"""Arcs of a car: against the bicycle's own equations, and against distances point by point."""

from __future__ import annotations

import math

import numpy as np
import pytest

from system.car.arcs import arcs_of, blocked, immediacies, moved, steering_table
from system.car.numbers import ARCS, DIRECTIONS, MIDDLE, OpenspaceNumbers, Robot

ROBOT, NUMBERS = Robot(), OpenspaceNumbers()


def test_the_table_is_odd_falling_and_in_whole_steps() -> None:
    table = np.degrees(steering_table(ROBOT))
    assert table[MIDDLE] == 0.0
    assert np.all(np.diff(table) < 0.0)
    assert table == pytest.approx(-table[::-1])
    assert table == pytest.approx(np.rint(table), abs=1e-12)


@pytest.mark.parametrize("arc", [0, 3, MIDDLE, 12])
def test_the_body_goes_as_the_rear_axle_drives_it(arc: int) -> None:
    arcs = arcs_of(ROBOT, NUMBERS)
    lever, delta, steps = 0.5 * ROBOT.wheelbase, arcs.steering[arc], 20_000
    rear_x, rear_y, heading = -lever, 0.0, 0.0
    way = 0.3  # m, of the body's middle
    ratio = math.hypot(1.0, math.tan(delta) / ROBOT.wheelbase * lever)  # of both speeds
    ds = way / ratio / steps
    for _ in range(steps):
        middle = heading + 0.5 * ds * math.tan(delta) / ROBOT.wheelbase
        rear_x += ds * math.cos(middle)
        rear_y += ds * math.sin(middle)
        heading += ds * math.tan(delta) / ROBOT.wheelbase
    expected = rear_x + lever * math.cos(heading), rear_y + lever * math.sin(heading), heading
    found = moved((0.0, 0.0, 0.0), float(arcs.curvature[arc]), float(arcs.slip[arc]), way)
    assert found == pytest.approx(expected, abs=1e-8)  # the midpoint rule's error at 15 um


def test_backwards_undoes_forwards() -> None:
    arcs = arcs_of(ROBOT, NUMBERS)
    k, slip = float(arcs.curvature[1]), float(arcs.slip[1])
    there = moved((1.0, -2.0, 0.4), k, slip, 0.37)
    assert moved(there, k, slip, -0.37) == pytest.approx((1.0, -2.0, 0.4), abs=1e-12)


def test_every_direction_has_arcs_and_its_mirror_as_many() -> None:
    group = arcs_of(ROBOT, NUMBERS).group
    count = np.bincount(group, minlength=DIRECTIONS)
    assert count.min() > 0
    assert np.array_equal(group, DIRECTIONS - 1 - group[::-1])
    assert np.all(np.diff(group) >= 0)


def test_what_is_blocked_is_near_the_arc() -> None:
    arcs, random = arcs_of(ROBOT, NUMBERS), np.random.default_rng(3)
    place = random.uniform((-0.3, -0.7), (0.9, 0.7), (60, 2))
    found = blocked(arcs.curvature, arcs.slip, arcs.length, place, ROBOT.zone)
    for p in range(ARCS):
        s = np.linspace(0.0, arcs.length[p], 1001)
        way = [moved((0.0, 0.0, 0.0), float(arcs.curvature[p]), float(arcs.slip[p]), float(v)) for v in s]
        apart = np.hypot(*(place[:, None, :] - np.array(way)[None, :, :2]).transpose(2, 0, 1))
        sure = (
            np.abs(apart.min(axis=1) - ROBOT.zone) > 1e-4
        )  # above half a step of the points squared over the zone
        assert np.array_equal(~np.isnan(found[p])[sure], (apart.min(axis=1) < ROBOT.zone)[sure])
        hit = ~np.isnan(found[p]) & sure
        assert found[p, hit] == pytest.approx(s[apart.argmin(axis=1)][hit], abs=7e-4)  # a step of the points


def test_immediacy_is_largest_at_the_zones_edge_and_none_at_the_end() -> None:
    arcs = arcs_of(ROBOT, NUMBERS)
    length = float(arcs.length[MIDDLE])

    def risk(ahead: float) -> float:
        return float(immediacies(arcs, np.array([[ahead, 0.0]]), ROBOT.zone, 10.0)[MIDDLE])

    assert risk(ROBOT.zone) == pytest.approx(10.0)
    assert risk(ROBOT.zone + 0.25 * length) == pytest.approx(7.5)
    assert risk(length + 2.0 * ROBOT.zone) == 0.0


def test_immediacies_add() -> None:
    arcs = arcs_of(ROBOT, NUMBERS)
    one, two = np.array([[0.3, 0.0]]), np.array([[0.4, 0.1]])
    both = immediacies(arcs, np.concatenate([one, two]), ROBOT.zone, 10.0)
    alone = [immediacies(arcs, each, ROBOT.zone, 10.0) for each in (one, two)]
    assert both == pytest.approx(alone[0] + alone[1])
    assert np.array_equal(immediacies(arcs, np.empty((0, 2)), ROBOT.zone, 10.0), np.zeros(ARCS))
