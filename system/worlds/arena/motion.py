"""Where moving things are at a time, compiled: bodies on their paths, and a robot on an arc."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled
from system.worlds.arena.scene import Body

STRIDES = 0.9  # Hz, of walking legs; ours

_STOP, _SHUTTLE, _LOOP = range(3)
_REPEATS = {"stop": _STOP, "shuttle": _SHUTTLE, "loop": _LOOP}
_compiled = compiled()


class Motions(NamedTuple):
    """The paths of all bodies of a scene, one after the other in shared arrays.

    rest: float64[bodies, 3], m, m, rad, of those without a path; begin: int64[bodies + 1] into the points;
    at: float64[points, 2], m; way: float64[points], m from the path's first point; speed (m/s), start (s),
    repeat, swing (m), phase (rad): [bodies].
    """

    rest: F64
    begin: I64
    at: F64
    way: F64
    speed: F64
    start: F64
    repeat: I64
    swing: F64
    phase: F64


def motions_of(bodies: tuple[Body, ...]) -> Motions:
    """Paths of bodies as arrays; a path that loops gets its first point again as its last."""
    points: list[list[tuple[float, float]]] = []
    for body in bodies:
        path = [] if body.motion is None else list(body.motion.path)
        if body.motion is not None and body.motion.repeat == "loop":
            path.append(path[0])
        points.append(path)
    at = np.array([p for path in points for p in path], dtype=float).reshape(-1, 2)
    ways = [_way(path) for path in points]
    return Motions(
        rest=np.array([(*b.at, b.heading) for b in bodies], dtype=float).reshape(-1, 3),
        begin=np.concatenate([[0], np.cumsum([len(p) for p in points])]).astype(np.int64),
        at=at,
        way=np.concatenate([np.empty(0), *ways]),
        speed=np.array([0.0 if b.motion is None else b.motion.speed for b in bodies]),
        start=np.array([0.0 if b.motion is None else b.motion.start for b in bodies]),
        repeat=np.array(
            [_REPEATS["stop" if b.motion is None else b.motion.repeat] for b in bodies], dtype=np.int64
        ),
        swing=np.array([b.swing for b in bodies]),
        phase=np.array([b.swing_phase for b in bodies]),
    )


def _way(path: list[tuple[float, float]]) -> F64:
    if not path:
        return np.empty(0)
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(np.array(path), axis=0).T))])


@_compiled
def place_bodies(motions: Motions, time: float, pose: F64) -> None:
    """Fill `pose`, float64[bodies, 3] (m, m, rad), with where each body is at `time` s."""
    for k in range(pose.shape[0]):
        first, last = motions.begin[k], motions.begin[k + 1] - 1
        pose[k, 0], pose[k, 1], pose[k, 2] = motions.rest[k, 0], motions.rest[k, 1], motions.rest[k, 2]
        if last <= first:
            continue
        total = motions.way[last]
        gone = max(time - motions.start[k], 0.0) * motions.speed[k]
        moving = time > motions.start[k]
        back = False
        if motions.repeat[k] == _LOOP:
            gone %= total
        elif motions.repeat[k] == _SHUTTLE:
            gone %= 2.0 * total
            back = gone > total
            gone = 2.0 * total - gone if back else gone
        else:
            moving = moving and gone < total
            gone = min(gone, total)
        i = first
        while i < last - 1 and motions.way[i + 1] < gone:
            i += 1
        dx, dy = motions.at[i + 1, 0] - motions.at[i, 0], motions.at[i + 1, 1] - motions.at[i, 1]
        length = motions.way[i + 1] - motions.way[i]
        share = (gone - motions.way[i]) / length if length > 0.0 else 0.0
        heading = math.atan2(dy, dx) + (math.pi if back else 0.0)
        pose[k, 0] = motions.at[i, 0] + share * dx
        pose[k, 1] = motions.at[i, 1] + share * dy
        pose[k, 2] = heading
        if moving and motions.swing[k] != 0.0:
            swing = motions.swing[k] * math.sin(2.0 * math.pi * STRIDES * time + motions.phase[k])
            pose[k, 0] += swing * math.cos(heading)
            pose[k, 1] += swing * math.sin(heading)


@_compiled
def go_along_arc(pose: F64, speed: float, turn: float, duration: float) -> None:
    """Move `pose`, float64[3] (m, m, rad), at constant speed (m/s) and turn rate (rad/s)."""
    half = 0.5 * turn * duration
    # the chord of an arc is its length times sin(half) / half, along the mean heading
    chord = speed * duration * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
    pose[0] += chord * math.cos(pose[2] + half)
    pose[1] += chord * math.sin(pose[2] + half)
    pose[2] += 2.0 * half
