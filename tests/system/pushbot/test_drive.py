"""Body, sensor, link and collisions together."""

from __future__ import annotations

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.pushbot.body import Pushbot, forward_of
from system.pushbot.drive import Order, Run, begin_run, drive, go_on, steer
from system.worlds.arena.file import load_scene
from system.worlds.camera.event import joined


def begun(scene: str = "single-block", *, seed: int = 1, **numbers: float) -> Run:
    return begin_run(load_scene(scene, seed=seed), seed=seed, die=Die(number=1003), robot=Pushbot(**numbers))


def test_a_straight_drive_goes_as_far_as_its_motors_let_it() -> None:
    run = begun()
    drive(run, [Order(1.0, 0.35)])
    # command after 8 ms, seen at the second step, 10 ms; then the lag of 50 ms costs its length once
    assert run.pose[0] - 0.4 == pytest.approx(0.35 * (1.0 - 0.01 - 0.05), rel=1e-3)
    assert run.pose[1:] == pytest.approx((1.0, 0.0))
    assert run.time == pytest.approx(1.0)
    assert len(run.path) == 201


def test_it_stops_where_it_touches() -> None:
    run = begun()
    frames = drive(run, [Order(4.0, 0.5)])
    assert run.touched == "block[0]"
    # chassis 5 cm before the middle, block 1.25 cm before its own; a step is 2.5 mm
    assert run.pose[0] == pytest.approx(1.4 - 0.0125 - 0.05, abs=2.6e-3)
    assert len(frames) < 80
    assert len(go_on(run, 0.05).events) == 0
    assert run.path[-1][0] == pytest.approx(run.time)
    assert run.path[-1][1:] == pytest.approx(run.pose)


def test_the_wall_is_touched_too() -> None:
    run = begun("target")
    drive(run, [Order(1.0, 0.0, -1.5), Order(3.0, 0.6)])
    assert run.touched == "wall"


def test_a_run_is_its_seed() -> None:
    runs = [joined(drive(begun(seed=s), [Order(0.5, 0.35)])) for s in (1, 1, 2)]
    assert len(runs[0]) > 0
    assert np.array_equal(runs[0].time, runs[1].time)
    assert not np.array_equal(runs[0].time, runs[2].time)


def test_windows_do_not_change_the_run() -> None:
    runs = [joined(drive(begun(), [Order(0.5, 0.35, 0.5)], window)) for window in (0.05, 0.5)]
    assert np.array_equal(runs[0].time, runs[1].time)


def test_the_gyro_follows_the_turn_every_eight_milliseconds() -> None:
    run = begun(lag=0.0)
    drive(run, [Order(0.5, 0.0, 1.0)])
    turned = (run.path[-1][3] - run.path[-2][3]) / 5e-3
    samples = go_on(run, 0.2).gyro
    assert len(samples) == 25
    assert np.diff(samples[:, 0]) == pytest.approx(8e-3)
    assert samples[:, 1].mean() == pytest.approx(turned, abs=4.0 * 0.002 / 5.0)


def test_only_commands_that_arrived_count() -> None:
    run = begun(latency=0.05, lag=0.0)
    steer(run, forward_of(run.robot, 0.4), 0.0)
    go_on(run, 0.05)
    assert run.pose[0] == 0.4
    go_on(run, 0.05)
    assert run.pose[0] == pytest.approx(0.42)


def test_bad_durations_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"^duration: 0.003 s, must be a whole number of sensor steps"):
        go_on(begun(), 0.003)
    with pytest.raises(
        ParameterError, match=r"^script\[1\]\.duration: 0.07 s, must be a whole number of 0.05 s"
    ):
        drive(begun(), [Order(0.05, 0.1), Order(0.07, 0.1)])
