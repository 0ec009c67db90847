"""The loop: straight on where nothing is, collisions where they are, the neck's time, and backing up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from system.car.arcs import arcs_of
from system.car.drive import MARGIN, Drive, desirabilities, drive
from system.car.numbers import ARCS, DIRECTIONS, MIDDLE, OpenspaceNumbers, Robot
from system.car.world import Pipes

ROBOT, NUMBERS = Robot(), OpenspaceNumbers()
START = (-0.6, 0.0, 0.0)


def go(*places: tuple[float, float], numbers: OpenspaceNumbers = NUMBERS, pings: int = 800) -> Drive:
    forest = Pipes("test", np.array(places), 1.0, 2.0)
    return drive(ROBOT, numbers, arcs_of(ROBOT, numbers), None, forest, START, pings)


def test_nothing_in_the_way_is_straight_on_at_full_rate() -> None:
    found = go((0.5, 0.9))
    assert found.ended == "through"
    assert found.end[1:] == pytest.approx((0.0, 0.0), abs=1e-12)
    assert found.end[0] == pytest.approx(1.0 + MARGIN, abs=ROBOT.max_speed / ROBOT.ping_rate)
    assert np.diff(found.log[:, 0]) == pytest.approx(1.0 / ROBOT.ping_rate)
    assert np.all(found.log[:, 4] == DIRECTIONS // 2)


def test_a_pipe_ahead_is_passed() -> None:
    found = go((0.5, 0.01))
    assert found.ended in {"through", "out"}
    path = np.concatenate([found.log[:, 1:3], [found.end[:2]]])
    assert np.hypot(*(path - np.array([0.5, 0.01])).T).min() >= ROBOT.zone
    assert len(np.unique(found.log[:, 5])) > 1


def test_without_a_memory_of_risk_it_runs_into_the_pipe() -> None:
    found = go((0.5, 0.0), numbers=replace(NUMBERS, suppression=1e-9, emergency_below=-1.0))
    assert found.ended == "collided"
    assert found.end[0] == pytest.approx(0.5 - ROBOT.zone, abs=1e-9)  # the halving's last step
    assert found.distance == pytest.approx(1.1 - ROBOT.zone, abs=1e-9)


def test_a_turn_of_the_head_takes_its_time() -> None:
    found = go((0.3, 0.06), (0.25, -0.3), (0.0, 0.25), (0.0, -0.12))
    turned = np.flatnonzero(np.diff(found.log[:, 4]) != 0.0)
    assert turned.size > found.counts["retreats"]
    step = np.abs(np.diff(found.log[:, 4]))[turned] * ROBOT.direction_step / ROBOT.neck_speed
    taken = np.diff(found.log[:, 0])[turned]
    backed = found.counts["retreats"]
    assert (np.abs(taken - 1.0 / ROBOT.ping_rate - step) > 1e-9).sum() <= backed


def test_in_a_ring_it_backs_up() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 16)
    ring = [(START[0] + 0.4 * np.cos(a), 0.4 * np.sin(a)) for a in angle]
    found = go(*ring, pings=150)
    assert found.ended == "undecided"
    assert found.counts["retreats"] > 0
    assert found.counts["pings"] == len(found.log) == 150


def test_the_goal_draws_to_where_it_lies() -> None:
    arcs = arcs_of(ROBOT, NUMBERS)
    free = np.zeros(ARCS)
    wish = {
        h: desirabilities(NUMBERS, arcs, free, h, DIRECTIONS // 2, MIDDLE) - arcs.hold[MIDDLE]
        for h in (-1.5, 0.0, 1.5)
    }
    assert np.argmax(wish[0.0]) == MIDDLE
    assert wish[-1.5][0] > wish[-1.5][-1]  # it looks to the right, so the goal is to its left
    assert wish[1.5] == pytest.approx(wish[-1.5][::-1])


def test_risk_inhibits_its_own_arc_most() -> None:
    arcs = arcs_of(ROBOT, NUMBERS)
    risk = np.zeros(ARCS)
    risk[4] = 10.0
    lost = desirabilities(NUMBERS, arcs, np.zeros(ARCS), 0.0, 2, 7) - desirabilities(
        NUMBERS, arcs, risk, 0.0, 2, 7
    )
    assert np.argmax(lost) == 4
    assert lost[4] == pytest.approx(10.0 * NUMBERS.suppression)
