"""Motion of the rover: closed forms, and directions."""

from __future__ import annotations

import math

import pytest

from circuits.errors import ParameterError
from system.rover.body import Pose, Rover, bearing, move, wheel_speeds, wrapped


def test_equal_wheels_go_straight() -> None:
    end = move(Rover(), Pose(1.0, 2.0, math.radians(90.0)), 1.5, 1.5, 2.0)
    assert (end.east, end.north, end.heading) == pytest.approx((4.0, 2.0, math.radians(90.0)))


def test_a_full_circle_returns() -> None:
    rover = Rover()
    left, right = wheel_speeds(rover, 0.5)
    end = move(rover, Pose(0.0, 0.0, 0.0), left, right, 2.0 * math.pi / 0.5)
    assert (end.east, end.north, end.heading) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_a_quarter_turn_to_the_right_ends_north_east() -> None:
    # clockwise from north: radius v / turn = 2 m, centre 2 m east
    rover = Rover()
    end = move(rover, Pose(0.0, 0.0, 0.0), *wheel_speeds(rover, 0.5), math.pi)
    assert (end.east, end.north, end.heading) == pytest.approx((2.0, 2.0, 0.5 * math.pi))


def test_an_arc_in_parts_is_the_arc() -> None:
    rover, start = Rover(), Pose(3.0, -1.0, 2.0)
    whole = move(rover, start, 0.9, 1.1, 1.0)
    part = start
    for _ in range(10):
        part = move(rover, part, 0.9, 1.1, 0.1)
    assert (part.east, part.north, part.heading) == pytest.approx((whole.east, whole.north, whole.heading))


def test_slip_makes_it_turn_less() -> None:
    turned = [move(Rover(slip=s), Pose(0.0, 0.0, 0.0), 1.1, 1.0, 1.0).heading for s in (1.0, 2.0)]
    assert turned[0] == pytest.approx(2.0 * turned[1])


@pytest.mark.parametrize(("east", "north", "degrees"), [(0, 1, 0), (1, 0, 90), (0, -1, 180), (-1, 0, -90)])
def test_bearings_run_clockwise_from_north(east: float, north: float, degrees: float) -> None:
    assert math.degrees(bearing(east, north)) == pytest.approx(degrees)


def test_the_shorter_turn() -> None:
    assert math.degrees(wrapped(math.radians(350.0 - 10.0))) == pytest.approx(-20.0)
    assert math.degrees(wrapped(math.radians(10.0 - 350.0))) == pytest.approx(20.0)


def test_numbers_are_checked() -> None:
    with pytest.raises(ParameterError, match=r"^rover\.speed: 0, must be > 0"):
        Rover(speed=0.0)
