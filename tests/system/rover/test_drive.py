"""Drives: where the waypoints are, when the next one is taken, and what stands in the way."""

from __future__ import annotations

import numpy as np
import pytest

from system.rover.body import Rover
from system.rover.cost_map import CostMap, load_map
from system.rover.drive import cell_at, drive, polyline, scatter_obstacles, tree_cover, turn_away
from system.rover.sensors import Obstacle

EXACT = Rover(
    gps_drift=0.0, gps_noise=0.0, outage_rate=0.0, outage_rate_covered=0.0, compass_bias=0.0,
    compass_noise=0.0, wheel_spread=0.0,
)  # fmt: skip
LAWN = CostMap("lawn", np.full((4, 20), 3), 6.0, 5.0)
ROW = np.stack([np.full(20, 1), np.arange(20)], axis=1)


def test_waypoints_are_the_centres_of_cells() -> None:
    points = polyline(LAWN, np.array([[0, 0], [3, 19]]))
    assert points.tolist() == [[3.0, 17.5], [117.0, 2.5]]
    for cell in ((0, 0), (3, 19), (1, 7)):
        assert cell_at(LAWN, *polyline(LAWN, np.array([cell]))[0].tolist()) == cell
    assert cell_at(LAWN, -5.0, 100.0) == (0, 0)


def test_an_exact_rover_drives_straight_and_stops_within_reach() -> None:
    found = drive(EXACT, LAWN, ROW, (0,))
    assert found.arrived
    assert np.ptp(found.place[:, 1]) < 1e-9
    # it stops at the first fix, taken every second at 1 m/s, that is less than 10 m from the last centre
    left = 117.0 - found.place[-1, 0]
    assert 10.0 - 1.0 - 0.1 <= left < 10.0
    assert found.time[-1] == pytest.approx(found.distance / EXACT.speed, rel=1e-6)


def test_the_same_key_is_the_same_drive() -> None:
    one, again, other = (drive(Rover(), LAWN, ROW, key) for key in ((3, 0), (3, 0), (3, 1)))
    assert np.array_equal(one.place, again.place)
    assert not np.array_equal(one.place[-1], other.place[-1])


def test_a_rover_that_faces_away_turns_back() -> None:
    back = np.concatenate([ROW[:1], ROW[:0:-1], ROW])  # the heading is towards the far end, then back
    found = drive(EXACT, LAWN, back[:22], (0,))
    assert found.arrived


def test_a_lone_cell_is_reached_at_once() -> None:
    found = drive(EXACT, LAWN, ROW[:1], (0,))
    assert (found.arrived, found.distance, found.time[-1]) == (True, 0.0, 0.0)


def test_a_way_that_cannot_be_found_is_given_up() -> None:
    lost = Rover(outage_rate=1e9, outage_length=1e9)  # the fix never moves
    found = drive(lost, LAWN, ROW, (0,))
    assert not found.arrived
    assert found.time[-1] == pytest.approx(120.0 + 10.0 * 114.0, abs=0.2)


def test_an_operator_leads_it_around_what_it_strikes() -> None:
    post = (Obstacle(60.0, 12.4, 0.5),)
    found = drive(EXACT, LAWN, ROW, (0,), post)
    assert found.arrived
    assert found.interventions == 1
    free = drive(EXACT, LAWN, ROW, (0,))
    # the operator's 15 s, less at most a second's step
    assert found.time[-1] - free.time[-1] == pytest.approx(15.0, abs=1.5)
    clear = np.hypot(*(found.place - (60.0, 12.4)).T)
    assert clear.min() >= 0.5


def test_sonars_spare_the_operator() -> None:
    post = (Obstacle(60.0, 12.4, 0.5),)
    found = drive(EXACT, LAWN, ROW, (0,), post, avoid=turn_away(EXACT, post))
    assert found.arrived
    assert found.interventions == 0


def test_trees_cover() -> None:
    costs = np.full((3, 3), 3)
    costs[0, 0] = 6
    cover = tree_cover(CostMap("tree", costs))
    # the edge is taken to go on: four of the nine cells around the corner are that tree
    assert cover[0, 0] == pytest.approx(4 / 9)
    assert cover[1, 1] == pytest.approx(1 / 9)
    assert cover[2, 2] == 0.0


def test_posts_are_denser_among_trees_and_clear_of_centres() -> None:
    park = load_map("map2")
    posts = [o for seed in range(20) for o in scatter_obstacles(park, (seed,))]
    at = np.array([cell_at(park, o.east, o.north) for o in posts])
    trees = park.costs[at[:, 0], at[:, 1]] >= 6
    assert trees.mean() > 0.95
    gap = polyline(park, at) - [(o.east, o.north) for o in posts]
    assert np.hypot(*gap.T).min() > 1.0


def test_visits_are_of_the_cell_under_it_and_of_the_fix() -> None:
    seen: list[tuple[tuple[int, int], tuple[int, int]]] = []
    drive(EXACT, LAWN, ROW, (0,), visit=lambda under, fix: seen.append((under, fix)))
    assert all(a == b for a, b in seen)
    assert {a for a, _ in seen} == {(1, c) for c in range(18)}
