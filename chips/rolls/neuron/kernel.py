"""Compiled steps of the behavioural model of ROLLS' neuron, for many neurons side by side.

A step is cut into parts in which v_mem moves by 3 mV at most, each by the midpoint rule. Tables over v_mem
are read by a cubic, so that a near balance of currents is kept: at a low rate v_mem lingers where they cancel
to a thousandth. `chips.rolls.synapse.kernel` steps the synapses' filters.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.network import pair_share
from circuits.arrays import F64, I64
from circuits.compiled import compiled

GRID = 257  # points of a table over v_mem
LARGEST = 3e-3  # V, by which v_mem moves in a part of a step; ours
V_MEM, V_AHP, WAIT = range(3)  # columns of a neuron's state: V, V, s of the refractory period left
NEURON_COLUMNS = 3
# Columns of the table over v_mem: I_0, A; I_dc + I_gate, A; e^((b - a) / 2) of the pair's pinch-off voltages;
# 1 - e^(-v / U_T); what more v_o1 lets into the adaptation's pair, over C_ahp, V/s
STATIC, INJECTED, RATIO, REVERSE, APPROACH = range(5)
COLUMNS = 5
WEAK = 0.25  # share of a specific current of the pair up to which its law is taken as a fraction


class Neurons(NamedTuple):
    """Neurons on a die, float64[n] each unless said, in SI units."""

    u_t: F64
    top: F64  # v_mem at which the neuron spikes, end of its tables, V
    table: F64  # float64[n, GRID, COLUMNS] over v_mem, see the columns below
    ground_current: F64  # of the leak's pair: specific currents, A, and pinch-off voltages in U_T
    ground_pinch: F64
    membrane_current: F64
    membrane_pinch: F64  # at v_mem = 0
    kappa_p: F64
    inside: F64  # float64[n, GRID]: pinch-off voltage of the membrane's device over v_mem, U_T
    capacitance: F64  # F, fixed part
    input_linear: F64  # F, times the share
    input_square: F64  # F, times the share squared
    quiet: F64  # float64[n, GRID]: dv_ahp/dt over v_ahp without a spike, V/s
    share: F64  # float64[n, GRID]: share of a spike's current that the adaptation's pair passes, over v_ahp
    taken: F64  # float64[n, GRID]: that of its whole charge, over v_ahp before it
    drawn: F64  # float64[n, GRID]: I_ahp over v_ahp, A
    ahp_step: F64  # V between points of the last four
    delay: F64  # s, of a spike after v_mem has come to `top` with delay_speed
    delay_speed: F64  # V/s
    delay_exponent: F64
    refractory: F64  # s, after the spike
    kick: F64  # V, of v_ahp where all of a spike's current enters


def weak_share(m: Neurons) -> F64:
    """Return the share of a weak input that enters the membrane, at the tables' points, float64[n, GRID]."""
    ratio = m.table[:, :, RATIO] ** 2
    first, second = m.ground_current[:, None], m.membrane_current[:, None]
    return np.asarray(second * ratio / (first + second * ratio))


_compiled = compiled(fastmath={"contract"})
# part of every step, so that arguments are not copied from function to function
_inlined = compiled(fastmath={"contract"}, forceinline=True)


@_inlined
def _cubic(row: F64, x: float) -> float:
    """Table at position x (in points), by the cubic through the four nearest; linear beyond the ends."""
    last = row.size - 1
    if x <= 0.0:
        return float(row[0] + (row[1] - row[0]) * x)
    i = min(max(int(x), 1), last - 2)
    t = x - i
    a, b, c, d = row[i - 1], row[i], row[i + 1], row[i + 2]
    bend = c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a))
    return float(b + 0.5 * t * bend)


@_inlined
def _row(m: Neurons, k: int, v: float) -> tuple[float, float, float, float]:
    """Static and injected current, ratio and reverse at v_mem, by one cubic."""
    x = v * (GRID - 1) / m.top[k]
    table = m.table[k]
    i = min(max(int(x), 1), GRID - 3)
    t = x - i
    u = 0.5 * t
    a, d = u * (t * (2.0 - t) - 1.0), u * t * (t - 1.0)
    b, c = 1.0 + u * t * (3.0 * t - 5.0), u * (1.0 + t * (4.0 - 3.0 * t))
    p, q, r, s = table[i - 1], table[i], table[i + 1], table[i + 2]
    return (
        a * p[STATIC] + b * q[STATIC] + c * r[STATIC] + d * s[STATIC],
        a * p[INJECTED] + b * q[INJECTED] + c * r[INJECTED] + d * s[INJECTED],
        a * p[RATIO] + b * q[RATIO] + c * r[RATIO] + d * s[RATIO],
        a * p[REVERSE] + b * q[REVERSE] + c * r[REVERSE] + d * s[REVERSE],
    )


@_inlined
def _log1p(z: float) -> float:
    """`ln(1 + z)` by its Pade fraction [2/2], 1e-5 off at z = 0.6."""
    return z * (6.0 + 3.0 * z) / (6.0 + z * (6.0 + z))


@_inlined
def _shared(m: Neurons, k: int, v: float, ratio: float, total: float) -> float:
    """Part of `total` (A) that the pair lets into the membrane, A.

    With z = e^(w / 2), w the common source, both currents are I_S ln^2(1 + z), the second's z times `ratio`:
    two Newton steps from where weak inversion has them.
    """
    i1, i2 = m.ground_current[k], m.membrane_current[k]
    if total <= 0.0:
        return 0.0
    if total > WEAK * i1 or total > WEAK * i2:
        b = m.membrane_pinch[k] - m.kappa_p[k] * v / m.u_t[k]
        return float(pair_share(i1, m.ground_pinch[k], i2, b, total))
    square = i1 + i2 * ratio * ratio
    z = math.sqrt(total / square)
    # each one's ln(1 + z) is z - z^2 / 2
    z *= 1.0 + 0.5 * z * (i1 + i2 * ratio**3) / square
    second = 0.0
    for _ in range(2):
        y = ratio * z
        first, second = _log1p(z), _log1p(y)
        over = i1 * first * first + i2 * second * second - total
        slope = 2.0 * (i1 * first / (1.0 + z) + i2 * second * ratio / (1.0 + y))
        z -= over / slope
        second += -over / slope * ratio / (1.0 + y)
    return float(i2 * second * second)


@_inlined
def _slope(m: Neurons, k: int, v: float, ahp: float, current: float) -> float:
    """dv_mem/dt, V/s; ahp: I_ahp, A."""
    static, injected, ratio, reverse = _row(m, k, v)
    total = current + injected
    shared = _shared(m, k, v, ratio, total)
    share = shared / total if total > 0.0 else 0.0
    c = m.capacitance[k] + share * (m.input_linear[k] + share * m.input_square[k])
    return float((static + shared - ahp * reverse) / c)


@_compiled
def advance_neurons(
    m: Neurons, state: F64, current: F64, now: float, step: float, times: F64, counts: I64
) -> None:
    """Advance every neuron by `step` s from `now`; current: float64[n], A, into i_in.

    times: float64[n, room], s, of spikes, counts: int64[n], how many each neuron has had.
    """
    for k in range(m.top.size):
        s = state[k]
        left = step
        while left > 0.0:
            h = left
            if s[WAIT] > 0.0:
                h = min(left, s[WAIT])
                s[WAIT] -= h
                if s[WAIT] < 1e-15:
                    s[WAIT] = 0.0
                _adapt(m, k, s, h, 0.0)
                left -= h
                continue
            ahp = _cubic(m.drawn[k], s[V_AHP] / m.ahp_step[k])
            rate = _slope(m, k, s[V_MEM], ahp, current[k])
            if abs(rate) * h > LARGEST:
                h = LARGEST / abs(rate)
            # the midpoint rule
            rate = _slope(m, k, s[V_MEM] + 0.5 * h * rate, ahp, current[k])
            v = s[V_MEM] + h * rate
            if v >= m.top[k]:
                h *= (m.top[k] - s[V_MEM]) / (v - s[V_MEM])
                delay = m.delay[k] * (rate / m.delay_speed[k]) ** -m.delay_exponent[k]
                if counts[k] < times.shape[1]:
                    times[k, counts[k]] = now + step - left + h + delay
                counts[k] += 1
                _adapt(m, k, s, h, 0.5 * (s[V_MEM] + m.top[k]))
                s[V_AHP] += m.kick[k] * _cubic(m.taken[k], s[V_AHP] / m.ahp_step[k])
                s[V_MEM] = 0.0
                s[WAIT] = delay + m.refractory[k]
            else:
                _adapt(m, k, s, h, 0.5 * (s[V_MEM] + v))
                s[V_MEM] = v
            left -= h


@_inlined
def _adapt(m: Neurons, k: int, s: F64, h: float, v: float) -> None:
    """v_ahp over h s without a spike, v_mem being `v` half-way."""
    a = s[V_AHP]
    grid = m.ahp_step[k]
    more = _cubic(m.table[k, :, APPROACH], v * (GRID - 1) / m.top[k]) * _cubic(m.share[k], a / grid)
    rate = _cubic(m.quiet[k], a / grid) + more
    # its slope over a hundredth of a point: the leak makes it stiff near 0 V
    bend = (_cubic(m.quiet[k], a / grid + 0.01) + more - rate) / (0.01 * grid)
    x = bend * h
    # (e^x - 1) / x by its Pade fraction [0/2]
    s[V_AHP] = a + rate * h / (1.0 + x * (x / 12.0 - 0.5))


@_compiled
def rest_of(m: Neurons, state: F64) -> None:
    """Fill the rest without input: v_ahp without current, v_mem where its current changes sign, or `top`."""
    for k in range(m.top.size):
        low, high = 0.0, m.ahp_step[k] * (GRID - 1)
        for _ in range(50):
            middle = 0.5 * (low + high)
            if _cubic(m.quiet[k], middle / m.ahp_step[k]) > 0.0:
                low = middle
            else:
                high = middle
        state[k, V_AHP] = low
        ahp = _cubic(m.drawn[k], low / m.ahp_step[k])
        point = 0
        while point < GRID and _slope(m, k, point * m.top[k] / (GRID - 1), ahp, 0.0) > 0.0:
            point += 1
        low, high = max(point - 1, 0) * m.top[k] / (GRID - 1), point * m.top[k] / (GRID - 1)
        for _ in range(50):
            middle = 0.5 * (low + high)
            if _slope(m, k, middle, ahp, 0.0) > 0.0:
                low = middle
            else:
                high = middle
        # where its current is positive up to the top it has no rest
        state[k, V_MEM] = low if point < GRID else m.top[k]
        state[k, WAIT] = 0.0
