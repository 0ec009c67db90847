"""Compiled equations of the rebound neuron's behavioural model.

States: v_mem, v_r, v_ex. With C the capacitance matrix of these nodes in the circuit (parasitics and overlaps
included, other nodes held), the devices' EKV currents and q(x) = ln(1 + e^x):

    C d(v_mem, v_r, v_ex)/dt = (I_rslope + I_me5 - I_m1, I_rtau - I_m2, I_me4)
    I_m1 = I_S [q((v_p - v_rest)/2U_T)^2 - q((v_p - v_mem)/2U_T)^2],  v_p = kappa_n (v_r - V_T0)
    I_m2 = I_S q((kappa_p (V_dd - v_mem - V_T0) - V_dd + v_r)/2U_T)^2
    I_me5 = I_S q(kappa_p (V_dd - v_ex - V_T0)/2U_T)^2
    I_me4 = I_S [q(v_p4/2U_T)^2 - q((v_p4 - V_dd + v_ex)/2U_T)^2]

While the call inhibits and while a spike resets, v_mem is held at v_held; for 10 us of an echo v_ex is held
at v_ex_max. The axon fires when w reaches `axon_charge`, w' = v_mem - v_threshold, w >= 0. The same w for the
threshold moved by the margin either way tells what is too near to call.

Stepped by RODAS3 (Sandu, Verwer, Blom, Spee, Carmichael, Potra 1997), four stages, order 3(2), L-stable.
Where the error of a step outgrows the last one's, the next is shortened in advance (Gustafsson 1994).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from circuits.compiled import compiled
from circuits.devices.softplus import softplus_five

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
Three = tuple[float, float, float]
Nine = tuple[float, float, float, float, float, float, float, float, float]

TOLERANCE = 1e-4  # V, local error of a step; ours: moves a peak by up to 0.35 mV, inside the measured margin
ECHO_HELD = (0.05e-6, 10.15e-6)  # s, half-supply crossings of an event's pulse
# First steps, s, after v_mem is pulled low, after it is let go, and after an echo's pulse begins or ends. The
# last is short: v_ex keeps its errors, and 0.1 mV of it is some millivolts of a later peak of v_mem.
_PULLED_STEP, _RELEASED_STEP, _EXCITED_STEP = 5e-8, 4e-9, 1e-6
_SAFETY = 0.9  # of the step that the error allows
_LEEWAY = 100.0  # largest ratio of the tolerance to an error that the next step is judged by
_NO_STEP = 1e-30  # s, before the first one
_HALVINGS = 40  # of the supply: far below a nanovolt
_PARTS = 8  # of a step, over which w is summed
_LOOKAHEAD = 2e-3  # s, for which a spike's certainty is looked for beyond it
SETTLED = 0.1  # V/s, of every node: nothing happens any more
_FALLEN = 0.1  # V below the threshold, from which v_mem falls on to rest while v_r and v_ex only rise
_RECOVERED = 20e-3  # V, of v_ex below the supply: less excitation than the coupling of v_mem makes

# Columns of a state.
V_MEM, V_R, V_EX, NOW, STEP, CHARGE, CHARGE_LOW, NEAR, RELEASE, RESET_END, ECHO_START, ECHO_END, ECHO_LEVEL, \
    UNDECIDED, PEAK, DOZE = range(16)  # fmt: skip
COLUMNS = 16
WAKE, MAY_DOZE, DOZING = 0.0, 1.0, 2.0  # a neuron that may doze stops where it only falls back to rest

CLASSES = ("works", "call-alone", "echo-alone", "never", "rest-fires")
WORKS, CALL_ALONE, ECHO_ALONE, NEVER, REST_FIRES = range(5)


class Neurons(NamedTuple):
    """n neurons, float64[n] each unless said; SI units."""

    inverse_2ut: F64  # 1 / (2 U_T), 1/V
    kappa_n: F64
    kappa_p: F64
    v_dd: F64
    v_rest: F64
    v_ex_max: F64
    m1_current: F64  # specific currents, A, and thresholds, V, of this die's devices
    m1_threshold: F64
    m2_current: F64
    m2_threshold: F64
    me4_current: F64
    me4_pinch: F64  # v_p of me4 from its gate, V
    me4_forward: F64  # its current in saturation, A
    me5_current: F64
    me5_threshold: F64
    i_rslope: F64  # A, off currents of the two reset transistors taken away
    i_rtau: F64
    t_inh: F64  # s
    v_threshold: F64  # V, v_mem at which the comparator balances
    axon_charge: F64  # V s
    pulse_width: F64  # s, of a spike
    v_held: F64  # V, to which inhibition and reset pull v_mem against m1
    echo_step: F64  # V, of v_ex when an echo's pulse ends
    margin: F64  # V, within which a threshold is too near to call
    rebound_bound: F64  # s, C_r V_dd / I_rtau, of the nominal device or, where it is smaller, of this one
    inverse_capacitance: F64  # float64[4, 3, 3], 1/F: by what is held (1: v_mem, 2: v_ex)
    follow: F64  # float64[3, 3]: step of a free node (row) for one of a held node (column)


class Numbers(NamedTuple):
    """What the equations of one neuron need, with C^-1 apart: the arguments of q are linear in the voltages.

    g, gn, gp: 1 / (2 U_T), times kappa_n, times kappa_p, 1/V; rest to me4: constant parts of the arguments of
    m1 (source at v_rest, at v_mem), m2, me5, me4; i_m1 to i_me4: specific currents, forward to i_rtau:
    constant ones, A.
    """

    g: float
    gn: float
    gp: float
    rest: float
    m1: float
    m2: float
    me5: float
    me4: float
    i_m1: float
    i_m2: float
    i_me5: float
    i_me4: float
    forward: float
    i_rslope: float
    i_rtau: float


_compiled = compiled(fastmath={"contract"})
# part of every step, so that arguments are not copied from function to function
_inlined = compiled(fastmath={"contract"}, forceinline=True)


@_inlined
def _numbers(m: Neurons, k: int) -> Numbers:
    g, vdd = m.inverse_2ut[k], m.v_dd[k]
    gn, gp = g * m.kappa_n[k], g * m.kappa_p[k]
    return Numbers(
        g, gn, gp, gn * m.m1_threshold[k] + g * m.v_rest[k], gn * m.m1_threshold[k],
        gp * (vdd - m.m2_threshold[k]) - g * vdd, gp * (vdd - m.me5_threshold[k]), g * (m.me4_pinch[k] - vdd),
        m.m1_current[k], m.m2_current[k], m.me5_current[k], m.me4_current[k], m.me4_forward[k], m.i_rslope[k],
        m.i_rtau[k],
    )  # fmt: skip


@_inlined
def _matrix(m: Neurons, mode: int) -> Nine:
    c = m.inverse_capacitance[mode]
    return c[0, 0], c[0, 1], c[0, 2], c[1, 0], c[1, 1], c[1, 2], c[2, 0], c[2, 1], c[2, 2]


@_compiled
def _softplus(x: float) -> float:
    """`ln(1 + e^x)`."""
    return max(x, 0.0) + math.log1p(math.exp(-abs(x)))


@_inlined
def _currents(p: Numbers, v: float, r: float, x: float) -> Nine:
    """Currents into v_mem, v_r, v_ex (A) and their derivatives (S).

    Order: i_mem, i_r, i_ex, di_mem/dv, di_mem/dr, di_mem/dx, di_r/dv, di_r/dr, di_ex/dx.
    """
    a, b, c, e, q, da, db, dc, de, dq = softplus_five(
        p.gn * r - p.rest, p.gn * r - p.g * v - p.m1, p.g * r - p.gp * v + p.m2, p.me5 - p.gp * x,
        p.g * x + p.me4,
    )  # fmt: skip
    ja, jb, jc = p.i_m1 * a * da, p.i_m1 * b * db, 2.0 * p.i_m2 * c * dc
    return (
        p.i_rslope + p.i_me5 * e * e - p.i_m1 * (a - b) * (a + b),
        p.i_rtau - p.i_m2 * c * c,
        p.forward - p.i_me4 * q * q,
        -2.0 * p.g * jb,
        -2.0 * p.gn * (ja - jb),
        -2.0 * p.gp * p.i_me5 * e * de,
        p.gp * jc,
        -p.g * jc,
        -2.0 * p.g * p.i_me4 * q * dq,
    )


@_compiled
def excitation(m: Neurons, k: int, s: F64) -> float:
    """Rate at which me5 raises a free v_mem, V/s."""
    e = _softplus(m.kappa_p[k] * (m.v_dd[k] - s[V_EX] - m.me5_threshold[k]) * m.inverse_2ut[k])
    return float(m.me5_current[k] * e * e * m.inverse_capacitance[0, 0, 0])


@_inlined
def _rates(c: Nine, i: Nine) -> Three:
    """dv/dt of the three nodes, V/s; zero for a held node."""
    return (
        c[0] * i[0] + c[1] * i[1] + c[2] * i[2],
        c[3] * i[0] + c[4] * i[1] + c[5] * i[2],
        c[6] * i[0] + c[7] * i[1] + c[8] * i[2],
    )


@_inlined
def _inverse(c: Nine, h: float, i: Nine) -> Nine:
    """Inverse of `2/h - C^-1 dI/dv`, row by row."""
    d = 2.0 / h
    a00 = d - (c[0] * i[3] + c[1] * i[6])
    a01 = -(c[0] * i[4] + c[1] * i[7])
    a02 = -(c[0] * i[5] + c[2] * i[8])
    a10 = -(c[3] * i[3] + c[4] * i[6])
    a11 = d - (c[3] * i[4] + c[4] * i[7])
    a12 = -(c[3] * i[5] + c[5] * i[8])
    a20 = -(c[6] * i[3] + c[7] * i[6])
    a21 = -(c[6] * i[4] + c[7] * i[7])
    a22 = d - (c[6] * i[5] + c[8] * i[8])
    b00 = a11 * a22 - a12 * a21
    b10 = a12 * a20 - a10 * a22
    b20 = a10 * a21 - a11 * a20
    p = 1.0 / (a00 * b00 + a01 * b10 + a02 * b20)
    return (
        p * b00, p * (a02 * a21 - a01 * a22), p * (a01 * a12 - a02 * a11),
        p * b10, p * (a00 * a22 - a02 * a20), p * (a02 * a10 - a00 * a12),
        p * b20, p * (a01 * a20 - a00 * a21), p * (a00 * a11 - a01 * a10),
    )  # fmt: skip


@_inlined
def _solve(f: Nine, b0: float, b1: float, b2: float) -> Three:
    return (
        f[0] * b0 + f[1] * b1 + f[2] * b2,
        f[3] * b0 + f[4] * b1 + f[5] * b2,
        f[6] * b0 + f[7] * b1 + f[8] * b2,
    )


@_inlined
def _step(p: Numbers, matrix: Nine, h: float, y: Three, i: Nine) -> tuple[Three, float]:
    """One RODAS3 step of `h` s from y, whose currents are i; returns the new y and its error, V."""
    d = _rates(matrix, i)
    f = _inverse(matrix, h, i)
    a = _solve(f, d[0], d[1], d[2])
    g = 4.0 / h
    b = _solve(f, d[0] + g * a[0], d[1] + g * a[1], d[2] + g * a[2])
    i = _currents(p, y[0] + 2.0 * a[0], y[1] + 2.0 * a[1], y[2] + 2.0 * a[2])
    d = _rates(matrix, i)
    g = 1.0 / h
    c = _solve(f, d[0] + g * (a[0] - b[0]), d[1] + g * (a[1] - b[1]), d[2] + g * (a[2] - b[2]))
    n = (y[0] + 2.0 * a[0] + c[0], y[1] + 2.0 * a[1] + c[1], y[2] + 2.0 * a[2] + c[2])
    i = _currents(p, n[0], n[1], n[2])
    d = _rates(matrix, i)
    w = 8.0 / 3.0
    z = _solve(
        f,
        d[0] + g * (a[0] - b[0] - w * c[0]),
        d[1] + g * (a[1] - b[1] - w * c[1]),
        d[2] + g * (a[2] - b[2] - w * c[2]),
    )
    return (n[0] + z[0], n[1] + z[1], n[2] + z[2]), max(abs(z[0]), abs(z[1]), abs(z[2]))


class Pull(NamedTuple):
    """What pulls v_mem low, n neurons: float64[n], specific currents, A, and voltages; V where not said."""

    v_rest: F64
    m1_current: F64
    m1_threshold: F64
    mi12_current: F64
    mi12_pinch: F64  # v_p with its gate at the supply
    v_r: F64  # v_r - kappa_p v_mem while m2 carries I_rtau
    i_rslope: F64


@_compiled
def pull_low(p: Pull, u_t: float, kappa_n: float, kappa_p: float, out: F64) -> None:
    """v_mem at which mi12 sinks I_rslope and what m1 brings from v_rest, bisected, V; out: float64[n]."""
    for k in range(out.size):
        low, high = 0.0, p.v_rest[k]
        for _ in range(_HALVINGS):
            v = 0.5 * (low + high)
            pinch = kappa_n * (p.v_r[k] + kappa_p * v - p.m1_threshold[k])
            brought = (
                _softplus(0.5 * (pinch - v) / u_t) ** 2 - _softplus(0.5 * (pinch - p.v_rest[k]) / u_t) ** 2
            )
            full = p.mi12_pinch[k]
            sunk = _softplus(0.5 * full / u_t) ** 2 - _softplus(0.5 * (full - v) / u_t) ** 2
            if p.mi12_current[k] * sunk < p.m1_current[k] * brought + p.i_rslope[k]:
                low = v
            else:
                high = v
        out[k] = 0.5 * (low + high)


@_compiled
def copy_state(source: F64, target: F64) -> None:
    """Copy the columns of a neuron."""
    for i in range(source.size):
        target[i] = source[i]


@_compiled
def _hold(m: Neurons, s: F64, column: int, level: float) -> None:
    """Move a node to a level; the free ones follow through the coupling capacitances."""
    move = level - s[column]
    s[column] = level
    for row in range(3):
        if row != column:
            s[row] += m.follow[row, column] * move


@_compiled
def begin(m: Neurons, k: int, s: F64, time: float) -> float:
    """Rest state into `s`; returns the distance of v_mem from the threshold, V (above 0: no rest)."""
    v, r = m.v_rest[k], m.v_rest[k] + 1.0
    x = m.v_dd[k]
    numbers = _numbers(m, k)
    for _ in range(200):
        i = _currents(numbers, v, r, x)
        determinant = i[3] * i[7] - i[4] * i[6]
        dv = (i[0] * i[7] - i[4] * i[1]) / determinant
        dr = (i[3] * i[1] - i[6] * i[0]) / determinant
        v -= min(max(dv, -0.05), 0.05)
        r -= min(max(dr, -0.05), 0.05)
        if abs(dv) + abs(dr) < 1e-9:
            break
    s[:] = 0.0
    s[V_MEM], s[V_R], s[V_EX], s[NOW], s[STEP] = v, r, x, time, _EXCITED_STEP
    s[RELEASE], s[RESET_END] = -np.inf, -np.inf
    s[ECHO_START], s[ECHO_END] = np.inf, -np.inf
    s[PEAK] = -np.inf
    above: float = v - m.v_threshold[k]
    return above


@_compiled
def call(m: Neurons, k: int, s: F64) -> None:
    """A call now: v_mem is held low for t_inh."""
    s[RELEASE] = s[NOW] + m.t_inh[k]
    s[CHARGE], s[CHARGE_LOW] = 0.0, 0.0
    _hold(m, s, V_MEM, m.v_held[k])
    s[STEP] = _PULLED_STEP


@_compiled
def echo(m: Neurons, k: int, s: F64, level: float) -> None:
    """An echo now: v_ex is held at `level` (V) while the pulse lasts."""
    s[ECHO_START], s[ECHO_END] = s[NOW] + ECHO_HELD[0], s[NOW] + ECHO_HELD[1]
    s[ECHO_LEVEL] = level


@_compiled
def advance(m: Neurons, k: int, s: F64, until: float) -> float:
    """Advance `s` to `until` (s) or to the first spike; returns its time, else inf."""
    while s[NOW] < until:
        t = s[NOW]
        stop = until
        for column in (RELEASE, RESET_END, ECHO_START, ECHO_END):
            if t < s[column] < stop:
                stop = s[column]
        held = t < s[RELEASE] or t < s[RESET_END]
        mode = (1 if held else 0) + (2 if s[ECHO_START] <= t < s[ECHO_END] else 0)
        spike = _integrate(m, k, mode, s, stop)
        if spike < np.inf:
            _hold(m, s, V_MEM, m.v_held[k])
            s[RESET_END] = spike + m.pulse_width[k]
            s[CHARGE], s[CHARGE_LOW], s[NEAR], s[STEP] = 0.0, 0.0, 0.0, _PULLED_STEP
            return spike
        if s[DOZE] == DOZING:
            return np.inf
        s[NOW] = stop
        if stop == s[RELEASE] or stop == s[RESET_END]:
            s[STEP] = _RELEASED_STEP
        if stop == s[ECHO_START]:
            _hold(m, s, V_EX, s[ECHO_LEVEL])
            if held:
                s[V_MEM] = m.v_held[k]
            s[STEP] = _EXCITED_STEP
        if stop == s[ECHO_END]:
            s[V_EX] += m.echo_step[k]
            s[STEP] = _EXCITED_STEP
    return np.inf


@_compiled
def _integrate(m: Neurons, k: int, mode: int, s: F64, stop: float) -> float:  # noqa: C901, PLR0912, PLR0915 - one loop with its scalars
    """Integrate in one mode to `stop` or to a spike (its time, else inf)."""
    y = (s[V_MEM], s[V_R], s[V_EX])
    t, h = s[NOW], s[STEP]
    numbers, matrix = _numbers(m, k), _matrix(m, mode)
    i = _currents(numbers, y[0], y[1], y[2])
    d = _rates(matrix, i)
    threshold, enough, margin = m.v_threshold[k], m.axon_charge[k], m.margin[k]
    charge, low, high, near = s[CHARGE], s[CHARGE_LOW], 0.0, s[NEAR]
    spike, end = np.inf, stop
    kept = y
    earlier_step, earlier_room = _NO_STEP, 1.0
    while t < end:
        if spike == np.inf and max(abs(d[0]), abs(d[1]), abs(d[2])) < SETTLED and y[0] < threshold - 0.05:
            break
        last = h >= end - t
        step = min(h, end - t)
        n, error = _step(numbers, matrix, step, y, i)
        room = TOLERANCE / max(error, 1e-12)
        if not error <= TOLERANCE:
            h = step * (max(_SAFETY * np.cbrt(room), 0.1) if error > TOLERANCE else 0.1)  # else a NaN
            continue
        i = _currents(numbers, n[0], n[1], n[2])
        e = _rates(matrix, i)
        if mode & 1 == 0:
            s[PEAK] = max(s[PEAK], n[0])
            top = max(y[0], n[0]) + 0.15 * step * max(d[0] - e[0], 0.0)
            if top > threshold - margin or low > 0.0:
                part, before = step / _PARTS, y[0]
                for j in range(1, _PARTS + 1):
                    z = j / _PARTS
                    after = _hermite(z, step, y[0], n[0], d[0], e[0])
                    s[PEAK] = max(s[PEAK], after)
                    mean = 0.5 * (before + after) - threshold
                    if spike == np.inf:
                        grown = max(charge + part * mean, 0.0)
                        low = max(low + part * (mean + margin), 0.0)
                        if low >= enough:
                            near = 1.0
                        elif low == 0.0 and near > 0.0:
                            s[UNDECIDED] += 1.0
                            near = 0.0
                        high = max(high + part * (mean - margin), 0.0)
                        if grown >= enough:
                            share = (enough - charge) / (grown - charge)
                            spike = t + step * (z - (1.0 - share) / _PARTS)
                            kept = (before + share * (after - before), n[1], n[2])
                            end = spike + _LOOKAHEAD
                        charge = grown
                    else:
                        high = max(high + part * (mean - margin), 0.0)
                    before = after
                if spike < np.inf and (high >= enough or n[0] < threshold - margin):
                    break
            else:
                charge, low, high = 0.0, 0.0, 0.0
                if near > 0.0:
                    s[UNDECIDED] += 1.0
                    near = 0.0
        t += step
        y, d = n, e
        if s[DOZE] == MAY_DOZE and spike == np.inf and _falls_back(m, k, mode, s, t, y, e):
            s[DOZE] = DOZING
            end = t
        # an error that grows from step to step goes on growing (Gustafsson 1994)
        trend = (step / earlier_step) ** 3 * room / earlier_room
        earlier_step, earlier_room = step, min(room, _LEEWAY)
        factor = _SAFETY * np.cbrt(room * min(trend, 1.0))
        h = step * min(max(factor, 0.2), 5.0) if not last else max(h, step * min(factor, 5.0))
    if spike < np.inf:
        if high < enough:
            s[UNDECIDED] += 1.0
        s[V_MEM], s[V_R], s[V_EX] = kept
        s[NOW] = spike
        return spike
    s[V_MEM], s[V_R], s[V_EX] = y
    s[NOW], s[STEP], s[CHARGE], s[CHARGE_LOW], s[NEAR] = end, h, charge, low, near
    return np.inf


@_compiled
def _falls_back(m: Neurons, k: int, mode: int, s: F64, t: float, y: Three, d: Three) -> bool:
    """Whether nothing but the way back to rest lies ahead until the next input.

    Free of pulses, v_mem falling well below the threshold, v_r and v_ex rising: the current into v_mem falls
    with all three, so that it never turns again.
    """
    if mode != 0 or s[ECHO_END] > t or s[RELEASE] > t or s[RESET_END] > t or s[NEAR] > 0.0:
        return False
    falling = d[0] < 0.0 and y[0] < m.v_threshold[k] - _FALLEN and d[1] >= 0.0
    return falling and (d[2] >= 0.0 or y[2] > m.v_dd[k] - _RECOVERED)


@_compiled
def _hermite(z: float, h: float, a: float, b: float, da: float, db: float) -> float:
    """Cubic through both ends of a step with their slopes, at share z."""
    c = 1.0 - z
    return a * c * c * (1.0 + 2.0 * z) + b * z * z * (3.0 - 2.0 * z) + h * z * c * (c * da - z * db)


NO, NEARLY, BARELY, YES = range(4)  # whether it fires; the middle two are within the margin

_REST_WATCHED = 20e-3  # s, as the transistor level's tuning does
_FIRST_DELAY = 30e-6  # s
_SCAN = 24
_RESOLUTION = 10e-6  # s


@_compiled
def _fires(m: Neurons, k: int, s: F64, until: float) -> int:
    """Advance `s` and say whether a spike comes before `until`."""
    s[UNDECIDED], s[NEAR] = 0.0, 0.0
    if advance(m, k, s, until) < np.inf:
        return YES if s[UNDECIDED] == 0.0 else BARELY
    return NO if s[UNDECIDED] == 0.0 and s[NEAR] == 0.0 else NEARLY


@_compiled
def _after_echo(m: Neurons, k: int, kept: F64, delay: float, until: float, s: F64) -> int:
    """Whether an echo `delay` after the call fires, from the last state kept before it."""
    j = 0
    while j + 1 < kept.shape[0] and kept[j + 1, NOW] <= delay:
        j += 1
    copy_state(kept[j], s)
    if s[NOW] < delay:
        advance(m, k, s, delay)
    echo(m, k, s, m.v_ex_max[k])
    return _fires(m, k, s, until)


@_compiled
def _edge(m: Neurons, k: int, kept: F64, outside: float, inside: float, until: float, s: F64) -> float:
    while abs(outside - inside) > _RESOLUTION:
        middle = 0.5 * (outside + inside)
        if _after_echo(m, k, kept, middle, until, s) >= BARELY:
            inside = middle
        else:
            outside = middle
    return 0.5 * (outside + inside)


@_compiled
def _interval(m: Neurons, k: int, kept: F64, s: F64, out: F64) -> int:
    """Edges of the facilitating interval into out[0:2]; returns the surest answer of the scan."""
    bound = m.rebound_bound[k]
    latest = m.t_inh[k] + bound
    until = latest + bound
    low = max(m.t_inh[k] - bound, _FIRST_DELAY)
    surest = NO
    for points in (_SCAN, 4 * _SCAN):
        gap = (latest - low) / (points - 1)
        first, last = -1, -1
        for j in range(points):
            answer = _after_echo(m, k, kept, low + j * gap, until, s)
            surest = max(surest, answer)
            if answer >= BARELY:
                first = j if first < 0 else first
                last = j
            elif last >= 0:
                break
        if first >= 0:
            left = low + max(first - 1, 0) * gap
            right = low + min(last + 1, points - 1) * gap
            out[0] = _edge(m, k, kept, left, low + first * gap, until, s)
            out[1] = _edge(m, k, kept, right, low + last * gap, until, s)
            return surest
    return surest


@_compiled
def _tune(m: Neurons, k: int, kept: F64, s: F64, out: F64) -> tuple[int, bool]:
    """Class, and whether it is undecided. out: first, last, peak of v_mem after the call alone."""
    out[:] = np.nan
    above = begin(m, k, kept[0], 0.0)
    if above > 0.0:
        return REST_FIRES, above < m.margin[k]
    unsure = above > -m.margin[k]
    # a call alone, states kept on the way
    call(m, k, kept[0])
    latest = m.t_inh[k] + m.rebound_bound[k]
    for j in range(1, kept.shape[0]):
        copy_state(kept[j - 1], kept[j])
        advance(m, k, kept[j], latest * j / (kept.shape[0] - 1))
        out[2] = kept[j, PEAK]
        if kept[j, RESET_END] > 0.0:
            return CALL_ALONE, unsure or kept[j, UNDECIDED] > 0.0
    unsure = unsure or kept[-1, UNDECIDED] > 0.0 or kept[-1, NEAR] > 0.0
    begin(m, k, s, 0.0)
    echo(m, k, s, m.v_ex_max[k])
    answer = _fires(m, k, s, m.rebound_bound[k] + _REST_WATCHED)
    unsure = unsure or answer in (NEARLY, BARELY)
    if answer >= BARELY:
        return ECHO_ALONE, unsure
    answer = _interval(m, k, kept, s, out)
    return (WORKS if answer >= BARELY else NEVER), unsure or answer in (NEARLY, BARELY)


@_compiled
def tune_all(m: Neurons, kept: F64, s: F64, outcome: I64, undecided: NDArray[np.bool_], out: F64) -> None:
    """Class, certainty and edges of every neuron.

    kept: float64[states, COLUMNS], s: float64[COLUMNS], scratch; outcome: int64[n]; undecided: bool[n];
    out: float64[n, 3], first and last facilitating delay (s, NaN where none), peak of v_mem after a call
    alone (V).
    """
    for k in range(outcome.size):
        outcome[k], undecided[k] = _tune(m, k, kept, s, out[k])


@_compiled
def advance_all(m: Neurons, states: F64, until: float, saved: F64, spikes: F64) -> float:
    """Advance all neurons to `until` (s) or to their first spike; returns the time reached.

    states: float64[n, COLUMNS]; saved: scratch of that shape; spikes: float64[n], filled with the time of a
    neuron's spike, or inf.
    """
    n = states.shape[0]
    reached = until
    for k in range(n):
        copy_state(states[k], saved[k])
        spikes[k] = advance(m, k, states[k], reached)
        reached = min(reached, spikes[k])
    for k in range(n):
        if states[k, NOW] > reached:
            copy_state(saved[k], states[k])
            spikes[k] = advance(m, k, states[k], reached)
    return reached


@_compiled
def respond_all(
    m: Neurons, times: F64, is_call: NDArray[np.bool_], until: float, s: F64, spikes: F64, counts: I64
) -> None:
    """Spikes of every neuron, at rest at first, to calls and echoes at sorted times.

    times: float64[events], s; s: float64[COLUMNS], scratch; spikes: float64[n, room], filled; counts:
    int64[n, 2], spikes and undecided moments, filled; spikes beyond the room are counted only.
    """
    for k in range(counts.shape[0]):
        first = times[0] if times.size else 0.0
        above = begin(m, k, s, min(first, 0.0))
        counts[k, 0] = 0
        for j in range(times.size + 1):
            stop = times[j] if j < times.size else until
            while s[NOW] < stop:
                spike = advance(m, k, s, stop)
                if spike < np.inf:
                    if counts[k, 0] < spikes.shape[1]:
                        spikes[k, counts[k, 0]] = spike
                    counts[k, 0] += 1
            if j < times.size:
                if is_call[j]:
                    call(m, k, s)
                else:
                    echo(m, k, s, m.v_ex_max[k])
        counts[k, 1] = int(s[UNDECIDED]) + int(s[NEAR]) + int(abs(above) < m.margin[k])
