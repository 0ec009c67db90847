"""A Pushbot in a scene: body, sensor, link and collisions together, step by step; and drives by a script.

A controller closes the loop:

    run = begin_run(scene, seed=1000, die=Die(number=1000))
    while run.touched is None and run.time < 20.0:
        readings = go_on(run, 0.05)                       events as they arrive, and the gyro
        steer(run, forward, turn)                       what equations (1) and (2) make of the spikes
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from system.pushbot.body import (
    Pushbot,
    Tracks,
    follow,
    forward_of,
    gyro,
    turn_of,
    wheel_commands,
    wheel_drives,
)
from system.pushbot.link import Link, carry, open_link, receive, send
from system.worlds.arena.geometry import Obstacles, collision, obstacles_of
from system.worlds.arena.motion import go_along_arc
from system.worlds.arena.scene import Scene
from system.worlds.camera.event import Events, joined
from system.worlds.camera.sensor import (
    Dvs,
    Eye,
    Segment,
    Sensor,
    advance_along,
    open_eye,
    sensor_of,
    steps_of,
)

Order = Segment  # a part of a script


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """What the sensors read in a stretch of time.

    Attributes
    ----------
    events : Events
        What the camera sent, in the order of time.
    gyro : array
        Samples of the gyro: time (s) and turn rate (rad/s), float64[samples, 2].
    """

    events: Events
    gyro: F64


@dataclass(slots=True, eq=False)
class Run:
    """A robot on its way through a scene.

    Attributes
    ----------
    scene : Scene
        The world that it drives in.
    robot : Pushbot
        Numbers of the body.
    sensor : Sensor
        The camera.
    eye : Eye
        State of the sensor.
    obstacles : Obstacles
        Outlines of what it can run into.
    link : Link
        Link to the controller.
    random : Generator
        What draws its noise.
    tracks : Tracks
        State of the motors.
    touched : str or None
        Name of what it has run into, where it then stays; None while it is free.
    next_gyro : float
        Time of the next sample of the gyro, s.
    lost : int
        How many events the sensor's bus had no room for.
    path : list of tuple of float
        Time (s), place (m, m) and heading (rad) at each sensor step.
    way : float
        Way that its middle has gone, m.
    """

    scene: Scene
    robot: Pushbot
    sensor: Sensor
    eye: Eye
    obstacles: Obstacles
    link: Link
    random: np.random.Generator
    tracks: Tracks = field(default_factory=Tracks)
    touched: str | None = None
    next_gyro: float = 0.0
    lost: int = 0
    way: float = 0.0
    path: list[tuple[float, float, float, float]] = field(default_factory=list)

    @property
    def time(self) -> float:
        """Time that both robot and sensor have reached, s."""
        return self.eye.time

    @property
    def pose(self) -> tuple[float, float, float]:
        """Where the robot is: m, m, rad."""
        x, y, heading = (float(v) for v in self.eye.pose)
        return x, y, heading


def begin_run(
    scene: Scene, *, seed: int, die: Die = NOMINAL, robot: Pushbot | None = None, dvs: Dvs | None = None
) -> Run:
    """Put a robot at the start of a scene.

    Parameters
    ----------
    scene
        The world.
    seed
        Seed of all noise.
    die
        Silicon of the sensor.
    robot
        Numbers of the body; the Pushbot's unless given.
    dvs
        Numbers of the sensor; the Pushbot's unless given.
    """
    sensor = sensor_of(dvs or Dvs(), scene, die)
    eye = open_eye(sensor, seed, scene.start)
    return Run(
        scene, robot or Pushbot(), sensor, eye, obstacles_of(scene), open_link(seed),
        np.random.default_rng((seed, 5)), path=[(0.0, *scene.start)],
    )  # fmt: skip


def steer(run: Run, forward: float, turn: float) -> None:
    """Send the robot of `run` a command; it takes effect after the link's latency.

    `forward` is v of the robot's code, cm/s; `turn` is its w, dimensionless, positive to the left.
    """
    send(run.robot, run.link, run.time, wheel_commands(run.robot, forward, turn))


def pull(run: Run, forward: float, turn: float) -> None:
    """Let a command drive the motors of `run` at once and as it is, without link and whole numbers.

    `forward` and `turn` are those of `steer`, cm/s and dimensionless.
    """
    left, right = wheel_drives(run.robot, forward, turn)
    run.tracks = replace(run.tracks, left_command=left, right_command=right)


def go_on(run: Run, duration: float) -> Readings:
    """Let the robot drive on, or until it touches something, and return what its sensors read.

    Parameters
    ----------
    run
        The robot on its way, which goes on in place.
    duration
        For how long, s: a whole number of sensor steps.

    Raises
    ------
    ParameterError
        The duration is no whole number of sensor steps.
    """
    ways = _way_ahead(run, steps_of(run.sensor.dvs, duration))
    events = joined([]) if len(ways) == 0 else advance_along(run.sensor, run.eye, ways)
    run.lost += events.lost
    turned: list[tuple[float, float]] = []
    while run.next_gyro <= run.time and len(ways) > 0:
        before = round((run.time - run.next_gyro) / run.sensor.dvs.step)
        rate = float(ways[max(len(ways) - 1 - before, 0), 1])
        turned.append((run.next_gyro, gyro(run.robot, rate, run.random)))
        run.next_gyro += run.robot.gyro_period
    return Readings(
        carry(run.robot, run.link, events, run.time), np.array(turned, dtype=float).reshape(-1, 2)
    )


def _way_ahead(run: Run, steps: int) -> F64:
    """Speed and turn rate of the next steps, float64[at most steps, 2], until the robot touches something."""
    step, pose, ways = run.sensor.dvs.step, run.eye.pose.copy(), np.zeros((steps, 2))
    for k in range(steps):
        if run.touched is not None:
            return ways[:k]
        run.tracks = receive(run.link, run.tracks, run.time + k * step)
        run.tracks, speed, turn = follow(run.robot, run.tracks, step)
        ways[k] = speed, turn
        run.way += abs(speed) * step
        go_along_arc(pose, speed, turn, step)
        at = run.time + (k + 1) * step
        here = float(pose[0]), float(pose[1]), float(pose[2])
        run.path.append((at, *here))
        run.touched = collision(run.obstacles, here, at)
    return ways


def drive(run: Run, script: Sequence[Order], window: float = 0.05) -> list[Events]:
    """Drive by a script, without a controller, and return the events of each window of time.

    `script` has the parts of the way of `run` in order; `window` is the length of a window, s. Raises
    `ParameterError` for a part that is no whole number of windows.
    """
    frames: list[Events] = []
    for k, order in enumerate(script):
        windows = round(order.duration / window)
        if windows < 1 or abs(windows * window - order.duration) > 1e-9:
            raise ParameterError(
                f"script[{k}].duration: {order.duration:g} s, must be a whole number of {window:g} s"
            )
        steer(run, forward_of(run.robot, order.speed), turn_of(run.robot, order.turn))
        for _ in range(windows):
            if run.touched is not None:
                return frames
            frames.append(go_on(run, window).events)
    return frames
