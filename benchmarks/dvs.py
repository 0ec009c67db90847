"""Claim: sensor and renderer run at 30 times real time on one core while a robot drives straight.

A Pushbot drives at 0.35 m/s from each scene's start for 2 s, or until shortly before it touches something,
with all noise and mismatch on. By CPU time of the thread, the fastest of some turns; the peer is the time
simulated. Accuracy: how many events the way makes without noise, against a picture every 0.5 ms.

Rows for information, without a claim: turning by 1 rad/s, pictures alone, and the whole body with link, gyro
and collisions.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from _report import Row, parser_of, report
from circuits.silicon.die import Die
from system.pushbot.body import forward_of
from system.pushbot.drive import begin_run, go_on, steer
from system.worlds.arena.file import load_scene, scene_names
from system.worlds.arena.geometry import collision, obstacles_of
from system.worlds.arena.scene import Scene
from system.worlds.camera.render import render
from system.worlds.camera.sensor import Dvs, Segment, advance, open_eye, sensor_of

SPEED, LONGEST, CHUNK = 0.35, 2.0, 0.05  # m/s, s, s
CLAIM = 30.0
DIE, SEED = Die(number=1000), 1000
QUIET = Dvs(noise=0.0, leak=0.0, hot_share=0.0)


def main() -> int:
    """Measure and print all rows."""
    parser = parser_of(__doc__, "fewer turns, three scenes")
    options = parser.parse_args()
    names = ["single-block", "clutter", "office"] if options.quick else scene_names()
    turns = 2 if options.quick else 5
    rows = [row for name in names for row in of_scene(load_scene(name, seed=SEED), turns)]
    rows.append(whole_body(load_scene("single-block"), turns))
    return report(rows, options, lambda row: f"{row.ours:8.4f} s, {row.ratio:6.1f} times real time")


def of_scene(scene: Scene, turns: int) -> list[Row]:
    """Driving straight and turning in a scene."""
    long = free_way(scene)
    straight = fastest(lambda: watched(scene, Dvs(), long, SPEED, 0.0)[0], turns)
    counts = [watched(scene, replace(QUIET, step=step), long, SPEED, 0.0)[1] for step in (QUIET.step, 5e-4)]
    off = 100.0 * (counts[0] / counts[1] - 1.0)
    note = f"{counts[0]} events without noise, {off:+.2f} % of those with a picture every 0.5 ms"
    turning = fastest(lambda: watched(scene, Dvs(), 1.0, 0.0, 1.0)[0], turns)
    sensor = sensor_of(Dvs(), scene, DIE)
    eye = open_eye(sensor, SEED, scene.start)
    drawn = fastest(
        lambda: cpu(
            lambda: [render(sensor.stage, sensor.camera, eye.sketch, *scene.start) for _ in range(100)]
        ),
        turns,
    )
    rate = 100 * Dvs().step
    return [
        Row(f"{scene.name}, straight", straight, long, long / straight, note, least=CLAIM),
        Row(f"{scene.name}, turning by 1 rad/s", turning, 1.0, 1.0 / turning, "as above"),
        Row(f"{scene.name}, pictures alone", drawn, rate, rate / drawn, f"{1e4 * drawn:.3g} us a picture"),
    ]


def whole_body(scene: Scene, turns: int) -> Row:
    """With body, link, gyro and collisions, in windows of 50 ms."""
    long = free_way(scene)

    def once() -> float:
        run = begin_run(scene, seed=SEED, die=DIE)
        steer(run, forward_of(run.robot, SPEED), 0.0)
        return cpu(lambda: [go_on(run, CHUNK) for _ in range(round(long / CHUNK))])

    taken = fastest(once, turns)
    return Row(f"{scene.name}, whole body, straight", taken, long, long / taken, "windows of 50 ms")


def free_way(scene: Scene) -> float:
    """Seconds (whole chunks) that a robot drives straight before it touches something, at most `LONGEST`."""
    obstacles = obstacles_of(scene)
    x, y, heading = scene.start
    for k in range(1, round(LONGEST / CHUNK) + 1):
        gone = SPEED * k * CHUNK
        if collision(obstacles, (x + gone * np.cos(heading), y + gone * np.sin(heading), heading), k * CHUNK):
            return (k - 1) * CHUNK
    return LONGEST


def watched(scene: Scene, dvs: Dvs, long: float, speed: float, turn: float) -> tuple[float, int]:
    """CPU seconds of watching the way, and its events."""
    sensor = sensor_of(dvs, scene, DIE)
    eye = open_eye(sensor, SEED, scene.start)
    count = 0

    def go() -> None:
        nonlocal count
        for _ in range(round(long / CHUNK)):
            count += len(advance(sensor, eye, Segment(CHUNK, speed, turn)))

    return cpu(go), count


def fastest(once: Callable[[], float], turns: int) -> float:
    """Least of several turns, after one that compiles."""
    once()
    return min(once() for _ in range(turns))


def cpu(work: Callable[[], object]) -> float:
    """CPU seconds of this thread."""
    start = time.thread_time()
    work()
    return time.thread_time() - start


if __name__ == "__main__":
    sys.exit(main())
