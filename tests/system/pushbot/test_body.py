"""Commands and kinematics of the Pushbot."""

from __future__ import annotations

import math

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.pushbot.body import (
    Factors,
    Pushbot,
    Tracks,
    demand,
    follow,
    forward_of,
    gyro,
    track_speed,
    turn_of,
    wheel_commands,
)
from tests.refusals import refusals

ROBOT = Pushbot()


@pytest.mark.parametrize(
    ("forward", "turn", "commands"),
    [
        (0.0, 0.0, (0, 0)),
        (19.0, 0.0, (10, 10)),  # v / r
        (0.0, 8.6 * 1.9 * 7.0, (-6, 7)),  # w / (d r), rounded by adding 0.5 and cutting
        (19.0, 8.6 * 1.9 * 3.0, (7, 13)),
        (1.9 * 0.49, 0.0, (0, 0)),
        (1.9 * 0.51, 0.0, (1, 1)),
        (-1.9 * 1.6, 0.0, (-1, -1)),  # -1.6 + 0.5 is cut to -1
        (1e6, 0.0, (100, 100)),
        (190.0, 8.6 * 1.9 * 20.0, (80, 100)),
        (-1e6, 1e9, (-100, 100)),
    ],
)
def test_commands_are_the_codes(forward: float, turn: float, commands: tuple[int, int]) -> None:
    assert wheel_commands(ROBOT, forward, turn) == commands


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_commands_must_be_finite(bad: float) -> None:
    with pytest.raises(ParameterError, match=r"^pushbot\.command: v"):
        wheel_commands(ROBOT, bad, 0.0)


def test_speed_saturates() -> None:
    assert track_speed(ROBOT, 35) == pytest.approx(0.35)
    assert track_speed(ROBOT, 1000) == 1.0
    assert track_speed(ROBOT, -1000) == -1.0


@pytest.mark.parametrize(("speed", "rate"), [(0.35, 0.0), (0.2, 1.0), (0.0, -2.0)])
def test_asked_for_speed_and_rate_come_about(speed: float, rate: float) -> None:
    left, right = wheel_commands(ROBOT, forward_of(ROBOT, speed), turn_of(ROBOT, rate))
    tracks = Tracks(left_command=left, right_command=right)
    tracks, *_ = follow(ROBOT, tracks, 10.0)
    _, got_speed, got_rate = follow(ROBOT, tracks, 0.1)
    # commands are whole numbers of 1 cm/s; rounding is off by up to one unit, once on each side
    assert got_speed == pytest.approx(speed, abs=0.01)
    assert got_rate == pytest.approx(rate, abs=0.02 / (ROBOT.slip * 0.086))


def test_tracks_follow_with_their_lag() -> None:
    tracks, speed, turn = follow(ROBOT, Tracks(left_command=50, right_command=100), 0.05)
    left = 1.0 - math.exp(-1.0)
    assert (tracks.left, tracks.right) == pytest.approx((0.5 * left, left))
    assert speed == pytest.approx(0.75 * math.exp(-1.0))  # mean of 1 - exp(-t / lag) over one lag
    assert turn == pytest.approx(0.5 * math.exp(-1.0) / (ROBOT.slip * 0.086))


def test_parts_of_a_start_are_the_start() -> None:
    whole, mean, _ = follow(ROBOT, Tracks(right_command=60), 0.1)
    part, way = Tracks(right_command=60), 0.0
    for _ in range(20):
        part, speed, _ = follow(ROBOT, part, 0.005)
        way += 0.005 * speed
    assert part.right == pytest.approx(whole.right)
    assert way == pytest.approx(0.1 * mean)


def test_slip_makes_it_turn_less() -> None:
    rates = [follow(Pushbot(slip=s, lag=0.0), Tracks(right_command=10), 0.1)[2] for s in (1.0, 2.0)]
    assert rates[0] == pytest.approx(0.1 / 0.086)
    assert rates[1] == pytest.approx(0.5 * rates[0])


def test_equations_1_and_2() -> None:
    assert demand(Factors(0.5, 2.0), drive_left=7.0, drive_right=4.0, speed=10.0) == (5.0, 6.0)


def test_the_gyro_is_quantised_noisy_and_limited() -> None:
    random = np.random.default_rng(1)
    samples = np.array([gyro(ROBOT, 1.0, random) for _ in range(4000)])
    step = math.radians(2000.0) / 2**15
    assert samples / step == pytest.approx(np.rint(samples / step), abs=1e-6)
    assert samples.mean() == pytest.approx(1.0, abs=4.0 * math.radians(0.1) / math.sqrt(4000))
    # of noise and of rounding to a step
    assert samples.std() == pytest.approx(math.hypot(math.radians(0.1), step / math.sqrt(12.0)), rel=0.05)
    assert gyro(ROBOT, 100.0, random) == pytest.approx(math.radians(2000.0), abs=1.5 * step)


@pytest.mark.parametrize("value", [0.0, -0.5, math.nan, math.inf])
def test_factors_are_above_zero(value: float) -> None:
    with pytest.raises(
        ParameterError, match=r"^pushbot\.speed_factor: .*, must be above 0; the paper has 0.1 to 3$"
    ):
        Factors(speed=value)
    with pytest.raises(ParameterError, match=r"^pushbot\.turn_factor: "):
        Factors(turn=value)


test_numbers_are_checked = refusals(
    ParameterError,
    lambda changes: Pushbot(**changes),
    [
        ({"wheel_radius": 0.0}, r"pushbot\.wheel_radius: 0, must be > 0"),
        ({"lag": -1.0}, r"pushbot\.lag: -1, must be >= 0"),
        ({"latency": -1.0}, r"pushbot\.latency: -1, must be >= 0"),
        ({"latency": 2.0}, r"pushbot\.latency: 2 s, must be from 0 to 1"),
        ({"dropped": 1.0}, r"pushbot\.dropped: 1, must be from 0 to below 1"),
    ],
)
