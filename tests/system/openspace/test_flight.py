"""Samples of several runs, and where they begin."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.openspace.flight import CLEAR, fly_sample, margin_of, planter
from system.openspace.law import Bat, arcs_of
from system.openspace.map import Forest, clearance

ARCS = arcs_of(Bat(max_speed=4.0))
LONE = Forest("lone", np.array([[10.0, 10.0]]))


def test_a_sample_is_made_of_its_key() -> None:
    first, again, other = (fly_sample(ARCS, planter(1700), (s, 0), 20_000)[0] for s in (4, 4, 5))
    assert first == again
    assert first != other
    assert first.collided
    assert first.avoided > 0


def test_a_trapped_bat_begins_anew_and_counts_on() -> None:
    # it stays on the arc that it is on, whatever is there, and with the goal behind it that is a circle
    circling = arcs_of(Bat(goal_gain=1e-6, hysteresis=0.0, sharp_turn_cost=-5.0, suppression=1e-6))
    sample, first = fly_sample(circling, lambda _: LONE, (0, 0), 40_000, start=(40.0, 40.0))
    assert first.ended == "trapped"
    assert sample.trapped == 3  # 12,500 pings each, the fourth run is not over
    assert sample.runs == 4
    assert not sample.collided
    assert sample.pings == 40_000
    assert sample.laps == 0


def test_another_run_is_in_another_forest() -> None:
    circling = arcs_of(Bat(goal_gain=1e-6, hysteresis=0.0, sharp_turn_cost=-5.0, suppression=1e-6))
    drawn: list[float] = []

    def forests(random: np.random.Generator) -> Forest:
        drawn.append(random.random())
        return LONE

    fly_sample(circling, forests, (7, 0), 30_000, start=(40.0, 40.0))
    assert len(set(drawn)) == len(drawn) == 3


def test_time_way_and_pings_agree() -> None:
    sample, first = fly_sample(ARCS, lambda _: LONE, (1, 0), 5000, rows=5000)
    assert sample.time_s == pytest.approx(5000 / 5.0)
    assert sample.distance_m <= 4.0 * sample.time_s * (1.0 + 1e-12)
    assert first.log.shape == (5000, 8)
    steps = np.diff(np.concatenate([first.log[:, 1:3], [first.end]]), axis=0)
    steps -= 50.0 * np.round(steps / 50.0)
    # chords of the arcs are no longer than these, and hardly shorter on what is mostly straight
    assert np.hypot(*steps.T).sum() == pytest.approx(sample.distance_m, rel=1e-2)
    assert sample.laps == pytest.approx(sample.distance_m / 50.0, rel=0.1)


def test_a_drawn_start_is_clear() -> None:
    for seed in range(5):
        first = fly_sample(ARCS, planter(1700), (seed, 0), 1)[1]
        assert clearance(first.forest, *first.start) >= CLEAR


def test_a_start_in_a_zone_of_collision_is_refused() -> None:
    with pytest.raises(
        ParameterError, match=r"start: 10\.2,10, an obstacle is 0\.2 m away, must be at least"
    ):
        fly_sample(ARCS, lambda _: LONE, (0, 0), 10, start=(10.2, 10.0))
    assert fly_sample(ARCS, lambda _: LONE, (0, 0), 10, start=(9.5, 10.0))[0].pings == 10  # it flies away


def test_no_pings_are_no_sample() -> None:
    with pytest.raises(ParameterError, match="pings: 0"):
        fly_sample(ARCS, lambda _: LONE, (0, 0), 0)


def test_the_margin_holds_a_fast_step() -> None:
    assert margin_of(ARCS) == 5.0
    assert margin_of(arcs_of(replace(Bat(), max_speed=40.0))) == pytest.approx(8.0 + Bat().zone)
    assert math.isfinite(fly_sample(arcs_of(Bat(max_speed=40.0)), planter(600), (0, 0), 200)[0].distance_m)
