"""Maps of the Bug robot: what is read, and one line for whatever is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from circuits.errors import DataError, ParameterError, UnknownNameError
from system.bug.map import LARGEST, MAPS, load_map, pick, read_map
from system.bug.run import run
from system.bug.scenario import Scenario


def test_cells_and_places() -> None:
    found = read_map("S.G\n# S\n", "yard")
    assert found.walls.tolist() == [[False, False, False], [True, False, False]]
    assert found.starts == ((0.5, 1.5), (2.5, 0.5))
    assert found.goals == ((2.5, 1.5),)
    assert (found.width, found.height) == (3.0, 2.0)
    assert found.diagonal == pytest.approx(13.0**0.5)


def test_short_lines_end_in_free_cells() -> None:
    assert read_map("S G###\n#\n", "yard").walls.sum() == 4


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_empty_lines_are_free_the_last_ones_too(ends: str) -> None:
    found = read_map(ends.join(("", "S#G", "", "", "")), "yard")
    assert found.walls.tolist() == [[False] * 3, [False, True, False], [False] * 3, [False] * 3]
    assert found.starts == ((0.5, 2.5),)


def test_a_way_round_the_end_of_a_wall_stays_open(tmp_path: Path) -> None:
    path = tmp_path / "yard.txt"
    path.write_text("S   #   G\n    #\n    #\n\n\n", encoding="utf-8")
    trace = run(Scenario(agent="bug2", map=str(path)))
    assert trace.shortest is not None
    assert trace.reached


@pytest.mark.parametrize("name", MAPS)
def test_shipped_maps_have_both_ends(name: str) -> None:
    found = load_map(name)
    assert found.name == name
    assert found.starts
    assert found.goals


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "yard: no start"),
        ("G  \n", "yard: no start, must have at least one S"),
        ("S  \n", "yard: no goal, must have at least one G"),
        ("S G\n x\n", "yard:2: 'x', must be # (wall), S (start), G (goal) or free"),
        ("S G" + " " * LARGEST + "#", f"yard: 1 lines of {LARGEST + 4} cells, must be at most {LARGEST}"),
    ],
)
def test_what_is_no_map_is_one_line(text: str, says: str) -> None:
    with pytest.raises(DataError) as caught:
        read_map(text, "yard")
    assert str(caught.value).startswith(says)
    assert "\n" not in str(caught.value)


def test_files(tmp_path: Path) -> None:
    (tmp_path / "yard.txt").write_text("S G\n", encoding="utf-8")
    assert load_map(str(tmp_path / "yard.txt")).name == "yard"
    (tmp_path / "picture.png").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(DataError, match="is not UTF-8, must be a map"):
        load_map(str(tmp_path / "picture.png"))
    with pytest.raises(DataError, match="must be a readable file"):
        load_map(str(tmp_path / "none.txt"))
    with pytest.raises(UnknownNameError, match="did you mean bug-cup"):
        load_map("bug-cap")


def test_places_by_number_and_by_coordinates() -> None:
    points = ((0.5, 0.5), (2.5, 0.5))
    assert pick(points, "1", "start") == (2.5, 0.5)
    assert pick(points, "1.25,3", "start") == (1.25, 3.0)


@pytest.mark.parametrize("text", ["2", "-1", "a", "1,b", "nan,1", ""])
def test_no_such_place(text: str) -> None:
    with pytest.raises(ParameterError, match=r"start: .*must be a number from 0 to 1.*or X,Y"):
        pick(((0.5, 0.5), (2.5, 0.5)), text, "start")
