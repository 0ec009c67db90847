"""Geometry of the arcs against what is known of circles, and the numbers that are refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.openspace.law import (
    ARCS,
    DIRECTIONS,
    MIDDLE,
    Bat,
    arc_point,
    arcs_of,
    detectable,
    length_in_view,
)
from tests.refusals import refusals

BAT = Bat()


def test_the_paper_s_field_of_view() -> None:
    # the paper's half-maximum width of 70.7 degrees is 2 sqrt(2 ln 2) 30 = 70.64 degrees
    half = detectable(BAT, np.array(math.radians(0.5 * 70.7)))
    assert half == pytest.approx(2.5, rel=2e-3)
    assert detectable(BAT, np.array(0.0)) == 5.0


def test_the_straight_arc_is_seen_over_the_whole_range_and_flown_at_full_speed() -> None:
    arcs = arcs_of(BAT)
    assert arcs.curvature[MIDDLE] == 0.0
    assert arcs.length[MIDDLE] == pytest.approx(BAT.max_range)
    assert arcs.speed[MIDDLE] == pytest.approx(BAT.max_speed)
    assert arcs.group[MIDDLE] == DIRECTIONS // 2


def test_arcs_mirror_each_other() -> None:
    arcs = arcs_of(BAT)
    assert np.allclose(arcs.curvature, -arcs.curvature[::-1])
    assert np.allclose(arcs.length, arcs.length[::-1])
    assert np.array_equal(arcs.group, DIRECTIONS - 1 - arcs.group[::-1])
    assert np.all(np.diff(arcs.group) >= 0)
    assert set(arcs.group.tolist()) == set(range(DIRECTIONS))


def test_no_ping_direction_sees_more_of_an_arc_than_its_own() -> None:
    arcs = arcs_of(BAT)
    for p in range(ARCS):
        seen = [length_in_view(BAT, float(arcs.curvature[p]), float(psi)) for psi in arcs.direction]
        assert arcs.length[p] == max(seen)
    assert np.allclose(arcs.speed, BAT.max_speed * arcs.length / BAT.max_range)
    assert arcs.speed.max() <= BAT.max_speed


def test_an_arc_leaves_the_field_of_view_at_its_border() -> None:
    curvature, direction = 0.5, 0.3
    s = length_in_view(BAT, curvature, direction)
    x, y = arc_point(np.array(curvature), np.array(s))
    reach = detectable(BAT, np.arctan2(y, x) - direction)
    assert math.hypot(float(x), float(y)) == pytest.approx(float(reach), rel=1e-9)


def test_points_of_an_arc_lie_on_its_circle() -> None:
    x, y = arc_point(np.full(9, -0.8), np.linspace(0.1, 3.0, 9))
    assert np.allclose(np.hypot(x, y + 1.25), 1.25, rtol=1e-12)


def test_the_weights_of_equation_6() -> None:
    arcs = arcs_of(replace(BAT, suppression=2.0, suppression_sigma=3.0, hysteresis=0.7))
    assert arcs.spread[4, 7] == pytest.approx(2.0 * math.exp(-1.0))
    assert arcs.hold[9, 9] == pytest.approx(0.7)
    assert arcs.bias[MIDDLE] == BAT.default
    assert arcs.bias[0] == pytest.approx(BAT.default - BAT.sharp_turn_cost)


test_numbers_that_are_none_are_refused = refusals(
    ParameterError,
    lambda change: replace(BAT, **change),
    [
        ({"max_speed": 0.0}, r"bat\.max_speed: 0, must be > 0"),
        ({"ping_rate": -5.0}, r"bat\.ping_rate: -5"),
        ({"view_sigma": math.nan}, r"bat\.view_sigma: nan"),
        ({"max_range": math.inf}, r"bat\.max_range: inf"),
        ({"ping_bias": math.inf}, r"bat\.ping_bias: inf, must be finite"),
        ({"immediacy": "cubic"}, r"bat\.immediacy: cubic, must be linear or squared"),
        ({"zone": 5.0}, r"bat\.zone: 5 m, must be less than least_radius"),
    ],
)
