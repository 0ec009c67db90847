"""Sensors: the drift's distribution and memory, held fixes, declination, and what sonars see."""

from __future__ import annotations

import math

import numpy as np
import pytest

from system.rover.body import Pose, Rover
from system.rover.sensors import Obstacle, compass, nearest_ahead, receiver, stream

HERE = Pose(10.0, 20.0, 0.0)


def fixes(rover: Rover, n: int, seed: int = 0, cover: float = 0.0) -> np.ndarray:
    gps = receiver(rover, HERE, stream((seed,), 0))
    found = []
    for k in range(n):
        gps.sample(k * rover.gps_period, HERE, cover)
        found.append(gps.fix)
    return np.array(found) - (HERE.east, HERE.north)


def test_the_drift_is_gauss_markov() -> None:
    rover = Rover(gps_drift=3.0, gps_drift_time=10.0, gps_noise=0.0, outage_rate=0.0, outage_rate_covered=0.0)
    error = fixes(rover, 40_000)[:, 0]
    # 40,000 s hold about 2,000 independent values (twice the correlation time apart): sigma is known to
    # 1 / sqrt(4,000) = 1.6 % rms, and a correlation near e^-1 to about 0.03; four times that
    assert error.std() == pytest.approx(3.0, rel=0.065)
    lagged = np.mean(error[:-10] * error[10:]) / np.mean(error**2)
    assert lagged == pytest.approx(math.exp(-1.0), abs=0.12)


def test_without_errors_the_fix_is_the_place() -> None:
    rover = Rover(gps_drift=0.0, gps_noise=0.0, outage_rate=0.0, outage_rate_covered=0.0)
    assert np.all(fixes(rover, 5) == 0.0)


def test_in_an_outage_the_last_fix_is_held() -> None:
    rover = Rover(outage_rate=1e9, outage_length=1e9)
    error = fixes(rover, 20)
    assert np.all(error == error[0])


def test_outages_come_at_their_rate_and_more_under_trees() -> None:
    rover = Rover(outage_rate=0.01, outage_rate_covered=0.09, outage_length=1e-9, gps_noise=0.0)
    counts = []
    for cover in (0.0, 1.0):
        gps = receiver(rover, HERE, stream((1,), 0))
        for k in range(10_000):
            gps.sample(float(k), HERE, cover)
        counts.append(gps.outages)
    # Poisson: 100 and 950 (1 - e^-0.1 a second), sigma 10 and 29; four sigma
    assert counts[0] == pytest.approx(100, abs=40)
    assert counts[1] == pytest.approx(952, abs=117)


def test_the_declination_is_undone() -> None:
    needle = compass(Rover(compass_bias=0.0, compass_noise=0.0), stream((0,), 1))
    for heading in (-3.0, 0.0, 3.1):
        assert needle.heading(Pose(0.0, 0.0, heading)) == pytest.approx(heading)


def test_a_compass_has_a_fixed_error() -> None:
    needle = compass(Rover(compass_noise=0.0), stream((0,), 1))
    assert needle.heading(HERE) == needle.heading(HERE) == pytest.approx(needle.bias)
    assert needle.bias != 0.0


def test_sonars_see_what_is_near_and_ahead() -> None:
    rover = Rover()
    ahead, behind, far = Obstacle(11.0, 23.0, 0.5), Obstacle(10.0, 18.0, 0.5), Obstacle(10.0, 27.0, 0.5)
    assert nearest_ahead(rover, HERE, (behind, far)) is None
    found = nearest_ahead(rover, HERE, (far, behind, ahead))
    assert found is not None
    assert found == pytest.approx((math.hypot(1.0, 3.0) - 0.5, math.atan2(1.0, 3.0)))
