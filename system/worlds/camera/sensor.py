"""Dynamic vision sensor of 128 x 128 pixels that looks at a scene from a moving robot (Milde et al. 2017).

    sensor = sensor_of(Dvs(), scene, die)                    silicon and world
    eye = open_eye(sensor, seed, scene.start)                state, with the noise of `seed`
    events = advance(sensor, eye, Segment(0.1, speed, turn)) what it sees on the way; the state goes on

A segment is driven at constant speed and turn rate, an arc. The same die has the same thresholds whatever the
seed; the same seed on the same way gives the same events, however the way is cut into whole steps.

Sources: 128 x 128 and 60 degrees, the paper's section 2.2; thresholds, from the biases of the robot's code by
the formula of Nozaki & Delbruck 2018; spread of the thresholds, refractory period, noise in the dark and the
follower's bandwidth, v2e (defaults, and its noisy preset); link of 12 Mbit/s, the paper, with 6 bytes an
event, eDVS format E4. The rest is ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.compiled import compiled
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die, standard_normals
from system.numbers import check_numbers
from system.worlds.arena.motion import go_along_arc, place_bodies
from system.worlds.arena.scene import Scene
from system.worlds.camera.event import Bus, Events, in_order, read_out
from system.worlds.camera.expose import expose
from system.worlds.camera.lamp import Glow, find_lamps, no_glow
from system.worlds.camera.noise import SPARE
from system.worlds.camera.pixel import Beat, Memory, Pixels, Raw, raw_of, settle
from system.worlds.camera.project import Camera, Sketch, sketch_of
from system.worlds.camera.render import render
from system.worlds.camera.stage import Stage, darkest, stage_of

special = later("scipy.special")

_BUFFER = 1 << 17  # events of one call, more than any bus carries; those beyond count as lost
_LEAST_THRESHOLD = 0.01  # of log light; v2e's
_FROM_ZERO = (
    "threshold_sigma", "leak", "leak_sigma", "noise", "refractory", "hot_share", "hot_rate", "bus_depth",
)  # fmt: skip
_DECADE = math.log(10.0)
_compiled = compiled()


@dataclass(frozen=True, slots=True)
class Dvs:
    """The numbers of a dynamic vision sensor, in SI units.

    A threshold is a change of the natural logarithm of light, which is dimensionless. The module names the
    sources; what is not marked as the paper's, the robot's code's or v2e's is ours.

    Attributes
    ----------
    columns, rows : int
        How many pixels there are across and down; the paper's. `rows` is even.
    field : float
        Angle that the columns see together, rad; the paper's.
    height : float
        Height of the sensor above the floor, m: between the tracks' top and the LED.
    ahead : float
        Distance of the sensor before the robot's middle, m; negative behind it.
    blur : float
        Standard deviation of the picture of a point of light, in pixels: lens, focus, and carriers that
        diffuse.
    threshold_on : float
        Threshold of ON events, dimensionless; from the biases of the robot's code.
    threshold_off : float
        Threshold of OFF events, dimensionless; from the biases of the robot's code.
    threshold_sigma : float
        Standard deviation of a threshold from pixel to pixel, dimensionless; v2e's default.
    follower : float
        Bandwidth of a pixel in bright light, Hz; v2e's default.
    per_lux : float
        Bandwidth of a pixel for each lux that falls on it, Hz/lux: about 3 kHz at 1 klux.
    dark : float
        Light that the dark current counts as, lux.
    leak : float
        Rate of ON events of a pixel in still light, Hz; 0.05 to 0.1 is usual.
    leak_sigma : float
        Standard deviation of that rate from pixel to pixel, in decades; v2e's.
    noise : float
        Rate of noise events of a pixel in the dark, Hz; v2e's noisy preset.
    noise_lux : float
        Light on a pixel that halves its noise, lux.
    refractory : float
        Time that a pixel is silent after an event, s; v2e's default.
    hot_share : float
        Share of hot pixels, from 0 to below 1.
    hot_rate : float
        Rate of events of a hot pixel, Hz.
    bus_rate : float
        Events that the bus carries in a second, 1/s: 12 Mbit/s over a serial line with 6 bytes an event.
    bus_depth : int
        How many events wait for the bus at most.
    step : float
        Time between two pictures of the scene, s.
    pixels_a_step : float
        By how many pixels a picture may turn at most, before the time between pictures is made shorter.

    Raises
    ------
    ParameterError
        A number breaks its rule.
    """

    columns: int = 128
    rows: int = 128
    field: float = math.radians(60.0)
    height: float = 0.075
    ahead: float = 0.04
    blur: float = 0.8
    threshold_on: float = 0.242
    threshold_off: float = 0.211
    threshold_sigma: float = 0.03
    follower: float = 300.0
    per_lux: float = 3.0
    dark: float = 0.1
    leak: float = 0.05
    leak_sigma: float = 0.1
    noise: float = 5.0
    noise_lux: float = 0.5
    refractory: float = 5e-4
    hot_share: float = 2e-4
    hot_rate: float = 50.0
    bus_rate: float = 200e3
    bus_depth: int = 256
    step: float = 5e-3
    pixels_a_step: float = 1.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_numbers("dvs", self, from_zero=_FROM_ZERO, signed=("ahead",))
        if self.hot_share >= 1.0:
            raise ParameterError(f"dvs.hot_share: {self.hot_share:g}, must be from 0 to below 1")
        if not self.field < math.pi or self.rows % 2:
            raise ParameterError(
                f"dvs.field: {math.degrees(self.field):g} degrees, must be below 180, rows even"
            )


@dataclass(frozen=True, slots=True)
class Segment:
    """A stretch of way at constant speed and turn rate.

    duration : how long it takes, s.
    speed : speed ahead, m/s.
    turn : turn rate, counter-clockwise, rad/s.
    """

    duration: float
    speed: float = 0.0
    turn: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Sensor:
    """A sensor of a die before a scene.

    dvs : its numbers.
    stage : the scene as arrays.
    camera : its optics.
    pixels : the silicon of its pixels.
    """

    dvs: Dvs
    stage: Stage
    camera: Camera
    pixels: Pixels


@dataclass(slots=True, eq=False)
class Eye:
    """State of a sensor on its way, overwritten in place: pose (m, m, rad), pixels, and the bus.

    origin : time (s) at which it was opened, since which `steps` steps have passed.
    step : of the sensor, s.
    memory : what the pixels remember.
    sketch : the last picture.
    glow : pixels that lights fall on.
    raw : events of one call.
    random : what draws the noise.
    bus_free : when the bus is free again, float64[1], s.
    """

    origin: float
    step: float
    pose: F64
    memory: Memory
    sketch: Sketch
    glow: Glow
    raw: Raw
    random: np.random.Generator
    bus_free: F64
    steps: int = 0

    @property
    def time(self) -> float:
        """Time that it has reached, s; counted in steps, so that it is the same however they are grouped."""
        return self.origin + self.steps * self.step


def camera_of(dvs: Dvs) -> Camera:
    """Return the optics of a sensor."""
    focal = 0.5 * dvs.columns / math.tan(0.5 * dvs.field)
    return Camera(dvs.columns, dvs.rows, focal, dvs.height, dvs.ahead, dvs.blur)


def pixels_of(dvs: Dvs, die: Die = NOMINAL, least: float = 0.0) -> Pixels:
    """Silicon of a die: thresholds, leaks and hot pixels; all alike and none hot on the nominal die.

    least: lux below which no pixel of the scene is; noise is drawn for as much and then thinned.
    """
    count = dvs.columns * dvs.rows
    on, off, leak, hot = (_draws(dvs, die, name) for name in ("on", "off", "leak", "hot"))
    theta_on = np.maximum(dvs.threshold_on + dvs.threshold_sigma * on, _LEAST_THRESHOLD)
    is_hot = special.ndtr(hot) < dvs.hot_share if die.number is not None else np.zeros(count, dtype=np.bool_)
    return Pixels(
        on=theta_on,
        off=np.maximum(dvs.threshold_off + dvs.threshold_sigma * off, _LEAST_THRESHOLD),
        leak=dvs.leak * theta_on * np.exp(_DECADE * dvs.leak_sigma * leak),
        hot=np.flatnonzero(is_hot).astype(np.int64),
        dark=dvs.dark,
        follower=dvs.follower,
        per_lux=dvs.per_lux,
        refractory=dvs.refractory,
        noise=dvs.noise,
        noise_lux=dvs.noise_lux,
        noise_most=dvs.noise / (1.0 + least / dvs.noise_lux),
        nominal=0.5 * (dvs.threshold_on + dvs.threshold_off),
        hot_rate=dvs.hot_rate,
    )


def _draws(dvs: Dvs, die: Die, name: str) -> F64:
    if die.number is None or not die.mismatch:
        return np.zeros(dvs.columns * dvs.rows)
    return standard_normals(die, (("dvs", ()),), [(("pixel", (dvs.columns, dvs.rows)),)], name)


def sensor_of(dvs: Dvs, scene: Scene, die: Die = NOMINAL) -> Sensor:
    """Return the sensor with the numbers of `dvs`, on a die, before a scene."""
    stage = stage_of(scene)
    return Sensor(dvs, stage, camera_of(dvs), pixels_of(dvs, die, darkest(stage)))


def open_eye(sensor: Sensor, seed: int, pose: tuple[float, float, float], time: float = 0.0) -> Eye:
    """Return the state of a sensor, settled to what it sees.

    Parameters
    ----------
    sensor
        The sensor.
    seed
        Seed of its noise.
    pose
        Where it is: place (m, m) and heading (rad).
    time
        Time at which it is opened, s.
    """
    random, p = np.random.default_rng((seed, 3)), sensor.pixels
    count = sensor.dvs.columns * sensor.dvs.rows
    waits = random.exponential(1.0, 2)
    rates = np.array([SPARE * p.noise_most * count, p.hot_rate * len(p.hot)])
    first = np.divide(waits, rates, out=np.full(2, np.inf), where=rates > 0.0)
    memory = Memory(
        seen=np.zeros(count),
        level=np.zeros(count),
        filtered=np.zeros(count),
        kept=np.zeros(count),
        blind=np.zeros(count),
        is_lit=np.zeros(count, dtype=np.int64),
        leaked=np.zeros(sensor.dvs.columns),
        turn=np.zeros(1, dtype=np.int64),
        next_noise=time + first,
    )
    raw, glow = raw_of(count, _BUFFER), no_glow(sensor.dvs.rows)
    sketch = sketch_of(sensor.stage, sensor.camera)
    eye = Eye(time, sensor.dvs.step, np.array(pose), memory, sketch, glow, raw, random, np.array([-np.inf]))
    picture(sensor, eye)
    settle(p, memory, sketch.light, time)
    return eye


def picture(sensor: Sensor, eye: Eye) -> F64:
    """Intensity (lux) at the eye's pose and time, float64[rows, columns], row 0 at the bottom, lights off."""
    place_bodies(sensor.stage.motions, eye.time, eye.sketch.pose)
    render(sensor.stage, sensor.camera, eye.sketch, *(float(v) for v in eye.pose))
    return eye.sketch.light.reshape(sensor.dvs.columns, sensor.dvs.rows).T.copy()


def advance(sensor: Sensor, eye: Eye, segment: Segment) -> Events:
    """Return the events of `sensor` on a stretch of way; its state `eye` is overwritten by that at its end.

    Raises `ParameterError` where the duration of `segment` is no whole number of `Dvs.step`.
    """
    steps = steps_of(sensor.dvs, segment.duration)
    return advance_along(sensor, eye, np.tile((segment.speed, segment.turn), (steps, 1)))


def steps_of(dvs: Dvs, duration: float) -> int:
    """Steps of the sensor in a duration (s); raises `ParameterError` unless they are a whole number."""
    steps = round(duration / dvs.step)
    if steps < 1 or abs(steps * dvs.step - duration) > 1e-9:
        raise ParameterError(
            f"duration: {duration:g} s, must be a whole number of sensor steps, {dvs.step:g} s"
        )
    return steps


def advance_along(sensor: Sensor, eye: Eye, ways: F64) -> Events:
    """Events on steps of `Dvs.step`, each with its speed (m/s) and turn rate (rad/s), float64[steps, 2]."""
    dvs, raw = sensor.dvs, eye.raw
    raw.used[:] = 0
    world = World(sensor.stage, sensor.camera, sensor.pixels, eye.memory, eye.sketch, eye.glow, raw)
    _look(world, eye.pose, ways, Grid(eye.origin, eye.steps, dvs.step, dvs.pixels_a_step), eye.random)
    eye.steps += len(ways)
    count = int(raw.used[0])
    time, code = in_order(raw.time[:count], raw.code[:count])
    events = read_out(Bus(1.0 / dvs.bus_rate, dvs.bus_depth), dvs.rows, time, code, eye.bus_free)
    return events if raw.used[1] == 0 else replace(events, lost=events.lost + int(raw.used[1]))


class World(NamedTuple):
    """What one look of the compiled loop needs: sensor and state."""

    stage: Stage
    camera: Camera
    pixels: Pixels
    memory: Memory
    sketch: Sketch
    glow: Glow
    raw: Raw


class Grid(NamedTuple):
    """Steps of `step` s, the `first` so many after `origin` (s), each divided so that it turns little."""

    origin: float
    first: int
    step: float
    pixels_a_step: float


@_compiled
def _look(w: World, pose: F64, ways: F64, grid: Grid, random: np.random.Generator) -> None:
    """Go along the arcs step by step, and expose the pixels to what comes into view."""
    for k in range(ways.shape[0]):
        turned = abs(ways[k, 1]) * grid.step * w.camera.focal
        pieces = max(math.ceil(turned / grid.pixels_a_step), 1)
        step = grid.step / pieces
        for piece in range(pieces):
            start = grid.origin + (grid.first + k) * grid.step + piece * step
            go_along_arc(pose, ways[k, 0], ways[k, 1], step)
            place_bodies(w.stage.motions, start + step, w.sketch.pose)
            render(w.stage, w.camera, w.sketch, pose[0], pose[1], pose[2])
            find_lamps(w.stage, w.camera, w.sketch, w.glow, pose[0], pose[1], pose[2])
            expose(w.pixels, w.memory, w.sketch.light, w.glow, w.stage.lamp, Beat(start, step), random, w.raw)
