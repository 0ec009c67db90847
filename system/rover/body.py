"""The body of the rover: every number of it in one place, and how it moves (Hwu et al. 2018, II.F, II.G).

Skid steering: the wheels of a side turn together, so for the speeds l and r of the two sides

    v = (l + r) / 2,   d heading/dt = (l - r) / (slip track)

with the heading clockwise from true north. In turns wheels slide sideways, so that the rover turns as one
whose track is `slip` times as wide (Mandow et al., "Experimental kinematics for wheeled skid-steer mobile
robots", 2007). Over a step with constant wheel speeds the motion is an arc, followed exactly.

The paper gives the 10 m at which a waypoint counts as reached and the sonars' 254 inches; the rest is ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from circuits.errors import ParameterError


@dataclass(frozen=True, slots=True)
class Rover:
    """Numbers of a rover's body and senses, in SI units, with angles in rad."""

    reach: float = 10.0  # m from a waypoint, when the next one is taken; the paper's
    speed: float = 1.0  # m/s; ours
    track: float = 0.25  # m between the wheels of both sides; ours, of the order of the chassis
    slip: float = 1.8  # effective over real track; ours
    turn_gain: float = 1.0  # 1/s, turn rate per angle between bearing and heading; ours
    turn_rate: float = 0.8  # rad/s at most; ours
    wheel_spread: float = 0.03  # sigma of the relative speed of a side, fixed in a run; ours
    control_period: float = 0.1  # s; ours
    gps_period: float = 1.0  # s; ours, usual for phones
    gps_drift: float = 3.0  # m, sigma an axis; ours: phones under open sky are off by about 5 m
    gps_drift_time: float = 60.0  # s, correlation time of the drift; ours
    gps_noise: float = 0.5  # m, sigma an axis of each fix by itself; ours
    outage_rate: float = 1.0 / 600.0  # 1/s under open sky; ours
    outage_rate_covered: float = 1.0 / 60.0  # 1/s more where trees stand all around; ours
    outage_length: float = 10.0  # s, mean; ours
    declination: float = math.radians(12.0)  # east of true north; ours, about that of Irvine in 2016
    compass_bias: float = math.radians(5.0)  # sigma, fixed in a run: iron near the phone; ours
    compass_noise: float = math.radians(3.0)  # sigma of each reading; ours
    half_width: float = 0.15  # m; ours, of the order of the chassis
    sonar_range: float = 254 * 0.0254  # m; the paper's
    sonar_angle: float = math.radians(45.0)  # half of the field that three sonars see; ours
    sonar_margin: float = 2.0  # m, nearer than which the rover turns away; ours
    redirection_time: float = 15.0  # s that an operator takes to lead it around an obstacle; ours

    def __post_init__(self) -> None:
        for name in ("reach", "speed", "track", "slip", "control_period", "gps_period", "gps_drift_time"):
            if not getattr(self, name) > 0.0:
                raise ParameterError(f"rover.{name}: {getattr(self, name):g}, must be > 0")


@dataclass(frozen=True, slots=True)
class Pose:
    """Place (m east and north of the south-west corner) and heading (rad, clockwise from true north)."""

    east: float
    north: float
    heading: float


def wheel_speeds(rover: Rover, turn: float) -> tuple[float, float]:
    """Speeds of the left and right wheels, m/s, to go at the rover's speed and turn by `turn` rad/s."""
    difference = 0.5 * turn * rover.slip * rover.track
    return rover.speed + difference, rover.speed - difference


def move(rover: Rover, pose: Pose, left: float, right: float, duration: float) -> Pose:
    """Pose after `duration` s at constant wheel speeds, m/s: an exact arc."""
    speed, turn = 0.5 * (left + right), (left - right) / (rover.slip * rover.track)
    angle = turn * duration
    middle = pose.heading + 0.5 * angle
    # the chord of an arc is its length times sin(angle / 2) / (angle / 2), along the mean heading
    chord = speed * duration * (math.sin(0.5 * angle) / (0.5 * angle) if abs(angle) > 1e-9 else 1.0)
    east, north = pose.east + chord * math.sin(middle), pose.north + chord * math.cos(middle)
    return Pose(east, north, wrapped(pose.heading + angle))


def bearing(east: float, north: float) -> float:
    """Direction of a displacement, rad clockwise from north, in -pi to pi."""
    return math.atan2(east, north)


def wrapped(angle: float) -> float:
    """The same direction in -pi to pi: the shortest turn."""
    return math.remainder(angle, 2.0 * math.pi)
