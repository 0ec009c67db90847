"""Gaps between obstacles on a lattice, where they are known, and paths through them."""

from __future__ import annotations

import numpy as np
import pytest

from system.forest.coverage import coverage, fine_path
from system.openspace.flight import fly_sample, planter
from system.openspace.law import Bat, arcs_of
from system.openspace.map import SIDE, Forest

PITCH = 5.0  # m
ACROSS = int(SIDE / PITCH)


@pytest.fixture(scope="module")
def lattice() -> Forest:
    # noise decides which of a square's diagonals is an edge; the sides always are
    columns, rows = np.meshgrid(np.arange(ACROSS), np.arange(ACROSS))
    place = PITCH * np.stack([columns.ravel(), rows.ravel()], axis=1) + 0.5
    return Forest("lattice", place + np.random.default_rng(0).uniform(-0.2, 0.2, place.shape))


def straight(y: float) -> np.ndarray:
    x = np.arange(SIDE, 0.0, -0.02) % SIDE
    return np.stack([x, np.full_like(x, y)], axis=1)


def test_a_triangulated_torus_has_three_edges_a_point(lattice: Forest) -> None:
    # Euler: V - E + F = 0 on a torus with 3 F = 2 E
    assert len(coverage(lattice, 0.1, []).gaps) == 3 * ACROSS**2


def test_gaps_are_wide_enough(lattice: Forest) -> None:
    assert len(coverage(lattice, 3.0, []).gaps) == ACROSS**2  # only diagonals, of 7.07 m, are above 6 m


def test_a_straight_path_takes_the_gaps_of_its_row(lattice: Forest) -> None:
    found = coverage(lattice, 0.1, [straight(3.0)])
    # a side and a diagonal for each square of the row; at the seam the path jumps
    assert len(found.taken) == pytest.approx(2 * ACROSS, abs=2)
    assert set(found.taken.values()) == {1}
    twice = coverage(lattice, 0.1, [straight(3.0), straight(3.0), straight(8.0)])
    assert len(twice.taken) == pytest.approx(4 * ACROSS, abs=4)
    assert sorted(set(twice.taken.values())) == [1, 2]
    assert twice.share == len(twice.taken) / (3 * ACROSS**2)


def test_the_busiest_gaps() -> None:
    forest = Forest("six", SIDE * np.random.default_rng(3).random((6, 2)))
    found = coverage(forest, 0.0, [straight(20.0)] * 9)
    assert found.busiest <= 0.5 * found.share + 1.0 / len(found.gaps)


def test_the_fine_path_meets_the_logged_places() -> None:
    arcs = arcs_of(Bat())
    log = fly_sample(arcs, planter(), (3, 0), 300, rows=300)[1].log
    path = fine_path(arcs, log)
    assert np.allclose(path[::40], log[:, 1:3] % SIDE)
    steps = np.diff(path, axis=0)
    steps -= SIDE * np.round(steps / SIDE)
    # each stretch is a fortieth of a step between pings, so it ends where the next one begins
    assert np.hypot(*steps.T).max() <= arcs.speed.max() * arcs.step / 40 * (1.0 + 1e-9)
