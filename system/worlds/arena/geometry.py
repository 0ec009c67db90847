"""Outlines of what stands in a scene, by shapely, and whether a robot touches any of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import affinity
from shapely.geometry import LineString, Polygon, box
from shapely.geometry import Point as Spot

from circuits.arrays import F64, Bools
from circuits.errors import ParameterError
from system.worlds.arena.furniture import ROBOT_HEIGHT, ROBOT_SIZE
from system.worlds.arena.motion import STRIDES, Motions, motions_of, place_bodies
from system.worlds.arena.scene import Body, Scene

Pose = tuple[float, float, float]  # m, m, rad

REACH = 0.5 * math.hypot(*ROBOT_SIZE)  # m from a robot's middle to its corners
_ROUNDING = 1e-6  # m


@dataclass(frozen=True, slots=True)
class Obstacles:
    """What a robot can run into: bodies that begin below its height, and the border of the floor.

    outlines: of each body about its own origin; radius: float64[bodies], m, about each whole body;
    solid: bool[bodies]; middle: part of the floor where no robot can touch the border; partitions: lines of
    walls inside; fastest: m/s, that no body exceeds but by jumps of less than `jump` (m), of legs that stop
    or turn; free: x and y (m), time (s) and m to the nearest thing where a robot was last looked for,
    overwritten in place.

    scene : whose they are.
    motions : paths of its bodies.
    """

    scene: Scene
    motions: Motions
    outlines: tuple[Polygon, ...]
    radius: F64
    solid: Bools
    floor: Polygon
    middle: Polygon
    partitions: tuple[LineString, ...]
    fastest: float
    jump: float
    free: list[float]


def obstacles_of(scene: Scene) -> Obstacles:
    """Return the outlines of a scene's bodies, and of its floor."""
    outlines = tuple(_outline(b) for b in scene.bodies)
    radius = np.array([0.5 * (b.size[0] if b.is_round else math.hypot(*b.size)) for b in scene.bodies])
    solid = np.array([b.base < ROBOT_HEIGHT for b in scene.bodies], dtype=np.bool_)
    floor = Polygon(scene.corners)
    middle = floor.buffer(-REACH)
    shapely.prepare(middle)
    motions = motions_of(scene.bodies)
    swing = float(np.abs(motions.swing).max(initial=0.0))
    fastest = float(motions.speed.max(initial=0.0)) + 2.0 * math.pi * STRIDES * swing
    nowhere = [0.0, 0.0, 0.0, -math.inf]
    inside = tuple(LineString(line) for line in scene.partitions)
    return Obstacles(
        scene, motions, outlines, radius, solid, floor, middle, inside, fastest, 2.0 * swing, nowhere
    )


def outline_at(obstacles: Obstacles, k: int, time: float) -> Polygon:
    """Outline of body k on the floor at `time` s."""
    return _moved(obstacles.outlines[k], _poses(obstacles, time)[k])


def collision(obstacles: Obstacles, pose: Pose, time: float) -> str | None:
    """Name of what a robot touches, or None where it is free.

    The name is `wall` for the border and `wall[k]` for a wall inside. Nothing is looked at as long as neither
    the robot nor any body can have come across what was free before.

    Parameters
    ----------
    obstacles
        What it can touch (`obstacles_of`).
    pose
        Place (m, m) of the robot and its heading (rad).
    time
        Time of the run, s.
    """
    x, y, then, apart = obstacles.free
    if math.hypot(pose[0] - x, pose[1] - y) + obstacles.fastest * abs(time - then) < apart:
        return None
    found = _collision(obstacles, pose, time)
    if found is None:
        obstacles.free[:] = [pose[0], pose[1], time, _room(obstacles, pose, time)]
    return found


def _room(obstacles: Obstacles, pose: Pose, time: float) -> float:
    """Metres that a robot and all bodies together may move before any can touch; less than 0 when near."""
    poses = _poses(obstacles, time)
    apart = np.hypot(poses[:, 0] - pose[0], poses[:, 1] - pose[1]) - obstacles.radius
    nearest = float(apart[obstacles.solid].min(initial=math.inf))
    spot = Spot(pose[0], pose[1])
    walls = (obstacles.floor.exterior, *obstacles.partitions)
    return min(nearest, *(float(w.distance(spot)) for w in walls)) - REACH - obstacles.jump - _ROUNDING


def _collision(obstacles: Obstacles, pose: Pose, time: float) -> str | None:
    if not shapely.contains_xy(obstacles.middle, pose[0], pose[1]) and not obstacles.floor.contains(
        robot_outline(pose)
    ):
        return "wall"
    for number, line in enumerate(obstacles.partitions):
        if line.intersects(robot_outline(pose)):
            return f"wall[{number}]"
    poses = _poses(obstacles, time)
    apart = np.hypot(poses[:, 0] - pose[0], poses[:, 1] - pose[1]) - obstacles.radius
    for k in np.flatnonzero(obstacles.solid & (apart < REACH)):
        if _moved(obstacles.outlines[k], poses[k]).intersects(robot_outline(pose)):
            return obstacles.scene.bodies[k].name
    return None


def clearance(obstacles: Obstacles, pose: Pose, time: float, name: str = "") -> float:
    """Distance (m) from a robot's outline to the nearest body whose name begins with `name`, else inf."""
    chassis, poses = robot_outline(pose), _poses(obstacles, time)
    found = [
        float(_moved(obstacles.outlines[k], poses[k]).distance(chassis))
        for k, body in enumerate(obstacles.scene.bodies)
        if obstacles.solid[k] and body.name.startswith(name)
    ]
    return min(found, default=math.inf)


def robot_outline(pose: Pose) -> Polygon:
    """Return the outline of a Pushbot's chassis at a pose: 10 x 10 cm."""
    half = 0.5 * ROBOT_SIZE[0], 0.5 * ROBOT_SIZE[1]
    return _moved(box(-half[0], -half[1], half[0], half[1]), np.array(pose))


def check_scene(scene: Scene) -> None:
    """Raise `ParameterError` unless the floor is one piece, holds every body, and the start is free."""
    floor = Polygon(scene.corners)
    if not floor.is_valid or floor.area <= 0.0:
        raise ParameterError("arena.corners: they cross, must go round the floor once without crossing")
    for k, shade in enumerate(scene.shades):
        shape = Polygon(shade.corners)
        if not shape.is_valid or shape.area < 0.999 * shape.convex_hull.area:
            raise ParameterError(f"shade[{k}].corners: not convex, must be; make several shades of it")
    for k, corners in enumerate(scene.partitions):
        for i, point in enumerate(corners):
            _check_inside(f"wall[{k}]", f"corners[{i}]", Spot(point), floor)
    obstacles = obstacles_of(scene)
    poses = _poses(obstacles, 0.0)
    for k, body in enumerate(scene.bodies):
        _check_inside(body.name, "at", _moved(obstacles.outlines[k], poses[k]), floor)
        for i, point in enumerate(() if body.motion is None else body.motion.path):
            _check_inside(body.name, f"motion.path[{i}]", Spot(point), floor)
    _check_start(obstacles)


def _check_inside(name: str, attribute: str, shape: Polygon | Spot, floor: Polygon) -> None:
    if not floor.covers(shape):
        x, y = shape.centroid.x, shape.centroid.y
        raise ParameterError(
            f"{name}.{attribute}: [{x:g}, {y:g}] m, must be inside the arena; move it or enlarge the arena"
        )


def _check_start(obstacles: Obstacles) -> None:
    start = obstacles.scene.start
    touched = collision(obstacles, start, 0.0)
    if touched is not None:
        shown = f"start.at: [{start[0]:g}, {start[1]:g}] m"
        where = "outside the arena or in its wall" if touched == "wall" else f"in {touched}"
        raise ParameterError(f"{shown}, the robot is {where}, must be free; start elsewhere")


def _outline(body: Body) -> Polygon:
    half = 0.5 * body.size[0], 0.5 * body.size[1]
    if body.is_round:
        return Spot(0.0, 0.0).buffer(half[0], quad_segs=8)
    return box(-half[0], -half[1], half[0], half[1])


def _moved(shape: Polygon, pose: F64) -> Polygon:
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return affinity.affine_transform(shape, [cos, -sin, sin, cos, float(pose[0]), float(pose[1])])


def _poses(obstacles: Obstacles, time: float) -> F64:
    pose = np.empty((len(obstacles.outlines), 3))
    place_bodies(obstacles.motions, time, pose)
    return pose
