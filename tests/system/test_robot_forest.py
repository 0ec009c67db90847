"""The three forests, and where a robot may start."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from circuits.errors import ParameterError
from system.robot_forest import BEFORE, FORESTS, LONG, PIPES, SPACING, WIDE, clearance, forest_of, start_of


@pytest.mark.parametrize("name", FORESTS[1:])
def test_a_forest_is_as_large_as_the_papers(name: str) -> None:
    place = forest_of(name, np.random.default_rng(0)).place
    assert len(place) == PIPES == 21
    assert (LONG[name], WIDE[name]) == {"open": (1.8, 1.8), "dense": (1.8, 1.4)}[name]
    assert place[:, 0].min() >= 0.0
    assert place[:, 0].max() <= LONG[name]
    assert np.abs(place[:, 1]).max() <= 0.5 * WIDE[name]
    assert pdist(place).min() >= SPACING


def test_another_seed_is_another_forest() -> None:
    one, same, other = (forest_of("open", np.random.default_rng(k)).place for k in (0, 0, 1))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_the_corridor_is_two_even_lines() -> None:
    place = forest_of("corridor", np.random.default_rng(0)).place
    left, right = place[place[:, 1] > 0.0], place[place[:, 1] < 0.0]
    assert np.array_equal(left[:, 0], right[:, 0])
    assert np.diff(left[:, 0]) == pytest.approx(np.diff(left[:, 0])[0])


def test_a_start_is_before_the_forest() -> None:
    forest = forest_of("dense", np.random.default_rng(0))
    x, y, _ = start_of(forest, np.random.default_rng(1), 0.08)
    assert x == -BEFORE
    assert clearance(forest, x, y) > 0.08


def test_a_start_in_a_pipe_is_refused() -> None:
    forest = forest_of("open", np.random.default_rng(0))
    x, y = forest.place[4]
    with pytest.raises(ParameterError, match=r"--start: .* a pipe's surface is -0\.025 m away"):
        start_of(forest, np.random.default_rng(1), 0.08, (float(x), float(y)))


def test_another_forest_is_refused() -> None:
    with pytest.raises(ParameterError, match="--forest: wood, must be corridor, open or dense"):
        forest_of("wood", np.random.default_rng(0))
