"""Numbers of the robot: what follows from the paper's, and what is refused."""

from __future__ import annotations

import math

import pytest

from circuits.errors import ParameterError
from system.car.numbers import DIRECTIONS, OpenspaceNumbers, Robot


def test_the_rates_are_the_papers() -> None:
    robot = Robot()
    end_to_end = (DIRECTIONS - 1) * robot.direction_step / robot.neck_speed
    assert robot.ping_rate == 12.0
    assert 1.0 / (1.0 / robot.ping_rate + end_to_end) == pytest.approx(3.0, rel=1e-12)


def test_the_zone_is_body_and_pipe() -> None:
    assert Robot(radius=0.1).zone == pytest.approx(0.125)


def test_the_soft_pings_blind_zone_is_inside_the_other() -> None:
    with pytest.raises(ParameterError, match=r"robot\.soft_blanking: 0\.003 s, must be below blanking"):
        Robot(soft_blanking=3e-3)


@pytest.mark.parametrize("name", ["max_speed", "ping_rate", "neck_speed", "call"])
def test_rates_are_positive(name: str) -> None:
    for value in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ParameterError, match=rf"robot\.{name}: .* must be > 0"):
            Robot(**{name: value})


def test_wheels_do_not_turn_across() -> None:
    with pytest.raises(ParameterError, match=r"robot\.most_steering: 90 degrees"):
        Robot(most_steering=0.5 * math.pi)


def test_the_mind_is_finite() -> None:
    with pytest.raises(ParameterError, match=r"robot_openspace\.max_risk: 0, must be > 0"):
        OpenspaceNumbers(max_risk=0.0)
    with pytest.raises(ParameterError, match=r"robot_openspace\.goal_gain: nan, must be finite"):
        OpenspaceNumbers(goal_gain=math.nan)
