"""What the rover senses: a GPS that drifts and drops out, a compass, and sonars.

GPS: an error of first-order Gauss-Markov kind on each axis,

    b(t + dt) = b(t) exp(-dt/tau) + sigma sqrt(1 - exp(-2 dt/tau)) n,   n ~ N(0, 1)

plus noise in each fix. Outages begin at random, more often among trees, and last for an exponential time;
until the next fix the last one is held, as a sampled sensor's value always is.
Compass: reads magnetic north, so the heading less the declination (east positive), with a fixed error and
noise; the robot adds the declination again. The paper subtracts one whose sign it does not give.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from system.rover.body import Pose, Rover, bearing, wrapped

GPS_STREAM, COMPASS_STREAM, WHEEL_STREAM, OBSTACLE_STREAM = range(4)


def stream(key: Sequence[int], purpose: int) -> np.random.Generator:
    """Random numbers of a seed and a trip, for one purpose, so that more of one do not move the others."""
    return np.random.default_rng([*key, purpose])


@dataclass(slots=True)
class Gps:
    """State of a receiver: its drift (m, east and north), the last fix, and the end of an outage (s).

    rover : numbers of the receiver.
    random : what draws its noise.
    silent_until : end of an outage, s.
    outages : how many there were so far.
    """

    rover: Rover
    random: np.random.Generator
    drift: tuple[float, float]
    fix: tuple[float, float]
    silent_until: float = -math.inf
    outages: int = 0

    def sample(self, time: float, pose: Pose, cover: float) -> None:
        """Take the fix at `time`; `cover`, 0 to 1, is the share of trees around."""
        r = self.rover
        keep = math.exp(-r.gps_period / r.gps_drift_time)
        spread = r.gps_drift * math.sqrt(1.0 - keep * keep)
        numbers = self.random.standard_normal(4)
        begins, length = self.random.random(), self.random.exponential(r.outage_length)
        east, north = (keep * old + spread * float(n) for old, n in zip(self.drift, numbers[:2], strict=True))
        self.drift = east, north
        rate = r.outage_rate + r.outage_rate_covered * cover
        if time >= self.silent_until and begins < -math.expm1(-rate * r.gps_period):
            self.silent_until = time + length
            self.outages += 1
        if time >= self.silent_until:
            noise = r.gps_noise * numbers[2:]
            self.fix = pose.east + east + float(noise[0]), pose.north + north + float(noise[1])


def receiver(rover: Rover, pose: Pose, random: np.random.Generator) -> Gps:
    """A receiver that has settled: its drift is anywhere in its distribution, and it has a fix."""
    east, north = (rover.gps_drift * float(n) for n in random.standard_normal(2))
    return Gps(rover, random, (east, north), (pose.east + east, pose.north + north))


@dataclass(slots=True)
class Compass:
    """A phone's compass with a fixed error, rad.

    rover : numbers of the compass.
    random : what draws its noise.
    bias : its fixed error, rad.
    """

    rover: Rover
    random: np.random.Generator
    bias: float

    def heading(self, pose: Pose) -> float:
        """Heading that the robot reckons, rad from true north: the reading plus the declination."""
        noise = self.bias + self.rover.compass_noise * float(self.random.standard_normal())
        reading = pose.heading - self.rover.declination + noise
        return wrapped(reading + self.rover.declination)


def compass(rover: Rover, random: np.random.Generator) -> Compass:
    """Return a compass whose fixed error is drawn."""
    return Compass(rover, random, rover.compass_bias * float(random.standard_normal()))


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A post that no map has: place and radius, m.

    east : of its middle, m.
    north : of its middle, m.
    """

    east: float
    north: float
    radius: float


def nearest_ahead(rover: Rover, pose: Pose, obstacles: tuple[Obstacle, ...]) -> tuple[float, float] | None:
    """Distance to the surface (m) and side (rad, clockwise from the heading) of the nearest that is seen."""
    seen = []
    for o in obstacles:
        east, north = o.east - pose.east, o.north - pose.north
        distance = math.hypot(east, north) - o.radius
        side = wrapped(bearing(east, north) - pose.heading)
        if distance < rover.sonar_range and abs(side) < rover.sonar_angle:
            seen.append((distance, side))
    return min(seen, default=None)
