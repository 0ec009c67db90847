"""Scenes: those that come along, what a file may say, and what is refused in one line."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import is_dataclass
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from circuits.errors import CircuitError, DataError, ParameterError, UnknownNameError
from system.option import settings
from system.worlds.arena import file
from system.worlds.arena.file import load_scene, scene_names
from system.worlds.arena.geometry import collision, obstacles_of
from system.worlds.arena.scene import COLOURS, LIGHTS, Motion, Tape, recoloured
from system.worlds.arena.tables import SceneTable

NAMED = {
    "single-block", "pair", "triple", "triple-loose", "clutter", "moving", "office", "target", "chase",
    "obstacle-against-target",
}  # fmt: skip
FREE = "start = { at = [0.5, 0.5] }\n[arena]\nsize = [2, 1]\n"


def written(tmp_path: Path, text: str) -> str:
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_the_scenes_of_the_paper_are_there() -> None:
    assert set(scene_names()) == NAMED


@pytest.mark.parametrize("name", sorted(NAMED))
def test_a_scene_loads_in_every_light(name: str) -> None:
    for light, lux in LIGHTS.items():
        scene = load_scene(name, seed=1000, light=light)
        assert scene.light == lux
        assert scene.summary


def test_a_light_in_lux() -> None:
    assert load_scene("pair", light="500lux").light == 500.0
    with pytest.raises(DataError, match="write as in 500lux"):
        load_scene("pair", light="500")


def test_clutter_is_its_seed() -> None:
    first, again, other = (load_scene("clutter", seed=s) for s in (1, 1, 2))
    assert first == again
    assert first != other


def test_clutter_has_eight_to_twelve_blocks_apart_and_away_from_the_start() -> None:
    counts = set()
    for seed in range(12):
        scene = load_scene("clutter", seed=seed)
        at = np.array([b.at for b in scene.bodies])
        counts.add(len(at))
        apart = np.hypot(*(at[:, None] - at[None]).T) + 9.0 * np.eye(len(at))
        assert apart.min() >= 0.35
        assert np.hypot(*(at - scene.start[:2]).T).min() >= 0.6
    assert counts <= set(range(8, 13))
    assert len(counts) > 1


def test_blocks_can_have_another_colour() -> None:
    scene = recoloured(load_scene("target"), "red")
    assert scene.bodies[0].reflectance == COLOURS["grey"]
    assert recoloured(load_scene("pair"), "red").bodies[1].reflectance == COLOURS["red"]


def test_tracks_stand_beside_a_robot_s_body_and_not_beside_a_moving_one(tmp_path: Path) -> None:
    scene = load_scene("target")
    assert [b.name for b in scene.bodies] == ["robot[0]", "robot[0].left", "robot[0].right"]
    assert [b.led is None for b in scene.bodies] == [False, True, True]
    assert scene.bodies[1].at[1] - scene.bodies[2].at[1] == pytest.approx(0.08)
    path = tmp_path / "moving.toml"
    path.write_text(
        'start = { at = [0.4, 0.6] }\n[arena]\nsize = [3, 2]\n[[robot]]\nat = [1, 1]\ntracks = "black"\n'
        "motion = { path = [[1, 1], [2, 1]], speed = 0.1 }\n"
    )
    with pytest.raises(DataError, match=r"robot\[0\]\.tracks: 0.06, must not be given"):
        load_scene(str(path))


def test_a_file_is_read(tmp_path: Path) -> None:
    scene = load_scene(
        written(
            tmp_path,
            "light = 50\nstart = { at = [0.5, 0.5], heading_deg = 90 }\n"
            "[arena]\ncorners = [[0, 0], [2, 0], [0, 2]]\n"
            "tape = false\nroom = 0\n[[cup]]\nat = [1.2, 0.3]\ndiameter = 0.1\ncolour = 0.3\n"
            '[cup.motion]\npath = [[1.2, 0.3], [1, 0.3]]\nspeed = 0.2\nrepeat = "shuttle"\n',
        )
    )
    assert (scene.name, scene.light) == ("mine", 50.0)
    assert scene.start == (0.5, 0.5, pytest.approx(math.pi / 2))
    assert len(scene.walls) == 3
    (cup,) = scene.bodies
    assert (cup.size, cup.reflectance, cup.is_round) == ((0.1, 0.1), 0.3, True)
    assert cup.motion is not None
    assert cup.motion.repeat == "shuttle"


def test_walls_inside_are_seen_and_run_into(tmp_path: Path) -> None:
    wall = '[[wall]]\ncorners = [[1, 0], [1, 0.8], [1.5, 0.8]]\ncolour = "red"\n'
    scene = load_scene(written(tmp_path, "duration = 7\n" + FREE + "tape = false\nroom = 0\n" + wall))
    assert scene.duration == 7.0
    assert [(w.start, w.end, w.reflectance) for w in scene.walls[4:]] == [
        ((1.0, 0.0), (1.0, 0.8), COLOURS["red"]),
        ((1.0, 0.8), (1.5, 0.8), COLOURS["red"]),
    ]
    obstacles = obstacles_of(scene)
    assert collision(obstacles, (0.94, 0.5, 0.0), 0.0) is None
    assert collision(obstacles, (0.96, 0.5, 0.0), 0.0) == "wall[0]"
    assert collision(obstacles, (1.3, 0.9, 0.0), 0.0) is None
    assert collision(obstacles, (1.3, 0.96, 0.0), 0.0) == "wall"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "start: missing, must be given"),
        ("start = 3", r"mine.toml: start: 3, must be a table"),
        ("a = = 1", "must be TOML"),
        (FREE.replace("size", "sise"), r"arena.sise: unknown key; did you mean size\?"),
        ("walls = 1\n" + FREE, r"walls: unknown key; did you mean wall\?"),
        ("pillars = 1\n" + FREE, "pillars: unknown key; known are summary"),
        ("duration = 0\n" + FREE, "duration: 0 s, must be > 0 and finite"),
        (
            FREE + "[[wall]]\ncorners = [[1, 0.2]]",
            r"wall\[0\].corners: \[\[1, 0.2\]\], must be a list of at least 2",
        ),
        (
            FREE + "[[wall]]\ncorners = [[1, 0.2], [1, 3]]",
            r"wall\[0\].corners\[1\]: \[1, 3\] m, must be inside",
        ),
        (FREE + "[[wall]]\ncorners = [[1, 0], [1, 0]]", r"wall\[0\].corners\[1\]: .*, must not be the one"),
        (FREE + "[[wall]]\ncorners = [[0.5, 0.2], [0.5, 0.9]]", r"the robot is in wall\[0\], must be free"),
        (
            FREE + "[[wall]]\ncorners = [[1, 0.2], [1, 0.8]]\nheight = 0.05",
            r"wall\[0\].tape.high: 0.06 m, must not be above height, 0.05 m",
        ),
        (FREE + "corners = [[0, 0], [1, 0], [1, 1]]", "arena: must have either size"),
        (FREE + "[[block]]\nat = [1, 0.5]", r"block\[0\].size: missing"),
        (
            FREE + "[[block]]\nat = [1]\nsize = [1, 1]\nheight = 1",
            r"block\[0\].at: \[1\], must be two numbers",
        ),
        (FREE + '[[cup]]\nat = [1, 0.5]\ncolour = "mauve"', r"cup\[0\].colour: mauve, must be one of white"),
        (FREE + "[[cup]]\nat = [1, 0.5]\nheight = 0", r"cup\[0\].height: 0 m, must be > 0 and finite"),
        (FREE + "[[cup]]\nat = [1, 0.5]\nheight = nan", r"cup\[0\].height: nan m, must be > 0 and finite"),
        (FREE + "[[cup]]\nat = [1, true]", r"cup\[0\].at\[1\]: True, must be a number"),
        (FREE + "[[cup]]\nat = [1.99, 0.5]", r"cup\[0\].at: \[1.99, 0.5\] m, must be inside the arena"),
        (FREE + "[[cup]]\nat = [-3, 0.5]", r"cup\[0\].at: \[-3, 0.5\] m, must be inside the arena"),
        (
            FREE + "[[cup]]\nat = [0.58, 0.5]",
            r"start.at: \[0.5, 0.5\] m, the robot is in cup\[0\], must be free",
        ),
        (FREE.replace("[0.5, 0.5]", "[1.97, 0.5]"), "the robot is outside the arena or in its wall"),
        (FREE.replace("[0.5, 0.5]", "[5, 0.5]"), "the robot is outside the arena or in its wall"),
        (FREE + "[cup]\nat = [1, 0.5]", r"cup: must be written as \[\[cup\]\]"),
        (
            FREE + "[[cup]]\nat = [1, 0.5]\nmotion = { path = [[1, 0.5], [1, 3]], speed = 1 }",
            r"cup\[0\].motion.path\[1\]: \[1, 3\] m, must be inside",
        ),
        (
            FREE + "[[cup]]\nat = [1, 0.5]\nmotion = { path = [[1, 0.5], [1, 0.5]], speed = 1 }",
            r"cup\[0\].motion.path: \(1.0, 0.5\), must lead somewhere",
        ),
        (
            FREE + "[[cup]]\nat = [1, 0.5]\nmotion = { path = [[1, 0.5], [1, 0.6]], speed = 0 }",
            r"cup\[0\].motion.speed: 0 m/s, must be > 0 and finite",
        ),
        (
            FREE
            + '[[cup]]\nat = [1, 0.5]\nmotion = { path = [[1, 0.5], [1, 0.6]], speed = 1, repeat = "no" }',
            r"cup\[0\].motion.repeat: no, must be stop, shuttle or loop",
        ),
        (FREE + "[clutter]\ncount = 400", "clutter.count: 400, must find room"),
        (FREE + "[clutter]\ncount = [3, 2]", r"clutter.count: \[3, 2\], must be a number of at least 1"),
        (FREE + "tape = { low = 0.2, high = 0.1 }", "arena.tape.low: 0.2 m, must be below high"),
        (FREE + "tape = { high = 0.3 }", "arena.tape.high: 0.3 m, must not be above wall_height"),
        ('light = "dim"\n' + FREE, "light: dim, must be normal"),
        ("light = 0\n" + FREE, "light: 0 lux, must be > 0 and finite"),
        (
            FREE + "[[shade]]\ncorners = [[0, 0], [1, 0], [0.1, 0.1], [0, 1]]\nfactor = 0.5",
            r"shade\[0\].corners: not convex",
        ),
        (
            FREE.replace("size = [2, 1]", "corners = [[0, 0], [2, 1], [2, 0], [0, 1]]"),
            "arena.corners: they cross",
        ),
    ],
)
def test_what_is_no_scene_is_refused(text: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=says) as caught:
        load_scene(written(tmp_path, text))
    assert str(caught.value).count("\n") == 0
    assert "mine.toml" in str(caught.value)


def keys(kind: type) -> Iterator[str]:
    """Keys of a table and of all tables in it."""
    for name, one in settings(kind).items():
        yield name
        for inner in (one.kind, *get_args(one.kind)):
            if is_dataclass(inner) and isinstance(inner, type):
                yield from keys(inner)


@pytest.mark.parametrize("key", sorted(set(keys(SceneTable))))
def test_every_key_is_described(key: str) -> None:
    assert re.search(rf"\b{key}\b", file.__doc__ or "")


def test_the_same_limits_hold_in_python() -> None:
    with pytest.raises(ParameterError, match=r"^low: 0.2 m, must be below high, 0.1 m$"):
        Tape(low=0.2, high=0.1)
    with pytest.raises(ParameterError, match=r"^speed: 0 m/s, must be > 0 and finite$"):
        Motion(((0.0, 0.0), (1.0, 0.0)), 0.0)


def test_other_names_and_files_are_refused(tmp_path: Path) -> None:
    told = r"scene blocks: unknown; .*known are chase, [^;]*triple-loose; or a file as own\.toml$"
    with pytest.raises(UnknownNameError, match=told):
        load_scene("blocks")
    for name in (tmp_path / "none.toml", tmp_path):
        with pytest.raises(CircuitError):
            load_scene(f"{name}.toml" if name == tmp_path else str(name))
    with pytest.raises(DataError, match="light: dusk, must be"):
        load_scene("pair", light="dusk")
