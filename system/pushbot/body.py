"""The body of the Pushbot: every number of it in one place, its commands, and how it moves.

Milde et al. 2017, sections 2.3 and 2.4. Equations (1) and (2) of the paper turn spikes a neuron in a window
into what the robot's code takes:

    w = c_turn (N_DL / n_DL - N_DR / n_DR),      v = c_speed N_sp / n_sp

The robot's code (NCSRobotLib, PushBot.cpp) makes commands of the wheels, whole numbers from -100 to 100, by

    right = v / r + w / (d r),   left = v / r - w / (d r),   rounded by adding 0.5 and cutting

with wheel distance d = 8.6 and wheel radius r = 1.9, in cm. Two wheels d apart would turn by w with d w /
(2 r) instead: the code's turn lacks a factor d^2 / 2. It is kept, for the paper's factors belong to it.
Real wheels follow: tracks slip in turns as if they stood `slip` times as wide apart.

Wheel figures are the code's, 10 x 10 cm and a latency below 10 ms the paper's; speed factors 0.1, 0.5 and
3.0 were about 0.07, 0.35 and 1 m/s. The gyro's range is the eDVS manual's. The rest is ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from circuits.errors import ParameterError
from system.numbers import check_numbers

LIMIT = 100  # of a command, either way
_CM = 0.01  # m
SPEED_OF_FACTOR = 0.7  # m/s a unit of the speed factor at full drive, from 0.1 and 0.5 in the paper


@dataclass(frozen=True, slots=True)
class Pushbot:
    """The numbers of the Pushbot's body; all are in SI units, and angles are in rad.

    Attributes
    ----------
    wheel_distance : float
        Distance of the two tracks, m; the robot's code.
    wheel_radius : float
        Radius of a wheel, m; the robot's code.
    top_speed : float
        Speed of a track at a command of 100, m/s. It is the fastest of the paper; that 100 gives it is ours.
    slip : float
        Effective over real wheel distance in turns, dimensionless. Ours: 1.5 to 2 is usual of tracks as long
        as they are wide.
    lag : float
        Time constant of a motor under its own controller, s; ours.
    latency : float
        Time that events take to the controller, and commands back, s each; ours, the paper has below 10 ms.
    dropped : float
        Share of the events that are dropped at random, from 0 to below 1; the paper's.
    gyro_range : float
        Largest turn rate that the gyro tells, in either direction, rad/s; it is divided into 16 bits (eDVS
        manual).
    gyro_noise : float
        Standard deviation of one sample of the gyro, rad/s; ours.
    gyro_period : float
        Time between two samples of the gyro, s; the 125 Hz that the lab's own software asks for.

    Raises
    ------
    ParameterError
        A number breaks its rule.
    """

    wheel_distance: float = 0.086
    wheel_radius: float = 0.019
    top_speed: float = 1.0
    slip: float = 1.8
    lag: float = 0.05
    latency: float = 8e-3
    dropped: float = 0.8
    gyro_range: float = math.radians(2000.0)
    gyro_noise: float = math.radians(0.1)
    gyro_period: float = 8e-3

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_numbers("pushbot", self, from_zero=("lag", "gyro_noise", "latency", "dropped"))
        if self.latency > 1.0:
            raise ParameterError(
                f"pushbot.latency: {self.latency:g} s, must be from 0 to 1; the paper's is below 0.01"
            )
        if self.dropped >= 1.0:
            raise ParameterError(
                f"pushbot.dropped: {self.dropped:g}, must be from 0 to below 1; the paper's is 0.8"
            )


@dataclass(frozen=True, slots=True)
class Factors:
    """Speed and turn factors of equations (1) and (2).

    speed : c_speed of equation (2).
    turn : c_turn of equation (1).
    """

    speed: float = 0.5
    turn: float = 0.5

    def __post_init__(self) -> None:
        """Check the factors."""
        for name in ("speed", "turn"):
            if not (getattr(self, name) > 0.0 and math.isfinite(getattr(self, name))):
                raise ParameterError(
                    f"pushbot.{name}_factor: {getattr(self, name):g}, must be above 0; the paper has 0.1 to 3"
                )


@dataclass(frozen=True, slots=True)
class Tracks:
    """State of the motors: speeds (m/s) of both tracks, and the commands that they follow.

    left : speed, m/s.
    right : speed, m/s.
    left_command : from -100 to 100.
    right_command : from -100 to 100.
    """

    left: float = 0.0
    right: float = 0.0
    left_command: float = 0
    right_command: float = 0


def wheel_commands(robot: Pushbot, forward: float, turn: float) -> tuple[int, int]:
    """Commands (left, right) for the code's v (cm/s) and w; beyond 100 they are cut off.

    Raises
    ------
    ParameterError
        One of the two is no finite number.
    """
    left, right = _drives(robot, forward, turn)
    return _whole(left), _whole(right)


def wheel_drives(robot: Pushbot, forward: float, turn: float) -> tuple[float, float]:
    """What `wheel_commands` rounds, cut off beyond 100."""
    left, right = _drives(robot, forward, turn)
    return max(-LIMIT, min(left, LIMIT)), max(-LIMIT, min(right, LIMIT))


def _drives(robot: Pushbot, forward: float, turn: float) -> tuple[float, float]:
    if not (math.isfinite(forward) and math.isfinite(turn)):
        raise ParameterError(f"pushbot.command: v {forward:g}, w {turn:g}, must be finite")
    d, r = robot.wheel_distance / _CM, robot.wheel_radius / _CM
    return forward / r - turn / (d * r), forward / r + turn / (d * r)


def track_speed(robot: Pushbot, command: float) -> float:
    """Speed of a track (m/s) that a command leads to."""
    return robot.top_speed * max(-LIMIT, min(command, LIMIT)) / LIMIT


def forward_of(robot: Pushbot, speed: float) -> float:
    """The code's v (cm/s) of `robot` for `speed` ahead, m/s."""
    return speed / robot.top_speed * LIMIT * robot.wheel_radius / _CM


def turn_of(robot: Pushbot, rate: float) -> float:
    """The code's w (dimensionless) of `robot` for the turn rate `rate`, rad/s."""
    difference = 0.5 * rate * robot.slip * robot.wheel_distance
    return difference / robot.top_speed * LIMIT * robot.wheel_distance * robot.wheel_radius / _CM**2


def demand(factors: Factors, drive_left: float, drive_right: float, speed: float) -> tuple[float, float]:
    """(v, w) of equations (2) and (1) from spikes a neuron of DL, DR and sp in the window."""
    return factors.speed * speed, factors.turn * (drive_left - drive_right)


def follow(robot: Pushbot, tracks: Tracks, duration: float) -> tuple[Tracks, float, float]:
    """Go on for `duration` s; the tracks then, and the mean speed (m/s) and turn rate (rad/s) on the way."""
    goals = track_speed(robot, tracks.left_command), track_speed(robot, tracks.right_command)
    decay = math.exp(-duration / robot.lag) if robot.lag > 0.0 else 0.0
    mean = robot.lag / duration * (1.0 - decay)
    ends = [goal + (now - goal) * decay for goal, now in zip(goals, (tracks.left, tracks.right), strict=True)]
    left, right = (
        goal + (now - goal) * mean for goal, now in zip(goals, (tracks.left, tracks.right), strict=True)
    )
    after = Tracks(ends[0], ends[1], tracks.left_command, tracks.right_command)
    return after, 0.5 * (left + right), (right - left) / (robot.slip * robot.wheel_distance)


def gyro(robot: Pushbot, turn: float, random: np.random.Generator) -> float:
    """A sample (rad/s) of the turn rate: with noise, cut off at its range and in steps of 16 bits."""
    step = robot.gyro_range / 2**15
    sample = round((turn + robot.gyro_noise * random.standard_normal()) / step)
    return step * max(-(2**15), min(sample, 2**15 - 1))


def _whole(value: float) -> int:
    """Add 0.5 and cut, as the code does; so numbers below -0.5 go up by one."""
    return max(-LIMIT, min(math.trunc(value + 0.5), LIMIT))
