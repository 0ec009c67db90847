"""A flight through a forest that is steered by spikes, of the spike-latency network or of its chip.

The brain runs on without a break, a ping every period. Between pings the bat flies its arc; where body
motors spiked it turns at the first one's spike onto the mean of their arcs; at the emergency neuron's it
turns round. Ranges and bearings are exact and nothing is occluded, as for the analog model.

Ours: after an emergency the head looks along the path, as for the analog model.

Source: Wen & Horiuchi 2022, section 4.2, Figure 13.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from circuits.arrays import F64
from system.openspace import state
from system.openspace.flight import margin_of
from system.openspace.kernel import advance
from system.openspace.law import ARCS, DIRECTIONS, MIDDLE, Arcs
from system.openspace.map import SIDE, Cells, Forest, cells_of
from system.spiking_bat.bat import goal_neuron, look
from system.spiking_bat.brain import Brain, Reply
from system.spiking_bat.circling import stays

_LOOK = 100  # pings between looks for a loop


@dataclass(frozen=True, slots=True)
class Standing:
    """How a bat stands at a ping: place (m), heading (rad), its course (1/m, m/s), direction of its head.

    curvature : of its course, 1/m.
    speed : of its course, m/s.
    """

    place: tuple[float, float]
    heading: float
    curvature: float
    speed: float
    head: int


@dataclass(frozen=True, slots=True)
class Flown:
    """A flight: its log (float64[rows, 8], see `system.openspace.kernel`), end (m), what was counted.

    collided: whether it ended by a collision; a flight may have no more than some pings; turned: how the bat
    stood at the first ping after its last emergency, whose reset erased what the brain remembered.

    laps : crossings of the left border.
    avoided : obstacles that were detected and not collided with.
    emergencies : times that it turned round.
    scans : pings after which only the head turned.
    time_s : length of the flight, s.
    distance_m : way of the flight, m.
    """

    log: F64 = field(repr=False)
    end: tuple[float, float]
    collided: bool
    pings: int
    laps: int
    avoided: int
    emergencies: int
    scans: int
    time_s: float
    distance_m: float
    turned: Standing | None = None

    @property
    def path(self) -> F64:
        """Places where a stretch began, and the end, float64[rows + 1, 2], m."""
        return np.concatenate([self.log[:, 1:3], [self.end]])

    @property
    def caught(self) -> bool:
        """Whether it was stopped in a loop, `system.spiking_bat.circling`."""
        return not self.collided and stays(np.append(self.log[:, 0], self.time_s), self.path)


@dataclass(slots=True)
class _Course:
    """What the bat flies: curvature (1/m) and speed (m/s), means of its arcs."""

    curvature: float
    speed: float


def fly(
    brain: Brain,
    arcs: Arcs,
    forest: Forest,
    start: tuple[float, float] | Standing,
    pings: int,
    laps: int | None = None,
    progress: Callable[[float], None] | None = None,
    *,
    patience: float = math.inf,
) -> Flown:
    """Fly until a collision, so many pings, or so many crossings of the left border; nothing is remembered.

    start : how the bat stands, or a place (m), from which it flies to the left.
    patience : s in a loop (`system.spiking_bat.circling`) after which a flight is stopped too.
    """
    standing = start
    if not isinstance(standing, Standing):
        straight = float(arcs.curvature[MIDDLE]), float(arcs.speed[MIDDLE])
        standing = Standing(standing, -math.pi, *straight, DIRECTIONS // 2)
    flight = state.new_flight(*standing.place, standing.heading, DIRECTIONS, len(forest.place), 2 * pings)
    flight.counts[state.HEAD] = standing.head
    cells = cells_of(forest, margin_of(arcs))
    course = _Course(standing.curvature, standing.speed)
    collided, turned = False, None
    while (
        not collided
        and flight.counts[state.PINGS] < pings
        and (laps is None or flight.counts[state.LAP] < laps)
    ):
        heading = float(flight.pose[state.HEADING])
        seen = _look(arcs, forest, flight)
        head = int(flight.counts[state.HEAD])
        answer = brain.ping(head, goal_neuron(arcs, heading), seen)
        collided = _follow(arcs, cells, flight, brain.period, course, answer)
        if answer.emergency is not None:
            turned = _standing(flight, course)
        if progress is not None:
            progress(float(flight.counts[state.PINGS]) / pings)
        if flight.counts[state.PINGS] % _LOOK == 0 and _loops(flight, patience):
            break
    counts = flight.counts
    return Flown(
        log=flight.log[: counts[state.LOGGED]].copy(),
        end=(float(flight.pose[state.X]), float(flight.pose[state.Y])),
        collided=collided,
        pings=int(counts[state.PINGS]),
        laps=int(counts[state.LAP]),
        avoided=int(counts[state.AVOIDED]),
        emergencies=int(counts[state.EMERGENCIES]),
        scans=int(counts[state.SCANS]),
        time_s=float(flight.pose[state.TIME]),
        distance_m=float(flight.pose[state.DISTANCE]),
        turned=turned,
    )


def _loops(flight: state.Flight, patience: float) -> bool:
    log = flight.log[: flight.counts[state.LOGGED]]
    return math.isfinite(patience) and stays(log[:, 0], log[:, 1:3], patience)


def _standing(flight: state.Flight, course: _Course) -> Standing:
    place = float(flight.pose[state.X]), float(flight.pose[state.Y])
    heading, head = float(flight.pose[state.HEADING]), int(flight.counts[state.HEAD])
    return Standing(place, heading, course.curvature, course.speed, head)


def _look(arcs: Arcs, forest: Forest, flight: state.Flight) -> F64:
    """What a ping shows, float64[n, 2]; counts obstacles that it shows for the first time in this lap."""
    offset = forest.place - flight.pose[[state.X, state.Y]]
    offset -= SIDE * np.round(offset / SIDE)
    head, heading = int(flight.counts[state.HEAD]), float(flight.pose[state.HEADING])
    found, which = np.empty((len(offset), 2)), np.empty(len(offset), dtype=np.int64)
    count = look(arcs, offset, heading, head, found, which)
    shown = which[:count]
    fresh = shown[flight.met[shown] <= flight.counts[state.LAP]]
    flight.met[fresh] = flight.counts[state.LAP] + 1
    flight.counts[state.AVOIDED] += fresh.size
    flight.counts[state.PINGS] += 1
    flight.counts[state.SEEN], flight.counts[state.PINGED] = count, head
    return found[:count]


def _follow(
    arcs: Arcs, cells: Cells, flight: state.Flight, period: float, course: _Course, answer: Reply
) -> bool:
    """Fly until the next ping as the motors say; whether that ended by a collision."""
    if answer.head is not None:
        flight.counts[state.HEAD] = answer.head
    turned = answer.turned
    flight.counts[state.SCANNING] = int(turned is None)
    flight.counts[state.SCANS] += int(turned is None and answer.head is not None)
    if answer.emergency is not None:
        if _fly_on(arcs, cells, flight, course, answer.emergency):
            return True
        _turn_round(arcs, flight, course)
        return _fly_on(arcs, cells, flight, course, period - answer.emergency)
    if turned is None:
        return _fly_on(arcs, cells, flight, course, period)
    if _fly_on(arcs, cells, flight, course, turned):
        return True
    course.curvature = float(arcs.curvature[answer.arcs].mean())
    course.speed = float(arcs.speed[answer.arcs].mean())
    flight.counts[state.WINNER] = answer.arcs[0]
    return _fly_on(arcs, cells, flight, course, period - turned)


def _fly_on(arcs: Arcs, cells: Cells, flight: state.Flight, course: _Course, duration: float) -> bool:
    """Fly the course for `duration` s; whether it ended by a collision."""
    flight.counts[state.ARC] = 0  # the only one of these arcs
    one = arcs._replace(curvature=np.array([course.curvature]), speed=np.array([course.speed]), step=duration)
    return bool(advance(one, cells, flight) or flight.counts[state.HIT] >= 0)


def _turn_round(arcs: Arcs, flight: state.Flight, course: _Course) -> None:
    """Fly back on the same circle, and look along it."""
    flight.pose[state.HEADING] -= math.pi if flight.pose[state.HEADING] > 0.0 else -math.pi
    course.curvature = -course.curvature
    nearest = int(np.abs(arcs.curvature - course.curvature).argmin())
    flight.counts[state.HEAD] = arcs.group[min(nearest, ARCS - 1)]
    flight.counts[state.EMERGENCIES] += 1
