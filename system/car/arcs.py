"""The arcs of the car: which angle of the wheels each has, and what a pipe on the floor means for it.

Without slip the middle of the rear axle follows a circle of curvature tan(delta) / L, L the wheelbase, delta
the mean angle of the front wheels (Ackermann). The middle of the body, half a wheelbase ahead, runs on a
larger circle, and not along the body's axis:

    k = k_r / sqrt(1 + (k_r L / 2)^2),    beta = atan(k_r L / 2),    k_r = tan(delta) / L.

The look-up table has delta an arc, in whole steps of the servo. R_p and the ping direction of an arc follow
from the field of view as those of the bat do, as if the sonar stood in the middle of the body (ours).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from system.car.numbers import ARCS, DIRECTIONS, MIDDLE, OpenspaceNumbers, Robot
from system.openspace.choice import falling, grouped, ping_directions
from system.openspace.law import Bat, arc_point, length_in_view


class Arcs(NamedTuple):
    """Geometry and weights of the car's arcs; angles are positive to the left.

    steering: rad, of the wheels; curvature: 1/m, of the body's middle; slip: rad, from the body's axis to
    where its middle goes; length: m, R_p; speed: m/s; bias: D_0; group: int64[ARCS], ping direction;
    direction: float64[DIRECTIONS], rad; spread, hold: float64[ARCS, ARCS], weights of equation (6).
    """

    steering: F64
    curvature: F64
    slip: F64
    length: F64
    speed: F64
    bias: F64
    group: I64
    direction: F64
    spread: F64
    hold: F64


def steering_table(robot: Robot) -> F64:
    """Angle of the wheels for each arc, rad: evenly spaced, then rounded to steps of the servo."""
    share = (MIDDLE - np.arange(ARCS)) / MIDDLE
    return np.asarray(robot.steering_step * np.rint(robot.most_steering * share / robot.steering_step))


def arcs_of(robot: Robot, numbers: OpenspaceNumbers) -> Arcs:
    """Return the arcs of a robot, with their geometry and their weights."""
    steering = steering_table(robot)
    rear = np.tan(steering) / robot.wheelbase
    lever = 0.5 * robot.wheelbase
    curvature = rear / np.sqrt(1.0 + (rear * lever) ** 2)
    slip = np.arctan(rear * lever)
    direction = ping_directions(robot.direction_step, DIRECTIONS)
    length, group = _views(robot, numbers, curvature, slip, direction)
    return Arcs(
        steering=steering,
        curvature=curvature,
        slip=slip,
        length=length,
        speed=robot.max_speed * length / numbers.view_range,
        bias=numbers.default - numbers.sharp_turn_cost * (steering / robot.most_steering) ** 2,
        group=group,
        direction=direction,
        spread=falling(numbers.suppression, numbers.suppression_sigma, ARCS),
        hold=falling(numbers.hysteresis, numbers.hysteresis_sigma, ARCS),
    )


def moved(
    pose: tuple[float, float, float], curvature: float, slip: float, way: float
) -> tuple[float, float, float]:
    """Pose (m, m, rad) after `way` m of the body's middle along an arc; backwards where it is negative."""
    x, y, heading = pose
    ahead, left = (float(v) for v in arc_point(np.array(curvature), np.array(way)))
    course = heading + slip
    cos, sin = math.cos(course), math.sin(course)
    return x + cos * ahead - sin * left, y + sin * ahead + cos * left, heading + curvature * way


def blocked(curvature: F64, slip: F64, length: F64, place: F64, zone: float) -> F64:
    """Way (m) along each arc to its spot nearest to each place, NaN where that is not nearer than `zone`.

    curvature, slip, length: float64[arcs]; place: float64[n, 2], m, in the body's frame. Returns
    float64[arcs, n]. The spot may be the beginning or the end of an arc.
    """
    cos, sin = np.cos(slip)[:, None], np.sin(slip)[:, None]
    x = cos * place[:, 0] + sin * place[:, 1]
    y = cos * place[:, 1] - sin * place[:, 0]
    k, end = curvature[:, None], length[:, None]
    bend = np.where(k == 0.0, 1.0, np.abs(k))
    across, along = 1.0 - k * y, np.abs(k) * x
    s = np.where(k == 0.0, x, np.arctan2(along, across) / bend)
    off = np.where(k == 0.0, np.abs(y), np.abs(np.hypot(along, across) - 1.0) / bend)
    end_x, end_y = (v[:, None] for v in arc_point(curvature, length))
    to_end, to_start = np.hypot(x - end_x, y - end_y), np.hypot(x, y)
    on = (s >= 0.0) & (s <= end)
    nearest = np.where(on, s, np.where(to_end < to_start, end, 0.0))
    gap = np.where(on, off, np.minimum(to_end, to_start))
    return np.where(gap < zone, nearest, np.nan)


def immediacies(arcs: Arcs, place: F64, zone: float, max_risk: float) -> F64:
    """Sum over places (float64[n, 2], m, body's frame) of equation (3) for each arc, float64[ARCS].

    R_MAX gamma_p is R_p: f = E_MAX (1 - (r - R_C) / R_p), cut off at 0.
    """
    way = blocked(arcs.curvature, arcs.slip, arcs.length, place, zone)
    share = 1.0 - (way - zone) / arcs.length[:, None]
    return np.asarray(max_risk * np.nansum(np.maximum(share, 0.0), axis=1))


def _views(
    robot: Robot, numbers: OpenspaceNumbers, curvature: F64, slip: F64, direction: F64
) -> tuple[F64, I64]:
    """R_p (m) and the ping direction of each arc: where it stays longest in view, else nearer the middle."""
    bat = Bat(
        max_range=numbers.view_range,
        view_sigma=numbers.view_sigma,
        zone=robot.zone,
        least_radius=1.0 / curvature[0],
    )
    reach = np.array(
        [[length_in_view(bat, k, psi - b) for psi in direction] for k, b in zip(curvature, slip, strict=True)]
    )
    return grouped(reach, direction)
