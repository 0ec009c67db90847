"""Flights by the chip: past an obstacle and the same again, crossings, a ring, a collision."""

import numpy as np
import pytest

from system.openspace.law import Bat, arcs_of
from system.openspace.map import Forest
from system.spiking_bat.chip_brain import chip_brain
from system.spiking_bat.flight import Flown, fly
from system.spiking_bat.numbers import Numbers

ARCS = arcs_of(Bat(ping_rate=10.0))


def flown(place: list[tuple[float, float]], pings: int, laps: int | None = None) -> Flown:
    return fly(chip_brain(ARCS, Numbers()), ARCS, Forest("some", np.array(place)), (25.0, 25.0), pings, laps)


def test_an_obstacle_is_avoided_and_a_flight_is_the_same_again() -> None:
    a, b = (flown([(20.0, 25.05)], 40) for _ in range(2))
    assert not a.collided
    assert (a.pings, a.avoided) == (40, 1)
    assert np.array_equal(a.path, b.path)
    assert np.hypot(*(a.path - [20.0, 25.05]).T).min() > 0.3
    # 4 s at up to 2 m/s
    assert 6.0 < a.distance_m < 8.0


def test_crossings_end_a_flight() -> None:
    found = flown([(5.0, 45.0)], 500, 1)
    assert found.laps == 1
    # 25 m to the border at 2 m/s, at means of arcs a few percent slower
    assert found.time_s == pytest.approx(12.5, rel=0.08)


def test_in_a_ring_it_turns_round_at_every_ping() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    ring = [(25.0 + 1.5 * np.cos(t), 25.0 + 1.5 * np.sin(t)) for t in angle]
    found = flown(ring, 20)
    assert (found.emergencies, found.collided) == (20, False)


def test_what_stands_beside_it_ends_it() -> None:
    # within the zone of collision of the place where the first ping's answer finds it, 0.1 m on
    found = flown([(24.85, 25.28)], 20)
    assert found.collided
    assert found.pings == 1
