"""World of the Bug robot: polygons of a map, and the pieces of outline near a place."""

from __future__ import annotations

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.bug.map import MAPS, load_map, read_map
from system.bug.world import PIECE, World, build_world, check_place, corners

BLOCK = "S    G\n      \n  ##  \n  ##  \n      \n"
CORNER = "S  \n # \n#  \n  G\n"


@pytest.fixture(scope="module", params=MAPS)
def world(request: pytest.FixtureRequest) -> World:
    return build_world(load_map(request.param))


def test_walls_have_the_area_of_their_cells(world: World) -> None:
    m = world.map
    frame = (m.width + 2.0) * (m.height + 2.0) - m.width * m.height
    # seals add at most 4e-6 each
    assert world.obstacles.area == pytest.approx(m.walls.sum() + frame, abs=1e-4)


def test_pieces_are_short_and_make_the_whole_outline(world: World) -> None:
    length = np.hypot(*(world.pieces[:, 2:] - world.pieces[:, :2]).T)
    assert length.max() <= PIECE * (1.0 + 1e-12)
    assert length.sum() == pytest.approx(world.obstacles.length)


def test_no_near_piece_is_missed(world: World) -> None:
    random, reach = np.random.default_rng(0), 1.3
    for _ in range(20):
        place = random.uniform((0.0, 0.0), (world.map.width, world.map.height))
        found = {tuple(p) for p in world.near((place[0], place[1]), reach)}
        near = world.pieces[_distance(world.pieces, place) < reach]
        assert {tuple(p) for p in near} <= found


def _distance(pieces: F64, place: F64) -> F64:
    along = pieces[:, 2:] - pieces[:, :2]
    share = ((place - pieces[:, :2]) * along).sum(axis=1) / (along**2).sum(axis=1)
    nearest = pieces[:, :2] + share.clip(0.0, 1.0)[:, None] * along
    return np.asarray(np.hypot(*(place - nearest).T))


def test_corners_are_those_that_paths_turn_at() -> None:
    found = corners(build_world(read_map(BLOCK, "block")))
    assert sorted(map(tuple, found.tolist())) == [(2.0, 1.0), (2.0, 3.0), (4.0, 1.0), (4.0, 3.0)]


def test_nothing_passes_between_walls_that_touch() -> None:
    assert build_world(read_map(CORNER, "corner")).clearance((1.0, 2.0)) == 0.0


def test_a_robot_must_fit() -> None:
    world = build_world(read_map(BLOCK, "block"))
    check_place(world, (1.85, 2.0), 0.15, "start")
    with pytest.raises(ParameterError, match=r"start: 1.9,2, a wall is 0.1 away, must be at least"):
        check_place(world, (1.9, 2.0), 0.15, "start")
    with pytest.raises(ParameterError, match=r"a wall is 0 away"):
        check_place(world, (3.0, 2.0), 0.15, "start")
    with pytest.raises(ParameterError, match=r"goal: 9,2, must be in the map of 6 x 5"):
        check_place(world, (9.0, 2.0), 0.15, "goal")
