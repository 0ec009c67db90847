"""Flight through a forest, steered by spikes: of the spike-latency network, or of its chip.

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
from numpy.typing import NDArray

from system.curved_openspace import ARCS, DIRECTIONS, MIDDLE, Arcs
from system.curved_openspace_kernel import advance
from system.forest_flight import margin_of
from system.forest_map import SIDE, Cells, Forest, cells_of
from system.forest_state import (
    ARC,
    AVOIDED,
    DISTANCE,
    EMERGENCIES,
    HEAD,
    HEADING,
    HIT,
    LAP,
    LOGGED,
    PINGED,
    PINGS,
    SCANNING,
    SCANS,
    SEEN,
    TIME,
    WINNER,
    Flight,
    X,
    Y,
    new_flight,
)
from system.latency_bat import goal_neuron, look
from system.latency_brain import Brain, Reply

F64 = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Flown:
    """A flight: its log (float64[rows, 8], see `system.curved_openspace_kernel`), end (m), what was counted.

    collided: whether it ended by a collision; a flight may have no more than some pings.
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

    @property
    def path(self) -> F64:
        """Places where a stretch began, and the end, float64[rows + 1, 2], m."""
        return np.concatenate([self.log[:, 1:3], [self.end]])


@dataclass(slots=True)
class _Course:
    """What the bat flies: curvature (1/m) and speed (m/s), means of its arcs."""

    curvature: float
    speed: float


def fly(
    brain: Brain,
    arcs: Arcs,
    forest: Forest,
    start: tuple[float, float],
    pings: int,
    laps: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Flown:
    """Fly left from a start (m) until a collision, so many pings, or so many crossings of the left border."""
    flight = new_flight(*start, -math.pi, DIRECTIONS, len(forest.place), 2 * pings)
    cells = cells_of(forest, margin_of(arcs))
    course = _Course(float(arcs.curvature[MIDDLE]), float(arcs.speed[MIDDLE]))
    collided = False
    while not collided and flight.counts[PINGS] < pings and (laps is None or flight.counts[LAP] < laps):
        heading = float(flight.pose[HEADING])
        seen = _look(arcs, forest, flight)
        head = int(flight.counts[HEAD])
        answer = brain.ping(head, goal_neuron(arcs, heading), seen)
        collided = _follow(arcs, cells, flight, brain.period, course, answer)
        if progress is not None:
            progress(float(flight.counts[PINGS]) / pings)
    counts = flight.counts
    return Flown(
        log=flight.log[: counts[LOGGED]].copy(),
        end=(float(flight.pose[X]), float(flight.pose[Y])),
        collided=collided,
        pings=int(counts[PINGS]),
        laps=int(counts[LAP]),
        avoided=int(counts[AVOIDED]),
        emergencies=int(counts[EMERGENCIES]),
        scans=int(counts[SCANS]),
        time_s=float(flight.pose[TIME]),
        distance_m=float(flight.pose[DISTANCE]),
    )


def _look(arcs: Arcs, forest: Forest, flight: Flight) -> F64:
    """What a ping shows, float64[n, 2]; counts obstacles that it shows for the first time in this lap."""
    offset = forest.place - flight.pose[[X, Y]]
    offset -= SIDE * np.round(offset / SIDE)
    head, heading = int(flight.counts[HEAD]), float(flight.pose[HEADING])
    found, which = np.empty((len(offset), 2)), np.empty(len(offset), dtype=np.int64)
    count = look(arcs, offset, heading, head, found, which)
    shown = which[:count]
    fresh = shown[flight.met[shown] <= flight.counts[LAP]]
    flight.met[fresh] = flight.counts[LAP] + 1
    flight.counts[AVOIDED] += fresh.size
    flight.counts[PINGS] += 1
    flight.counts[SEEN], flight.counts[PINGED] = count, head
    return found[:count]


def _follow(arcs: Arcs, cells: Cells, flight: Flight, period: float, course: _Course, answer: Reply) -> bool:
    """Fly until the next ping as the motors say; whether that ended by a collision."""
    if answer.head is not None:
        flight.counts[HEAD] = answer.head
    turned = answer.turned
    flight.counts[SCANNING] = int(turned is None)
    flight.counts[SCANS] += int(turned is None and answer.head is not None)
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
    flight.counts[WINNER] = answer.arcs[0]
    return _fly_on(arcs, cells, flight, course, period - turned)


def _fly_on(arcs: Arcs, cells: Cells, flight: Flight, course: _Course, duration: float) -> bool:
    """Fly the course for `duration` s; whether it ended by a collision."""
    flight.counts[ARC] = 0  # the only one of these arcs
    one = arcs._replace(curvature=np.array([course.curvature]), speed=np.array([course.speed]), step=duration)
    return bool(advance(one, cells, flight)) or flight.counts[HIT] >= 0


def _turn_round(arcs: Arcs, flight: Flight, course: _Course) -> None:
    """Fly back on the same circle, and look along it."""
    flight.pose[HEADING] -= math.pi if flight.pose[HEADING] > 0.0 else -math.pi
    course.curvature = -course.curvature
    nearest = int(np.abs(arcs.curvature - course.curvature).argmin())
    flight.counts[HEAD] = arcs.group[min(nearest, ARCS - 1)]
    flight.counts[EMERGENCIES] += 1
