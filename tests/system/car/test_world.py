"""The three forests, and where a robot may start."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from circuits.errors import DataError, ParameterError
from system.car.world import (
    BEFORE,
    FORESTS,
    LEAST_WIDE,
    LONG,
    PIPES,
    SPACING,
    WIDE,
    clearance,
    forest_of,
    read_pipes,
    start_of,
)
from tests.refusals import file_refusals


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


@pytest.mark.parametrize("at", [(2.5, 0.0), (1.0, 0.5), (99.0, 0.0)])
def test_a_start_behind_the_forest_or_beside_it_is_refused(at: tuple[float, float]) -> None:
    forest = forest_of("corridor", np.random.default_rng(1))
    with pytest.raises(
        ParameterError, match=r"start: .* must be before the forest's end at 2\.4 m, and within"
    ):
        start_of(forest, np.random.default_rng(1), 0.08, at)


def test_a_start_in_a_pipe_is_refused() -> None:
    forest = forest_of("open", np.random.default_rng(0))
    x, y = forest.place[4]
    with pytest.raises(ParameterError, match=r"start: .* a pipe's surface is -0\.025 m away"):
        start_of(forest, np.random.default_rng(1), 0.08, (float(x), float(y)))


def test_another_forest_is_refused() -> None:
    with pytest.raises(ParameterError, match="forest: wood, must be corridor, open or dense"):
        forest_of("wood", np.random.default_rng(0))


def test_pipes_of_ones_own(tmp_path: Path) -> None:
    path = tmp_path / "own.csv"
    path.write_text("x_m,y_m\n0,0.4\n1.2,-0.7\n\n")
    forest = forest_of(str(path), np.random.default_rng(0))
    assert (forest.name, forest.long, forest.wide) == ("own", 1.2, 1.4)
    assert forest.place.tolist() == [[0.0, 0.4], [1.2, -0.7]]
    path.write_text("x_m,y_m\n0.5,0\n")
    assert read_pipes(str(path)).wide == LEAST_WIDE


test_what_is_no_forest_is_one_line = file_refusals(
    DataError,
    "own.csv",
    read_pipes,
    [
        ("", "own.csv:1: header: 'empty file', must have a header"),
        ("x_m,y_m\n", "own.csv:2: row: 'end of file', must have at least one row"),
        ("x_m,y_m\n0,a\n", "own.csv:2: y_m: 'a', must be a number"),
        (
            "x_m,y_m\n-1,0\n",
            "own.csv:2: x_m: -1 m, must be >= 0 and < 100; it is the place along the way through",
        ),
        ("x_m,y_m\n1,nan\n", "own.csv:2: y_m: 'nan', must be a finite number"),
    ],
)
