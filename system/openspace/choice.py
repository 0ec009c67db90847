"""Memory and choice of Curved Openspace, of bat and car alike: Wen & Horiuchi 2022, section 2.

    M_p <- max(M_p - I_d - I_inh [p in the ping's direction], min(f_p, E_MAX))                  equation (4)
    D_p = D_0p + H_pq + P [p in the head's direction] + G exp(-(p - p_g)^2 / sigma_g^2)
          - sum_q W exp(-(p - q)^2 / sigma_m^2) M_q                                             equation (6)

f_p is the immediacy that a ping shows along arc p, q the arc that is held, p_g the goal's.
"""

from __future__ import annotations

import math

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled
from system.live.signals import Channel, Signals

SIGNED = (  # numbers of the law that may be negative
    "sharp_turn_cost", "emergency_below", "goal_gain", "ping_bias", "hysteresis", "decay", "inhibition",
)  # fmt: skip

_compiled = compiled()


def arc_actions(arcs: int, directions: int, third: str) -> Signals:
    """Actions of what goes by arcs, step by step: an arc, the next ping's direction, and a yes or no."""
    return Signals(
        (
            Channel("arc, from the left", "", 0, arcs - 1),
            Channel("direction of the next ping, from the left", "", 0, directions - 1),
            Channel(third, "", 0, 1),
        ),
        "whole",
    )


def falling(weight: float, sigma: float, arcs: int) -> F64:
    """W exp(-(p - q)^2 / sigma^2) of equation (6), float64[arcs, arcs]; sigma: counted in arcs."""
    place = np.arange(arcs, dtype=np.float64)
    return np.asarray(weight * np.exp(-((place[:, None] - place[None, :]) ** 2) / sigma**2))


def ping_directions(step: float, directions: int) -> F64:
    """Directions of pings, `step` rad apart about straight ahead, the leftmost first, float64[directions]."""
    return np.asarray(step * (directions // 2 - np.arange(directions, dtype=np.float64)))


def grouped(reach: F64, direction: F64) -> tuple[F64, I64]:
    """Length R_p in view (m) and ping direction of each arc, float64[arcs] and int64[arcs].

    reach: float64[arcs, directions], m, in view of a ping in each direction. An arc belongs to the direction
    in whose view it is longest, of two to the one nearer the middle.
    """
    # directions in the order of their nearness to the middle: argmax takes the first of equals
    order = np.argsort(np.abs(direction), kind="stable")
    group = order[np.argmax(reach[:, order], axis=1)]
    return reach[np.arange(len(reach)), group], group


@_compiled
def remember(
    risk: F64, fresh: F64, group: I64, head: int, decay: float, inhibition: float, max_risk: float
) -> None:
    """Equation (4) in place, after a ping in the direction `head` has shown `fresh`, float64[arcs]."""
    for p in range(risk.size):
        old = risk[p] - decay - (inhibition if group[p] == head else 0.0)
        risk[p] = max(old, min(fresh[p], max_risk))


@_compiled
def aimed_arc(bearing: float, arcs_per_rad: float, arcs: int) -> float:
    """p_g, which need not be whole, of a goal at a bearing (rad) to the left of straight ahead."""
    bearing -= 2.0 * math.pi * math.floor(bearing / (2.0 * math.pi) + 0.5)
    return min(max(arcs // 2 - bearing * arcs_per_rad, 0.0), arcs - 1.0)


@_compiled
def excite(wish: F64, bias: F64, held: F64, group: I64, head: int, ping_bias: float) -> None:
    """Terms of equation (6) without goal and memory into `wish`, float64[arcs].

    held: float64[arcs], the hysteresis of the arc that is held.
    """
    for p in range(wish.size):
        wish[p] = bias[p] + held[p] + (ping_bias if group[p] == head else 0.0)


@_compiled
def add_goal(wish: F64, aim: float, goal_gain: float, goal_sigma: float) -> None:
    """Add the goal's term of equation (6), by the recurrence of a Gaussian from the arc nearest to p_g."""
    nearest = int(aim + 0.5)
    apart, width = nearest - aim, goal_sigma * goal_sigma
    top = goal_gain * math.exp(-apart * apart / width)
    shrink = math.exp(-2.0 / width)
    factor, value = math.exp(-(2.0 * apart + 1.0) / width), top
    for p in range(nearest, wish.size):
        wish[p] += value
        value *= factor
        factor *= shrink
    factor, value = math.exp((2.0 * apart - 1.0) / width), top
    for p in range(nearest - 1, -1, -1):
        value *= factor
        factor *= shrink
        wish[p] += value


@_compiled
def inhibit(wish: F64, risk: F64, spread: F64) -> None:
    """The memory's term of equation (6), taken from `wish`, float64[arcs]."""
    for q in range(risk.size):
        if risk[q] == 0.0:
            continue
        for p in range(wish.size):
            wish[p] -= risk[q] * spread[q, p]


@_compiled
def best(wish: F64) -> int:
    """Return the number of the arc with the largest desirability, the first of equals."""
    first = 0
    for p in range(1, wish.size):
        if wish[p] > wish[first]:
            first = p
    return first
