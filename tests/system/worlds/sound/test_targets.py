"""Trajectories, the default scene and target files."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circuits.errors import DataError, ParameterError
from system.worlds.sound.targets import (
    MAX_SPEED,
    Approach,
    ConstantVelocity,
    Target,
    Waypoints,
    default_scene,
    describe,
    range_at,
    read_targets,
)

HEADER = "target,time_s,range_m\n"
WITH_STRENGTH = "target,time_s,range_m,strength\n"

ranges = st.floats(0.1, 20.0)
speeds = st.floats(0.01, 50.0)
times = st.floats(0.0, 1e3)


@given(ranges, speeds, times)
def test_constant_velocity_is_linear_in_time(start: float, velocity: float, time: float) -> None:
    # 1e-12: a few roundings of the sum.
    assert range_at(ConstantVelocity(start, velocity), time) == pytest.approx(
        start + velocity * time, rel=1e-12
    )


def test_constant_velocity_refuses_to_pass_through_the_head() -> None:
    with pytest.raises(ParameterError, match=r"-1 m at 5 s, must be > 0"):
        range_at(ConstantVelocity(4.0, -1.0), [3.0, 5.0])


@given(ranges, ranges, speeds, times)
def test_approach_moves_at_its_speed_and_then_rests(
    start: float, end: float, speed: float, time: float
) -> None:
    trajectory = Approach(start, end, speed)
    distance = float(range_at(trajectory, time))
    assert min(start, end) <= distance <= max(start, end)
    stop = abs(end - start) / speed
    if time > stop * (1.0 + 1e-9):
        assert distance == end
    elif time < stop:
        # 1e-9 m: roundings of sums of tens of metres.
        assert abs(distance - start) == pytest.approx(speed * time, abs=1e-9)


@given(ranges, st.floats(-5.0, 1e3))
def test_approach_without_way_to_go_rests(distance: float, time: float) -> None:
    assert range_at(Approach(distance, distance, 1.0), time) == distance


def test_waypoints_are_linear_between_and_held_outside() -> None:
    trajectory = Waypoints((1.0, 2.0, 4.0), (4.0, 3.0, 3.5))
    got = range_at(trajectory, [[0.0, 1.0, 1.5], [3.0, 4.0, 99.0]])
    np.testing.assert_allclose(got, [[4.0, 4.0, 3.5], [3.25, 3.5, 3.5]], rtol=1e-15)


@pytest.mark.parametrize(
    ("build", "text"),
    [
        (lambda: ConstantVelocity(0.0), "must be > 0"),
        (lambda: ConstantVelocity(1.0, float("nan")), "must be finite"),
        (lambda: ConstantVelocity(1.0, -2.0 * MAX_SPEED), "at most 100 m/s"),
        (lambda: Approach(1.0, -1.0, 1.0), "end_range_m: -1 m, must be > 0"),
        (lambda: Approach(1.0, 2.0, 0.0), "speed_m_per_s: 0 m/s, must be > 0"),
        (lambda: Waypoints((), ()), "at least one"),
        (lambda: Waypoints((0.0,), (1.0, 2.0)), "as many"),
        (lambda: Waypoints((0.0, 0.0), (1.0, 2.0)), "must be later"),
        (lambda: Waypoints((0.0, 1e-3), (1.0, 2.0)), "at most 100 m/s"),
        (lambda: Target(" ", ConstantVelocity(1.0)), "must not be blank"),
        (lambda: Target("moth", ConstantVelocity(1.0), 0.0), "moth.target_strength: 0, must be > 0"),
        (lambda: default_scene(clutter_gap=-1.0), "clutter_gap: -1 m, must be > 0"),
    ],
)
def test_bad_parameters_are_refused(build: Callable[[], object], text: str) -> None:
    with pytest.raises(ParameterError, match=text) as caught:
        build()
    assert "\n" not in str(caught.value)


def test_default_scene_closes_in_with_clutter_behind() -> None:
    target, clutter = default_scene()
    assert range_at(target.trajectory, 0.0) == 4.0
    assert range_at(target.trajectory, 3.5) == 0.5
    assert range_at(target.trajectory, 9.0) == 0.5
    when = np.linspace(0.0, 5.0, 11)
    gap = range_at(clutter.trajectory, when) - range_at(target.trajectory, when)
    np.testing.assert_allclose(gap, 1.0, rtol=1e-12)
    assert pickle.loads(pickle.dumps(target)) == target


def test_describe_says_that_the_last_range_is_held() -> None:
    moth = Target("moth", Waypoints((0.0, 2.0), (4.0, 3.0)))
    assert describe(moth) == "moth: 2 waypoints, held at 4 m before 0 s and at 3 m after 2 s, strength 1"
    assert "held at 0.5 m after 3.5 s" in describe(default_scene()[0])
    assert describe(Target("wall", ConstantVelocity(2.0, -0.5), 2.0)) == (
        "wall: 2 m at 0 s, -0.5 m/s, strength 2"
    )


def write(folder: Path, text: str) -> Path:
    path = folder / "targets.csv"
    path.write_text(text, encoding="utf-8", newline="")
    return path


def test_reads_targets_in_order_of_appearance(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "\ufeff" + WITH_STRENGTH + "wall,0,5,2\r\n\r\nmoth, 0 ,4,0.5\r\nwall,1,4.5,2.0\r\nmoth,2,3e0,.5\r\n",
    )
    assert read_targets(path) == (
        Target("wall", Waypoints((0.0, 1.0), (5.0, 4.5)), 2.0),
        Target("moth", Waypoints((0.0, 2.0), (4.0, 3.0)), 0.5),
    )


def test_columns_may_come_in_any_order_and_strength_may_be_absent(tmp_path: Path) -> None:
    path = write(tmp_path, "range_m,target,time_s\n4,moth,0\n")
    assert read_targets(path) == (Target("moth", Waypoints((0.0,), (4.0,)), 1.0),)


@given(
    st.lists(st.tuples(st.floats(0.5, 9.0), st.floats(0.5, 9.0)), min_size=1, max_size=8),
    st.floats(1e-3, 1e3),
)
@settings(deadline=None)  # writes files
def test_a_written_file_reads_back_the_same(
    tmp_path_factory: pytest.TempPathFactory, steps: list[tuple[float, float]], strength: float
) -> None:
    when = np.cumsum([step for step, _ in steps]).tolist()
    rows = [f"moth,{t!r},{r!r},{strength!r}\n" for t, (_, r) in zip(when, steps, strict=True)]
    path = write(tmp_path_factory.mktemp("targets"), WITH_STRENGTH + "".join(rows))
    waypoints = Waypoints(tuple(when), tuple(distance for _, distance in steps))
    assert read_targets(path) == (Target("moth", waypoints, strength),)


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", 1, "header: 'empty file'"),
        ("\n\n", 1, "header: 'empty file'"),
        (HEADER, 2, "must have at least one row"),
        ("target,time_s\nmoth,0\n", 1, "must have the column range_m"),
        ("target,time_s,range_m,time_s\n", 1, "header: 'time_s', must appear once"),
        ("target,time_s,range_m,colour\n", 1, "header: 'colour', must be a known column"),
        (HEADER + "moth,0\n", 2, "row: '2 cells', must have 3"),
        (HEADER + "moth,0,4,1\n", 2, "row: '4 cells', must have 3"),
        (HEADER + "moth,0,4\n" + HEADER, 3, "remove the second header"),
        (HEADER + ",0,4\n", 2, "target: '', must not be blank"),
        (HEADER + "moth,soon,4\n", 2, "time_s: 'soon', must be a number"),
        (HEADER + "moth,0,4 m\n", 2, "range_m: '4 m', must be a number"),
        (HEADER + "moth,0,\n", 2, "range_m: '', must be a number"),
        (HEADER + "moth,0,1_0\n", 2, "range_m: '1_0', must be a finite number"),
        (HEADER + "moth,nan,4\n", 2, "time_s: 'nan', must be a finite number"),
        (HEADER + "moth,0,inf\n", 2, "range_m: 'inf', must be a finite number"),
        (HEADER + "moth,0,1e999\n", 2, "range_m: '1e999', must be a finite number"),
        (HEADER + "moth,0,0\n", 2, "range_m: 0 m, must be > 0 and finite"),
        (HEADER + "moth,0,4\nmoth,1,-1\n", 3, "range_m: -1 m, must be > 0 and finite"),
        (HEADER + "moth,1,4\nwall,0,5\nmoth,1,4\n", 4, "time_s: '1', must be later than 1 s"),
        (HEADER + "moth,1,4\nmoth,0.5,4\n", 3, "time_s: '0.5', must be later than 1 s"),
        (HEADER + "moth,0,4\nmoth,0.001,5\n", 3, "must be reached at no more than 100 m/s"),
        (WITH_STRENGTH + "moth,0,4,1\nmoth,1,4,2\n", 3, "strength: '2', must be 1 as in the rows before"),
        (WITH_STRENGTH + "moth,0,4,0\n", 2, "strength: 0, must be > 0"),
        (WITH_STRENGTH + "moth,0,4,-1\n", 2, "strength: -1, must be > 0"),
        (WITH_STRENGTH + "moth,0,4,\n", 2, "strength: '', must be a number"),
        (HEADER + 'moth,0,"4\n', 2, "must be CSV"),
        (HEADER + "moth,0," + "9" * 200 + "x\n", 2, "9...', must be a number"),
        (HEADER + "moth,0," + "9" * 200_000 + "\n", 2, "must be CSV"),
        (HEADER + 'moth,0,"4\n5"\n', 3, "range_m: '4\\n5', must be a number"),
    ],
)
def test_bad_rows_are_named_on_one_line(tmp_path: Path, text: str, line: int, message: str) -> None:
    path = write(tmp_path, text)
    with pytest.raises(DataError) as caught:
        read_targets(path)
    said = str(caught.value)
    assert said.startswith(f"{path}:{line}: ")
    assert message in said
    assert "; " in said, "the remedy is missing"
    assert "\n" not in said
    assert len(said) < len(str(path)) + 220


@pytest.mark.parametrize(
    "junk", [b"\x89PNG\r\n\x1a\n\x00\x00", b"\x00\x01\x02", bytes(range(256)), b"\xff\xfe"]
)
def test_binary_junk_is_refused(tmp_path: Path, junk: bytes) -> None:
    path = tmp_path / "junk.csv"
    path.write_bytes(junk)
    with pytest.raises(DataError, match=r"junk\.csv:\d+: ") as caught:
        read_targets(path)
    assert str(caught.value).isprintable()


@given(st.binary(max_size=200))
@settings(deadline=None)  # writes files
def test_any_bytes_give_targets_or_a_data_error(
    tmp_path_factory: pytest.TempPathFactory, junk: bytes
) -> None:
    path = tmp_path_factory.mktemp("junk") / "junk.csv"
    path.write_bytes(HEADER.encode() + junk)
    try:
        targets = read_targets(path)
    except DataError as error:
        assert str(error).isprintable()  # noqa: PT017 - some bytes are rows
    else:
        assert targets


def test_missing_file_and_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="No such file or directory, must be a readable file"):
        read_targets(tmp_path / "absent.csv")
    with pytest.raises(DataError, match="Is a directory, must be a readable file"):
        read_targets(tmp_path)


def test_unreadable_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: Path) -> NoReturn:
        raise PermissionError(13, "Permission denied")

    path = write(tmp_path, HEADER + "moth,0,4\n")
    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(
        DataError, match="Permission denied, must be a readable file; check path and permissions"
    ):
        read_targets(path)
