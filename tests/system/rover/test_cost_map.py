"""Maps from text: what is read, what is refused in one line, and the shipped maps' descriptions."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from circuits.errors import CircuitError, DataError, ParameterError, UnknownNameError
from system.rover.cost_map import (
    CELL_SIZE,
    MAPS,
    MAX_COST,
    CostMap,
    check_cell,
    check_codes,
    for_need,
    in_bounds,
    load_map,
    random_pairs,
    read_map,
)

ROUTE_ENDS = ((2, 10), (19, 10), (10, 10), (5, 3), (16, 3), (15, 16))  # Hwu et al. 2018, Table II
DESCRIBED = {  # costs that section II.E names for each map
    "map1-without-road": {3, 9},
    "map1-road": {1, 3, 9},
    "map1-road-obstacles": {1, 3, 6, 9},
    "map2": {1, 2, 6, 10},
}


@pytest.mark.parametrize("name", MAPS)
def test_shipped_maps_are_as_described(name: str) -> None:
    found = load_map(name)
    assert found.shape == (20, 20)
    assert set(np.unique(found.costs).tolist()) == DESCRIBED[name]
    # every route of the paper begins and ends on grass or road
    standing = {tuple(cell) for cell in in_bounds(found).tolist()}
    assert standing.issuperset(ROUTE_ENDS)
    assert found.cell_height == CELL_SIZE


def test_variants_of_map_1_differ_where_they_should() -> None:
    plain, road, obstacles = (load_map(n).costs for n in list(MAPS)[:3])
    assert set(plain[road != plain].tolist()) == {3}
    assert set(road[road != plain].tolist()) == {1}
    changed = obstacles != road
    assert set(road[changed].tolist()) == {3}
    assert set(obstacles[changed].tolist()) == {6}


def test_the_asphalt_of_map_2_roughly_follows_map_1s() -> None:
    one, two = (load_map(n).costs == 1 for n in ("map1-road", "map2"))
    near = np.array(
        [[two[max(r - 1, 0) : r + 2, max(c - 1, 0) : c + 2].any() for c in range(20)] for r in range(20)]
    )
    assert near[one].all()


def test_the_wheel_takes_the_maps_along() -> None:
    root = Path(__file__).parents[3]
    build = tomllib.loads((root / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert "system" in build["packages"]
    assert "exclude" not in build
    assert {p.stem for p in (root / "system" / "rover" / "maps").glob("*.txt")} == set(MAPS)


@pytest.mark.parametrize("text", ["1 2\n3 0\n", "1,2\n3,0", " 1, 2\n\n3 ,0\n\n", "1\t2\r\n3 0\r\n"])
def test_spaces_and_commas_read_alike(text: str) -> None:
    assert read_map(text, "x").tolist() == [[1, 2], [3, 0]]


@given(arrays(np.int64, st.tuples(st.integers(1, 6), st.integers(1, 6)), elements=st.integers(0, MAX_COST)))
def test_what_is_written_is_read(costs: np.ndarray) -> None:
    text = "\n".join(" ".join(map(str, row)) for row in costs.tolist())
    assert np.array_equal(read_map(text, "x"), costs)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("1 2\n\n3\n", "line 3 has 1 numbers, must be 2 as in line 1"),
        ("1 2 3\n1 2\n", "line 2 has 2 numbers"),
        ("1 x\n", 'line 1: "x", must be a whole number'),
        ("1 2.5\n", '"2.5", must be a whole number'),
        ("1,,2\n", 'line 1: "", must be a whole number'),
        ("1 nan\n", "must be a whole number"),
        ("1 -2\n", "-2, must be from 0 to 1000000"),
        ("1 2000000\n", "2000000, must be from 0"),
        ("1 " + "9" * 5000 + "\n", "must be from 0"),
        ("", "empty"),
        (" \n\n", "empty"),
    ],
)
def test_bad_text_is_refused_in_one_line(text: str, says: str) -> None:
    with pytest.raises(DataError) as caught:
        read_map(text, "m.txt")
    message = str(caught.value)
    assert message.startswith("m.txt: ")
    assert says in message
    assert "\n" not in message
    assert len(message) < 200


def test_files(tmp_path: Path) -> None:
    path = tmp_path / "yard.csv"
    path.write_bytes("\ufeff1,2\n3,4\n".encode())
    found = load_map(str(path))
    assert (found.name, found.costs.tolist()) == ("yard", [[1, 2], [3, 4]])
    path.write_bytes(b"\xff\xfe1")
    with pytest.raises(DataError, match="is not UTF-8, must be a map"):
        load_map(str(path))
    with pytest.raises(DataError, match="No such file or directory, must be a readable file"):
        load_map(str(tmp_path / "none.txt"))
    with pytest.raises(DataError, match="must be a readable file"):
        load_map(str(tmp_path))
    with pytest.raises(UnknownNameError, match="map2"):
        load_map("map3")


def test_cells_and_codes_are_checked() -> None:
    small = CostMap("small", np.array([[1, 0], [31, 32]]))
    check_cell(small, (0, 0), "start")
    for cell, says in (((2, 0), "must be in the map of 2 x 2"), ((0, -1), "must be in"), ((0, 1), "blocked")):
        with pytest.raises(ParameterError, match=rf"^start: {cell[0]},{cell[1]}, .*{says}"):
            check_cell(small, cell, "start")
    with pytest.raises(CircuitError, match=r"^small\[1,1\]: 32, must be at most 31"):
        check_codes(small)
    check_codes(CostMap("fits", np.array([[0, 31]])))


def test_needs() -> None:
    park = load_map("map1-road-obstacles")
    assert for_need(park, "energy") is park
    speed = for_need(park, "speed").costs
    assert set(speed[park.costs <= 3].tolist()) == {1}
    assert np.array_equal(speed[park.costs > 3], park.costs[park.costs > 3])
    with pytest.raises(ParameterError, match="need: rest, must be energy or speed"):
        for_need(park, "rest")


def test_random_pairs_are_in_bounds_and_apart() -> None:
    park = load_map("map2")
    pairs = random_pairs(park, 200, np.random.default_rng(0))
    assert pairs.shape == (200, 2, 2)
    assert np.hypot(*(pairs[:, 0] - pairs[:, 1]).T).min() > 5.0
    assert park.costs[pairs[..., 0], pairs[..., 1]].max() <= 2
    again = random_pairs(park, 200, np.random.default_rng(0))
    assert np.array_equal(pairs, again)


def test_a_map_too_small_for_pairs_is_refused() -> None:
    for costs in (np.ones((3, 3), dtype=np.int64), np.zeros((2, 2), dtype=np.int64)):
        with pytest.raises(ParameterError, match="must have pairs more than 5 cells apart"):
            random_pairs(CostMap("small", costs), 1, np.random.default_rng(0))
