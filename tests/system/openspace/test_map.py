"""Forests are planted, read and sorted into cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from circuits.errors import DataError, ParameterError
from system.openspace.map import CELL, SIDE, SPACING, Forest, cells_of, clearance, densest, plant, read_forest
from tests.refusals import file_refusals


def torus_distances(place: np.ndarray) -> np.ndarray:
    apart = np.abs(place[:, None] - place[None])
    apart = np.minimum(apart, SIDE - apart)
    found: np.ndarray = np.hypot(apart[..., 0], apart[..., 1]) + SIDE * np.eye(len(place))
    return found


@pytest.mark.parametrize("obstacles", [1, 500, 1700])
def test_no_two_obstacles_are_nearer_than_the_spacing(obstacles: int) -> None:
    forest = plant(obstacles, np.random.default_rng(3))
    assert forest.place.shape == (obstacles, 2)
    assert forest.place.min() >= 0.0
    assert forest.place.max() < SIDE
    assert torus_distances(forest.place).min() >= SPACING


def test_a_seed_is_a_forest() -> None:
    first, again, other = (plant(700, np.random.default_rng(s)).place for s in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_obstacles_are_spread_evenly() -> None:
    # over 40 forests of 500 obstacles each quarter holds 5000 +- 61 (binomial); placing them apart lowers it
    place = np.concatenate([plant(500, np.random.default_rng(s)).place for s in range(40)])
    quarters = np.histogram2d(*place.T, bins=2, range=[[0, SIDE], [0, SIDE]])[0]
    assert np.abs(quarters - 5000).max() < 4 * 61


@pytest.mark.parametrize("obstacles", [densest() + 1, densest() - 1])
def test_too_dense_a_forest_is_refused(obstacles: int) -> None:
    with pytest.raises(ParameterError, match=f"obstacles: {obstacles}, must fit 50 x 50 m"):
        plant(obstacles, np.random.default_rng(0))


def test_what_the_error_says_can_be_placed() -> None:
    assert len(plant(int(0.9 * densest()), np.random.default_rng(0)).place) == int(0.9 * densest())


@pytest.mark.parametrize(("x", "y"), [(0.2, 0.3), (49.9, 25.0), (25.0, 49.99), (0.0, 49.999)])
def test_cells_hold_whatever_is_near(x: float, y: float) -> None:
    forest = plant(1400, np.random.default_rng(7))
    cells = cells_of(forest, 5.0)
    column, row = (int((v + cells.margin) / CELL) for v in (x, y))
    found = set()
    for r in range(row - 5, row + 6):
        for k in range(cells.begin[r, column - 5], cells.begin[r, column + 6]):
            if np.hypot(cells.x[k] - x, cells.y[k] - y) < 5.0:
                found.add(int(cells.number[k]))
    apart = np.abs(forest.place - np.array([x, y]))
    apart = np.minimum(apart, SIDE - apart)
    assert found == set(np.flatnonzero(np.hypot(*apart.T) < 5.0).tolist())


def test_clearance_reaches_round_the_torus() -> None:
    forest = Forest("one", np.array([[49.0, 1.0]]))
    assert clearance(forest, 1.0, 49.0) == pytest.approx(np.sqrt(8.0))


def test_a_map_is_read(tmp_path: Path) -> None:
    path = tmp_path / "wood.csv"
    path.write_text("x_m, y_m\n1, 2.5\n\n0,49.9\n")
    forest = read_forest(str(path))
    assert forest.name == "wood"
    assert forest.place.tolist() == [[1.0, 2.5], [0.0, 49.9]]


test_what_is_no_map_is_refused = file_refusals(
    DataError,
    "wood.csv",
    read_forest,
    [
        ("", ":1: header: 'empty file'"),
        ("1,2\n", ":1: header: '1', must be a known column; the first line must be x_m,y_m"),
        ("x_m,y_m\n", "must have at least one row"),
        ("x_m,y_m\n1,two\n", ":2: y_m: 'two', must be a number"),
        ("x_m,y_m\n1,2,3\n", ":2: row: '3 cells', must have 2"),
        ("x_m,y_m\n1,nan\n", ":2: y_m: 'nan', must be a finite number"),
        ("x_m,y_m\n1,2\n50,2\n", ":3: x_m: 50 m, must be >= 0 and < 50"),
        ('x_m,y_m\n"1,2\n', "must be CSV"),
    ],
)


def test_bytes_and_folders_are_no_maps(tmp_path: Path) -> None:
    path = tmp_path / "wood.csv"
    path.write_bytes(b"\xff\xfe\x00")
    for name in (path, tmp_path, tmp_path / "none.csv"):
        with pytest.raises(DataError, match=r"not UTF-8|must be a readable file"):
            read_forest(str(name))
