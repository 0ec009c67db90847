"""A drive along waypoints by bearing minus heading, each reached within 10 m (Hwu et al. 2018, II.G).

The rover goes forward and turns the shorter way towards the current waypoint's bearing from its last fix.
Waypoints are the centres of the path's cells. It stops at the last one. Where it runs into an obstacle that
no map has, an operator leads it around (an intervention), or with sonars it turns away from what they see.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, I64
from system.rover.body import Pose, Rover, bearing, move, wheel_speeds, wrapped
from system.rover.cost_map import TREES, Cell, CostMap
from system.rover.sensors import (
    COMPASS_STREAM,
    GPS_STREAM,
    OBSTACLE_STREAM,
    WHEEL_STREAM,
    Compass,
    Gps,
    Obstacle,
    compass,
    nearest_ahead,
    receiver,
    stream,
)

PATIENCE = 10.0  # times the time that the planned way takes, after which a drive is given up; ours
_GRACE = 120.0  # s more; ours
_OBSTACLE_RADIUS = 0.5  # m; ours
_OBSTACLES_TREES = 0.05  # an expected number a cell and unit of cost where trees stand; ours
_OBSTACLES_OPEN = 0.01  # a cell elsewhere; ours
_ASIDE = 0.3  # m that an operator leaves between rover and obstacle; ours

Visit = Callable[[Cell, Cell], None]
Avoid = Callable[[Pose], float | None]


@dataclass(frozen=True, slots=True)
class Drive:
    """What a drive leaves, once a second: time, true place, and last fix of the GPS.

    time : s, float64[n]; place, fix : m east and north, float64[n, 2].
    arrived : whether a fix lay within the rover's reach of the goal.
    interventions : how often an operator led it round an obstacle.
    outages : how often the GPS dropped out.
    """

    time: F64
    place: F64
    fix: F64
    arrived: bool
    interventions: int
    outages: int

    @property
    def distance(self) -> float:
        """Length of the way that was driven, m."""
        return float(np.hypot(*np.diff(self.place, axis=0).T).sum())


def polyline(cost_map: CostMap, path: I64) -> F64:
    """Centres of the cells of a path, float64[n, 2] in m east and north of the map's south-west corner."""
    east = (path[:, 1] + 0.5) * cost_map.cell_width
    north = (cost_map.shape[0] - path[:, 0] - 0.5) * cost_map.cell_height
    return np.stack([east, north], axis=1)


def cell_at(cost_map: CostMap, east: float, north: float) -> Cell:
    """Cell at a place, the nearest of the map where it is outside."""
    rows, columns = cost_map.shape
    row = rows - 1 - math.floor(north / cost_map.cell_height)
    column = math.floor(east / cost_map.cell_width)
    return min(max(row, 0), rows - 1), min(max(column, 0), columns - 1)


def scatter_obstacles(cost_map: CostMap, key: Sequence[int]) -> tuple[Obstacle, ...]:
    """Posts that no map has, Poisson in each cell; never within a metre of a centre, where routes begin."""
    random = stream(key, OBSTACLE_STREAM)
    costs = cost_map.costs
    counts = random.poisson(np.where(costs >= TREES, _OBSTACLES_TREES * costs, _OBSTACLES_OPEN))
    cells = np.repeat(np.argwhere(counts >= 0), counts.ravel(), axis=0)
    centres = polyline(cost_map, cells)
    moves = random.uniform(-0.5, 0.5, centres.shape) * (cost_map.cell_width, cost_map.cell_height)
    kept = np.hypot(*moves.T) > 1.0 + _OBSTACLE_RADIUS
    return tuple(Obstacle(float(x), float(y), _OBSTACLE_RADIUS) for x, y in (centres + moves)[kept])


def drive(
    rover: Rover,
    cost_map: CostMap,
    path: I64,
    key: Sequence[int],
    obstacles: tuple[Obstacle, ...] = (),
    *,
    visit: Visit | None = None,
    avoid: Avoid | None = None,
) -> Drive:
    """Drive along `path`, int64[n, 2] of (row, column).

    key: seed and number of the trip, of all its noise.
    `visit` is called once a second with the cell under the rover and the cell in which its fix lies;
    `avoid` may return a turn rate, rad/s, that goes before that towards the waypoint.
    """
    voyage = set_out(rover, cost_map, path, key)
    log: list[tuple[float, ...]] = []
    while not voyage.late:
        if locate(voyage):
            log.append(voyage.record())
            if visit is not None:
                visit(voyage.cell, cell_at(cost_map, *voyage.gps.fix))
        if voyage.arrived:
            break
        turn = None if avoid is None else avoid(voyage.pose)
        if turn is None:
            turn = steering(voyage, voyage.compass.heading(voyage.pose))
        roll(voyage, turn, obstacles)
    table = np.array([*log, voyage.record()])
    return Drive(
        table[:, 0], table[:, 1:3], table[:, 3:], voyage.arrived, voyage.interventions, voyage.gps.outages
    )


def turn_away(rover: Rover, obstacles: tuple[Obstacle, ...]) -> Avoid:
    """Turn away from what the sonars see nearer than the margin, rad/s; None where nothing is."""

    def avoid(pose: Pose) -> float | None:
        seen = nearest_ahead(rover, pose, obstacles)
        if seen is None or seen[0] > rover.sonar_margin:
            return None
        return -math.copysign(rover.turn_rate, seen[1])

    return avoid


def tree_cover(cost_map: CostMap) -> F64:
    """Share of trees among each cell and its eight neighbours, float64[rows, columns]."""
    trees = np.pad((cost_map.costs >= TREES).astype(np.float64), 1, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(trees, (3, 3))
    return np.asarray(windows.mean(axis=(2, 3)))


@dataclass(slots=True)
class Voyage:
    """A rover under way.

    rover, cost_map : body and map; points : waypoints, m, float64[n, 2]; cover : of trees, as `tree_cover`.
    pose, time : where it is, s since the start.
    gps, compass : its senses.
    gains : errors of its wheels' speeds.
    limit : s, after which it is given up.
    steps : control periods so far.
    waypoint : number of the next waypoint.
    interventions : how often an operator led it round an obstacle.
    """

    rover: Rover
    cost_map: CostMap
    points: F64
    cover: F64
    pose: Pose
    gps: Gps
    compass: Compass
    gains: tuple[float, float]
    limit: float
    time: float = 0.0
    steps: int = 0
    waypoint: int = 0
    interventions: int = 0

    @property
    def cell(self) -> Cell:
        """Cell under the rover."""
        return cell_at(self.cost_map, self.pose.east, self.pose.north)

    @property
    def arrived(self) -> bool:
        """Whether every waypoint was reached."""
        return self.waypoint == len(self.points)

    @property
    def late(self) -> bool:
        """Whether its patience is over."""
        return self.time >= self.limit

    def record(self) -> tuple[float, ...]:
        """Return a row of the log."""
        return self.time, self.pose.east, self.pose.north, *self.gps.fix


def set_out(rover: Rover, cost_map: CostMap, path: I64, key: Sequence[int]) -> Voyage:
    """Return a rover at the beginning of a path, int64[n, 2] of (row, column), heading along it.

    key : seed and number of the trip, of all its noise.
    """
    points = polyline(cost_map, path)
    pose = Pose(float(points[0, 0]), float(points[0, 1]), _first_heading(points))
    left, right = (1.0 + rover.wheel_spread * stream(key, WHEEL_STREAM).standard_normal(2)).tolist()
    senses = receiver(rover, pose, stream(key, GPS_STREAM)), compass(rover, stream(key, COMPASS_STREAM))
    limit = _GRACE + PATIENCE * float(np.hypot(*np.diff(points, axis=0).T).sum()) / rover.speed
    return Voyage(rover, cost_map, points, tree_cover(cost_map), pose, *senses, (left, right), limit)


def locate(voyage: Voyage) -> bool:
    """Take a fix where one is due, and the next waypoint by the last fix; whether there was a new fix."""
    rover = voyage.rover
    due = voyage.steps % max(round(rover.gps_period / rover.control_period), 1) == 0
    if due:
        voyage.gps.sample(voyage.time, voyage.pose, float(voyage.cover[voyage.cell]))
    voyage.waypoint = _advance(rover, voyage.gps, voyage.points, voyage.waypoint)
    return due


def steering(voyage: Voyage, heading: float) -> float:
    """Turn rate, rad/s, towards the next waypoint's bearing from the last fix, at a heading, rad."""
    return _steer(voyage.rover, voyage.gps, heading, voyage.points[voyage.waypoint])


def roll(voyage: Voyage, turn: float, obstacles: tuple[Obstacle, ...]) -> None:
    """One control period at a turn rate, rad/s.

    Where the rover then touches an obstacle, an operator leads it around.
    """
    rover = voyage.rover
    left, right = (speed * gain for speed, gain in zip(wheel_speeds(rover, turn), voyage.gains, strict=True))
    voyage.pose = move(rover, voyage.pose, left, right, rover.control_period)
    voyage.time += rover.control_period
    voyage.steps += 1
    struck = _struck(rover, voyage.pose, obstacles)
    if struck is not None:
        voyage.pose = _led_around(rover, voyage.pose, struck)
        voyage.interventions += 1
        voyage.time += rover.redirection_time


def _first_heading(points: F64) -> float:
    """Towards the second waypoint; north where there is none."""
    return bearing(*(points[1] - points[0]).tolist()) if len(points) > 1 else 0.0


def _advance(rover: Rover, gps: Gps, points: F64, waypoint: int) -> int:
    """Index of the first waypoint from this one on that is not within reach of the last fix."""
    while waypoint < len(points) and math.dist(gps.fix, points[waypoint]) < rover.reach:
        waypoint += 1
    return waypoint


def _steer(rover: Rover, gps: Gps, heading: float, target: F64) -> float:
    """Turn rate towards the bearing of the waypoint, rad/s."""
    wanted = bearing(float(target[0]) - gps.fix[0], float(target[1]) - gps.fix[1])
    turn = rover.turn_gain * wrapped(wanted - heading)
    return min(max(turn, -rover.turn_rate), rover.turn_rate)


def _struck(rover: Rover, pose: Pose, obstacles: tuple[Obstacle, ...]) -> Obstacle | None:
    for o in obstacles:
        if math.hypot(o.east - pose.east, o.north - pose.north) < o.radius + rover.half_width:
            return o
    return None


def _led_around(rover: Rover, pose: Pose, obstacle: Obstacle) -> Pose:
    """Beside the obstacle, on the nearer side of the way, with the same heading."""
    side = wrapped(bearing(obstacle.east - pose.east, obstacle.north - pose.north) - pose.heading)
    across = pose.heading - math.copysign(0.5 * math.pi, side)
    away = obstacle.radius + rover.half_width + _ASIDE
    return Pose(
        obstacle.east + away * math.sin(across), obstacle.north + away * math.cos(across), pose.heading
    )
