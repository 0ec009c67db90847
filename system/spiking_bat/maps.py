"""The sensory maps of the spike-latency network: places, and delays that make a spike's latency a risk.

A map has a neuron for each of up to 25 ranges, 0.2 m apart, at 31 angles, 4 degrees apart, as far as the
field of view reaches: ceil(25 e^(-theta^2 / 1800)) at theta degrees, 471 in all. The head map stands about
the direction of the ping, the five body maps are the same places seen from the body. From a place j that
blocks an arc p a spike arrives at the arc's memory with the latency of equation (8),

    t(j, p) = T_MAX (r_p(j) - R_C) / (R_MAX gamma_p) + T_C,

because equation (7) adds t(j, p) - t_echo(j) to it. T_MAX is the echo delay at R_MAX, and R_MAX gamma_p = R_p
the length of the arc in its field of view.

Ours: r_p(j) - R_C counts as 0 where it is below; a delay is at least a step.

Source: Wen & Horiuchi 2022, sections 3 and 4.2, equations (7) and (8).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.errors import ParameterError
from system.openspace.law import ARCS, DIRECTIONS, Arcs
from system.openspace.view import blocked_at
from system.spiking_bat.network.network import STEP
from system.spiking_bat.numbers import SOUND, Numbers

RANGES, RANGE_STEP = 25, 0.2  # m
ANGLES, ANGLE_STEP_DEG = 31, 4.0


class Blocking(NamedTuple):
    """Which places block which arcs: direction of the map, place, arc, int64[n]; delay (7), s, float64[n]."""

    direction: I64
    place: I64
    arc: I64
    delay: F64


def places() -> F64:
    """Return the places of a map's neurons, float64[471, 2], m ahead along the ping and to its left.

    They are ordered angle by angle.
    """
    found = []
    for k in range(ANGLES):
        theta = ANGLE_STEP_DEG * (k - ANGLES // 2)
        count = math.ceil(RANGES * math.exp(-(theta**2) / 1800.0))
        reach = RANGE_STEP * np.arange(1, count + 1)
        found.append(reach[:, None] * [math.cos(math.radians(theta)), math.sin(math.radians(theta))])
    return np.concatenate(found)


def echo_delay(distance: F64 | float) -> F64:
    """Return the delay (s) of an echo from a distance (m)."""
    return np.asarray(2.0 * np.asarray(distance) / SOUND)


def nearest_place(seen: F64, at: F64) -> I64:
    """Neuron of a map whose place is nearest to each of the seen obstacles, float64[n, 2]; int64[n]."""
    apart = ((seen[:, None, :] - at[None, :, :]) ** 2).sum(axis=2)
    return np.asarray(apart.argmin(axis=1), dtype=np.int64)


def blocking(arcs: Arcs, at: F64, constant_delay: float) -> Blocking:
    """All pairs of a place and an arc that it blocks, with the delay of equation (7).

    Raises `ParameterError` for a T_C (s) so small that a delay would be below a step.
    """
    direction, place, arc, delay = [], [], [], []
    echo = echo_delay(np.hypot(*at.T))
    for d in range(DIRECTIONS):
        x, y = _turned(at, float(arcs.direction[d]))
        for p in range(ARCS):
            for j in range(len(at)):
                s = _way(arcs, p, float(x[j]), float(y[j]))
                if s < 0.0:
                    continue
                direction.append(d)
                place.append(j)
                arc.append(p)
                delay.append(latency(arcs, p, s, constant_delay) - float(echo[j]))
    least = min(delay)
    if least < STEP:
        raise ParameterError(
            f"numbers.constant_delay: {constant_delay:g} s, makes an added delay of {least:.3g} s, must be at"
            f" least {constant_delay + STEP - least:.3g} s"
        )
    return Blocking(*(np.array(each) for each in (direction, place, arc, delay)))


def latency(arcs: Arcs, p: int, way: float, constant_delay: float) -> float:
    """Latency of equation (8) of an obstacle at `way` m along arc p, s."""
    longest = float(echo_delay(arcs.max_range))
    return longest * max(way - arcs.zone, 0.0) / float(arcs.length[p]) + constant_delay


def longest_latency(arcs: Arcs, numbers: Numbers) -> tuple[float, float]:
    """Longest echo delay, and the longest latency that a memory has to store, s.

    The latter is that of one obstacle alone at the far end of an arc: equation (8), then equation (9).
    """
    echo = float(echo_delay(arcs.max_range))
    return echo, echo + numbers.constant_delay + numbers.integration


def _turned(at: F64, angle: float) -> tuple[F64, F64]:
    """Places of a map whose ping goes `angle` rad to the left, in the body's frame."""
    cos, sin = math.cos(angle), math.sin(angle)
    return cos * at[:, 0] - sin * at[:, 1], sin * at[:, 0] + cos * at[:, 1]


def _way(arcs: Arcs, p: int, x: float, y: float) -> float:
    end_x, end_y = float(arcs.end[p, 0]), float(arcs.end[p, 1])
    return blocked_at(float(arcs.curvature[p]), float(arcs.length[p]), end_x, end_y, x, y, arcs.zone)
