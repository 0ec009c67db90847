"""A ping: places of pipes, the blind zones, shadows, and sound by way of two pipes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.arrays import F64
from system.car.localiser import trained
from system.car.numbers import Robot
from system.car.sonar import SPEED, Sonar, noise_of, ping, shadowed
from system.openspace.reader import STEP

ROBOT = Robot()


@pytest.fixture(scope="module")
def sonar() -> Sonar:
    return Sonar(ROBOT, trained(ROBOT), noise_of(ROBOT, np.random.default_rng(2)), np.empty(0))


def at(*places: tuple[float, float]) -> F64:
    """Places of (range, degrees)."""
    found = np.array(places)
    angle = np.radians(found[:, 1])
    return np.stack([found[:, 0] * np.cos(angle), found[:, 0] * np.sin(angle)], axis=1)


@pytest.mark.parametrize("degrees", [-30.0, 0.0, 20.0])
def test_a_pipe_is_where_it_is(sonar: Sonar, degrees: float) -> None:
    heard = ping(sonar, at((0.8, degrees)), 0, soft=False)
    assert len(heard.place) == 1
    # 50 us between samples are 8.6 mm of range; 3 degrees of the localiser are 40 mm across
    assert np.hypot(*heard.place[0]) == pytest.approx(0.8, abs=9e-3)
    assert np.degrees(np.arctan2(*heard.place[0][::-1])) == pytest.approx(degrees, abs=3.0)


def test_two_pipes_are_two(sonar: Sonar) -> None:
    assert len(ping(sonar, at((0.7, -20.0), (0.9, 20.0)), 0, soft=False).place) == 2


def test_the_blind_zone_is_noticed_and_a_soft_ping_looks_into_it(sonar: Sonar) -> None:
    near = at((0.4, 10.0))
    loud, soft = ping(sonar, near, 0, soft=False), ping(sonar, near, 1, soft=True)
    assert (len(loud.place), loud.near) == (0, 1)
    assert np.hypot(*soft.place[0]) == pytest.approx(0.4, abs=9e-3)
    assert ping(sonar, at((0.7, 10.0)), 0, soft=False).near == 0


def test_nothing_looks_into_the_soft_pings_own_blind_zone(sonar: Sonar) -> None:
    nearest = 0.5 * SPEED * ROBOT.soft_blanking
    assert len(ping(sonar, at((nearest - 0.01, 0.0)), 0, soft=True).place) == 0


def test_a_pipe_right_behind_another_is_silent(sonar: Sonar) -> None:
    row = at((0.6, 0.0), (0.9, 1.0))
    assert shadowed(*_polar(row)).tolist() == [False, True]
    hidden, shown = (
        ping(replace(sonar, occlusion=each, multipath=False), row, 0, soft=False) for each in (True, False)
    )
    assert (len(hidden.place), hidden.occluded) == (1, 1)
    assert (len(shown.place), shown.occluded) == (2, 0)


def test_a_pipe_beside_another_is_not() -> None:
    assert not shadowed(*_polar(at((0.6, 0.0), (0.9, 4.0)))).any()


def test_sound_by_way_of_two_pipes_comes_later(sonar: Sonar) -> None:
    robot = replace(ROBOT, scatter=0.2)  # loud enough to be above the threshold
    pair = at((0.6, 15.0), (0.6, -25.0))
    with_it, without = (
        ping(replace(sonar, robot=robot, multipath=each), pair, 0, soft=False) for each in (True, False)
    )
    assert len(with_it.place) > len(without.place)
    gap = np.hypot(*(pair[0] - pair[1])) - 0.05
    farthest = np.hypot(*with_it.place.T).max()
    # (r_i + d + r_j) / 2 from surface to surface, and a pipe's radius
    assert farthest == pytest.approx(0.575 + 0.5 * gap + 0.025, abs=9e-3)


def test_a_chips_readings_are_its_ranges(sonar: Sonar) -> None:
    reading = np.full(600, 0.625)
    heard = ping(replace(sonar, reading=reading), at((0.8, 0.0)), 0, soft=False)
    assert np.hypot(*heard.place[0]) == pytest.approx(0.65)
    missing = np.where(np.arange(600) * STEP < 4e-3, 0.5, np.nan)  # s; the echo comes after 4.5 ms
    deaf = ping(replace(sonar, reading=missing), at((0.8, 0.0)), 0, soft=False)
    assert (len(deaf.place), deaf.missed) == (0, 1)


def test_no_pipe_is_no_echo(sonar: Sonar) -> None:
    heard = ping(sonar, at((3.0, 0.0)), 0, soft=False)
    assert (len(heard.place), heard.near, heard.missed) == (0, 0, 0)


def _polar(place: F64) -> tuple[F64, F64]:
    return np.hypot(*place.T), np.arctan2(place[:, 1], place[:, 0])
