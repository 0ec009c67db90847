"""The loop of the car: it pings, localises, evaluates, chooses, turns head and wheels, and rolls on.

Each cycle takes 1 / ping_rate, and longer by the turn of the head and a soft ping's listening; the robot
rolls along its arc all the time. Memory and choice are equations (4) and (6); the goal is far away in the
direction of x. The memory's decay is a rate times the cycle's time, and halts while it scans.

A car cannot turn round on the spot: in an emergency it backs up the way that it came, and forgets (ours).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from system.car.arcs import Arcs, blocked, immediacies, moved
from system.car.numbers import ARCS, DIRECTIONS, MIDDLE, OpenspaceNumbers, Robot
from system.car.sonar import Sonar, listened, ping
from system.car.world import Pipes
from system.openspace.choice import add_goal, aimed_arc, best, excite, inhibit, remember

Pose = tuple[float, float, float]  # m, m, rad

MARGIN = 0.15  # m beyond the forest, where a run ends; ours
_NEVER = -1e9  # s


class Drive(NamedTuple):
    """What a drive leaves.

    ended : why it ended; log : float64[pings, 8], of each its time (s), its pose (m, m, rad), the head's
    direction, the arc, whether it scans and whether it is soft; end : the last pose, m, m, rad; distance : m;
    time : s; counts : by the names of `COUNTS`.
    """

    ended: str
    log: F64
    end: Pose
    distance: float
    time: float
    counts: dict[str, int]


REASONS = {
    "through": "came through the forest",
    "out": "left the forest by a side",
    "collided": "collided with a pipe",
}
SonarAt = Callable[[float], Sonar]
COUNTS = ("pings", "soft_pings", "echoes", "near", "missed", "occluded", "clipped", "scans", "retreats")


@dataclass(slots=True)
class Voyage:
    """A car under way: `look`, then `choose` or another choice of arc and head, then `go`, and again.

    robot, numbers, arcs : of the car.
    sonar_at : the sonar in a ping at a time, s; None where places are exact.
    forest : the pipes.
    pose : m, m, rad.
    risk, sensed : the memory of each arc, and when each direction was sensed last, s.
    arc, head, scanning : what it drives, where the head looks, and whether only that turned.
    time, last, distance : s, of the last ping (s), m.
    way : arc and length of what it came by.
    seen : places that the last ping showed, in the body's frame, m, float64[n, 2].
    soft, pinged : whether a soft ping followed, and the direction of the last ping.
    """

    robot: Robot
    numbers: OpenspaceNumbers
    arcs: Arcs
    sonar_at: SonarAt | None
    forest: Pipes
    pose: Pose
    risk: F64 = field(default_factory=lambda: np.zeros(ARCS))
    sensed: F64 = field(default_factory=lambda: np.full(DIRECTIONS, _NEVER))
    arc: int = MIDDLE
    head: int = DIRECTIONS // 2
    scanning: bool = False
    time: float = 0.0
    last: float = 0.0
    distance: float = 0.0
    way: list[tuple[int, float]] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(COUNTS, 0))
    seen: F64 = field(default_factory=lambda: np.zeros((0, 2)))
    soft: bool = False
    pinged: int = DIRECTIONS // 2

    def row(self) -> tuple[float, ...]:
        """Return a row of the log, after a ping."""
        return (self.time, *self.pose, self.head, self.arc, self.scanning, self.soft)


def drive(
    robot: Robot,
    numbers: OpenspaceNumbers,
    arcs: Arcs,
    sonar_at: SonarAt | None,
    forest: Pipes,
    start: Pose,
    pings: int,
    progress: Callable[[float], None] | None = None,
) -> Drive:
    """Drive until a collision, the end of the forest, or so many pings; without a sonar places are exact.

    sonar_at: the sonar in a ping at a time, s, in which the temperature of its chip stands.
    """
    car = Voyage(robot, numbers, arcs, sonar_at, forest, start)
    log, ended = [], "undecided"
    while car.counts["pings"] < pings and ended == "undecided":
        look(car)
        log.append(car.row())
        ended = go(car, retreat=choose(car))
        if progress is not None:
            progress(car.counts["pings"] / pings)
    return Drive(ended, np.array(log), car.pose, car.distance, car.time, car.counts)


def look(car: Voyage) -> None:
    """Ping in the head's direction, and remember what it shows."""
    sonar = None if car.sonar_at is None else car.sonar_at(car.time)
    car.seen, car.soft = _sense(car.robot, car.numbers, car.arcs, sonar, car.forest, car, car.counts)
    zone = car.robot.zone + car.numbers.margin
    _remember(car.numbers, car.arcs, car, immediacies(car.arcs, car.seen, zone, car.numbers.max_risk))
    car.pinged = car.head


def choose(car: Voyage) -> bool:
    """Direct head and wheels by Curved Openspace; whether it is an emergency."""
    return _choose(car.numbers, car.arcs, car, car.counts)


def go(car: Voyage, *, retreat: bool) -> str:
    """Turn the head, and roll on or back up until the next ping; why the drive ended, or `undecided`."""
    robot, arcs = car.robot, car.arcs
    turn = abs(arcs.direction[car.head] - arcs.direction[car.pinged])
    taken = 1.0 / robot.ping_rate + turn / robot.neck_speed + (robot.blanking + robot.call) * car.soft
    if retreat:
        _back_up(robot, car.numbers, arcs, car)
        car.time += taken
        return "undecided"
    if _roll(arcs, car.forest, robot.zone, car, taken):
        return "collided"
    return _where(car.forest, car.pose)


def _sense(
    robot: Robot,
    numbers: OpenspaceNumbers,
    arcs: Arcs,
    sonar: Sonar | None,
    forest: Pipes,
    state: Voyage,
    counts: dict[str, int],
) -> tuple[F64, bool]:
    """Places (m, in the body's frame) of what a ping shows, and whether a soft one followed."""
    x, y, heading = state.pose
    cos, sin = math.cos(heading), math.sin(heading)
    turn = float(arcs.direction[state.head])
    off = forest.place - np.array([x, y])
    body = np.stack(
        [cos * off[:, 0] + sin * off[:, 1] - robot.head_ahead, cos * off[:, 1] - sin * off[:, 0]], 1
    )
    head = _turned(body, -turn)
    counts["pings"] += 1
    soft = False
    if sonar is None:
        seen = np.hypot(*head.T) <= _reach(numbers, np.arctan2(head[:, 1], head[:, 0]))
        found = head[seen]
        counts["echoes"] += len(found)
    else:
        heard = ping(sonar, head, 2 * counts["pings"], soft=False, time=state.time)
        found, soft = heard.place, sonar.soft_pings and heard.near > 0
        counts["near"] += heard.near
        both = [heard]
        if soft:
            later = state.time + listened(robot)
            both.append(ping(sonar, head, 2 * counts["pings"] + 1, soft=True, time=later))
            found = np.concatenate([found, both[1].place])
            counts["soft_pings"] += 1
        counts["echoes"] += len(found)
        counts["occluded"] += heard.occluded
        counts["missed"] += sum(h.missed for h in both)
        counts["clipped"] += sum(h.clipped for h in both)
    return _turned(found, turn) + np.array([robot.head_ahead, 0.0]), soft


def _remember(numbers: OpenspaceNumbers, arcs: Arcs, state: Voyage, fresh: F64) -> None:
    """Equation (4), with the decay of the time since the last ping."""
    decay = 0.0 if state.scanning else numbers.decay * (state.time - state.last)
    remember(state.risk, fresh, arcs.group, state.head, decay, numbers.inhibition, numbers.max_risk)
    state.sensed[state.head], state.last = state.time, state.time


def desirabilities(
    numbers: OpenspaceNumbers, arcs: Arcs, risk: F64, heading: float, head: int, arc: int
) -> F64:
    """Return the desirability of each arc by equation (6), float64[ARCS].

    The goal lies in the direction 0, along x.
    """
    wish, aim = np.empty(ARCS), aimed_arc(-heading, MIDDLE / numbers.goal_span, ARCS)
    excite(wish, arcs.bias, arcs.hold[arc], arcs.group, head, numbers.ping_bias)
    add_goal(wish, aim, numbers.goal_gain, numbers.goal_sigma)
    inhibit(wish, risk, arcs.spread)
    return wish


def _choose(numbers: OpenspaceNumbers, arcs: Arcs, state: Voyage, counts: dict[str, int]) -> bool:
    """Direct head and wheels; whether it is an emergency."""
    wish = desirabilities(numbers, arcs, state.risk, state.pose[2], state.head, state.arc)
    winner = best(wish)
    if wish[winner] < numbers.emergency_below:
        counts["retreats"] += 1
        return True
    group = int(arcs.group[winner])
    if state.time - state.sensed[group] <= numbers.recency:
        state.arc, state.scanning = winner, False
    else:
        counts["scans"] += 1
        state.scanning = True
    state.head = group
    return False


def _roll(arcs: Arcs, forest: Pipes, zone: float, state: Voyage, taken: float) -> bool:
    """Roll for some time (s); whether a pipe was touched, where it then stays."""
    k, slip = arcs.curvature[state.arc], arcs.slip[state.arc]
    way = float(arcs.speed[state.arc]) * taken
    x, y, heading = state.pose
    body = _turned(forest.place - np.array([x, y]), -heading)
    nearest = blocked(np.array([k]), np.array([slip]), np.array([way]), body, zone)[0]
    touched = _touch(k, slip, way, body[~np.isnan(nearest)], zone)
    state.pose = moved(state.pose, float(k), float(slip), touched)
    state.way.append((state.arc, touched))
    state.distance += touched
    state.time += taken * touched / way
    return touched < way


def _touch(k: float, slip: float, way: float, place: F64, zone: float) -> float:
    """How far (m) the body comes along `way` before it touches one of the places, by halving."""
    if not len(place):
        return way
    low, high = 0.0, way
    for _ in range(40):
        middle = 0.5 * (low + high)
        hit = ~np.isnan(blocked(np.array([k]), np.array([slip]), np.array([middle]), place, zone))
        low, high = (low, middle) if hit.any() else (middle, high)
    return low


def _back_up(robot: Robot, numbers: OpenspaceNumbers, arcs: Arcs, state: Voyage) -> None:
    """Back up the way that it came, at the straight arc's speed, and forget what was seen from there."""
    left = numbers.retreat
    while left > 0.0 and state.way:
        arc, way = state.way.pop()
        back = min(way, left)
        if back < way:
            state.way.append((arc, way - back))
        state.pose = _moved_back(state.pose, float(arcs.curvature[arc]), float(arcs.slip[arc]), back)
        left -= back
    done = numbers.retreat - left
    state.distance += done
    state.time += done / robot.max_speed
    state.risk = np.zeros(ARCS)
    state.sensed[:] = _NEVER
    state.arc, state.head, state.scanning = MIDDLE, DIRECTIONS // 2, False


def _moved_back(pose: Pose, curvature: float, slip: float, way: float) -> Pose:
    """Pose from which an arc of `way` m led to this one."""
    return moved(pose, curvature, slip, -way)


def _where(forest: Pipes, pose: Pose) -> str:
    x, y, _ = pose
    if x > forest.long + MARGIN:
        return "through"
    if abs(y) > 0.5 * forest.wide + MARGIN and x > 0.0:
        return "out"
    return "undecided"


def _reach(numbers: OpenspaceNumbers, bearing: F64) -> F64:
    return np.asarray(numbers.view_range * np.exp(-(bearing**2) / (2.0 * numbers.view_sigma**2)))


def _turned(place: F64, angle: float) -> F64:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.stack([cos * place[:, 0] - sin * place[:, 1], sin * place[:, 0] + cos * place[:, 1]], axis=1)
