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
    """The numbers of a rover's body, its senses and its surroundings; SI units, angles in rad.

    Two are the paper's, as marked; the others are ours.

    Attributes
    ----------
    reach : float
        Distance from a waypoint at which the next one is taken, m; the paper's.
    speed : float
        Speed ahead, m/s.
    track : float
        Distance between the wheels of both sides, m; of the order of the chassis.
    slip : float
        Effective over real track in turns, dimensionless.
    turn_gain : float
        Turn rate for each rad between bearing and heading, 1/s.
    turn_rate : float
        Largest turn rate, rad/s.
    wheel_spread : float
        Standard deviation of the relative speed of a side, dimensionless; drawn once in a run.
    control_period : float
        Time between two commands to the wheels, s.
    gps_period : float
        Time between two fixes of the GPS, s; usual for phones.
    gps_drift : float
        Standard deviation of the slow error of the GPS on each axis, m. Phones under open sky are off by
        about 5 m.
    gps_drift_time : float
        Correlation time of that error, s.
    gps_noise : float
        Standard deviation of the error of each fix by itself, on each axis, m.
    outage_rate : float
        Outages of the GPS in a second under open sky, 1/s.
    outage_rate_covered : float
        Outages in a second more where trees stand all around, 1/s.
    outage_length : float
        Mean length of an outage, s.
    declination : float
        Angle of magnetic north east of true north, rad; about that of Irvine in 2016.
    compass_bias : float
        Standard deviation of the compass's constant error, rad; it is drawn once in a run, as from iron
        nearby.
    compass_noise : float
        Standard deviation of the error of each reading of the compass, rad.
    half_width : float
        Half of the rover's width, m; of the order of the chassis.
    sonar_range : float
        Distance that the sonars see, m; the paper's 254 inches.
    sonar_angle : float
        Half of the field that the three sonars see together, rad.
    sonar_margin : float
        Distance of an obstacle below which the rover turns away, m.
    redirection_time : float
        Time that an operator takes to lead the rover around an obstacle, s.

    Raises
    ------
    ParameterError
        A length, a speed or a period is not above 0.
    """

    reach: float = 10.0
    speed: float = 1.0
    track: float = 0.25
    slip: float = 1.8
    turn_gain: float = 1.0
    turn_rate: float = 0.8
    wheel_spread: float = 0.03
    control_period: float = 0.1
    gps_period: float = 1.0
    gps_drift: float = 3.0
    gps_drift_time: float = 60.0
    gps_noise: float = 0.5
    outage_rate: float = 1.0 / 600.0
    outage_rate_covered: float = 1.0 / 60.0
    outage_length: float = 10.0
    declination: float = math.radians(12.0)
    compass_bias: float = math.radians(5.0)
    compass_noise: float = math.radians(3.0)
    half_width: float = 0.15
    sonar_range: float = 254 * 0.0254
    sonar_angle: float = math.radians(45.0)
    sonar_margin: float = 2.0
    redirection_time: float = 15.0

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
