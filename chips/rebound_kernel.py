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
The functions stand in one file, so that numba's own stamp of the file tells a stale cache.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar, cast

import numba as nb
import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
F = TypeVar("F", bound=Callable[..., Any])
Three = tuple[float, float, float]
Nine = tuple[float, float, float, float, float, float, float, float, float]

TOLERANCE = 1e-4  # V, local error of a step; ours: moves a peak by up to 0.35 mV, inside the measured margin
ECHO_HELD = (0.05e-6, 10.15e-6)  # s, half-supply crossings of an event's pulse
_FIRST_STEP = 1e-8  # s, after the release
_EVENT_STEP = 1e-6  # s, after other changes
_PARTS = 8  # of a step, over which w is summed
_LOOKAHEAD = 2e-3  # s, for which a spike's certainty is looked for beyond it
_FAR = 36.0  # beyond it ln(1 + e^x) is x, or 0 against the other currents
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


def _compiled(function: F) -> F:
    """Compile without reference counts (no arrays are made), cached by this file's own stamp."""
    options: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}
    return cast("F", nb.njit(**options)(function))


@_compiled
def _softplus(x: float) -> tuple[float, float]:
    """`ln(1 + e^x)` and its derivative."""
    if x > _FAR:
        return x, 1.0
    if x < -_FAR:
        return 0.0, 0.0
    t = math.exp(-abs(x))
    s = 1.0 / (1.0 + t)
    if x >= 0.0:
        return x + math.log1p(t), s
    return math.log1p(t), t * s


@_compiled
def _currents(m: Neurons, k: int, v: float, r: float, x: float) -> Nine:
    """Currents into v_mem, v_r, v_ex (A) and their derivatives (S).

    Order: i_mem, i_r, i_ex, di_mem/dv, di_mem/dr, di_mem/dx, di_r/dv, di_r/dr, di_ex/dx.
    """
    g, vdd = m.inverse_2ut[k], m.v_dd[k]
    kn, kp = m.kappa_n[k], m.kappa_p[k]
    vp = kn * (r - m.m1_threshold[k])
    a, da = _softplus((vp - m.v_rest[k]) * g)
    b, db = _softplus((vp - v) * g)
    i1 = m.m1_current[k] * (a - b) * (a + b)
    c1 = 2.0 * g * m.m1_current[k]
    c, dc = _softplus((kp * (vdd - v - m.m2_threshold[k]) - vdd + r) * g)
    i2 = m.m2_current[k] * c * c
    c2 = 2.0 * g * m.m2_current[k] * c * dc
    e, de = _softplus(kp * (vdd - x - m.me5_threshold[k]) * g)
    i5 = m.me5_current[k] * e * e
    q, dq = _softplus((m.me4_pinch[k] - vdd + x) * g)
    i4 = m.me4_forward[k] - m.me4_current[k] * q * q
    return (
        m.i_rslope[k] + i5 - i1,
        m.i_rtau[k] - i2,
        i4,
        -c1 * b * db,
        -c1 * kn * (a * da - b * db),
        -2.0 * g * kp * m.me5_current[k] * e * de,
        kp * c2,
        -c2,
        -2.0 * g * m.me4_current[k] * q * dq,
    )


@_compiled
def excitation(m: Neurons, k: int, s: F64) -> float:
    """Rate at which me5 raises a free v_mem, V/s."""
    e, _ = _softplus(m.kappa_p[k] * (m.v_dd[k] - s[V_EX] - m.me5_threshold[k]) * m.inverse_2ut[k])
    return float(m.me5_current[k] * e * e * m.inverse_capacitance[0, 0, 0])


@_compiled
def _rates(m: Neurons, mode: int, i: Nine) -> Three:
    """dv/dt of the three nodes, V/s; zero for a held node."""
    c = m.inverse_capacitance[mode]
    return (
        c[0, 0] * i[0] + c[0, 1] * i[1] + c[0, 2] * i[2],
        c[1, 0] * i[0] + c[1, 1] * i[1] + c[1, 2] * i[2],
        c[2, 0] * i[0] + c[2, 1] * i[1] + c[2, 2] * i[2],
    )


@_compiled
def _factor(m: Neurons, mode: int, h: float, i: Nine) -> Nine:
    """LU factors of `2/h - C^-1 dI/dv`: l10, l20, l21, u00, u01, u02, u11, u12, u22."""
    c = m.inverse_capacitance[mode]
    d = 2.0 / h
    a00 = d - (c[0, 0] * i[3] + c[0, 1] * i[6])
    a01 = -(c[0, 0] * i[4] + c[0, 1] * i[7])
    a02 = -(c[0, 0] * i[5] + c[0, 2] * i[8])
    a10 = -(c[1, 0] * i[3] + c[1, 1] * i[6])
    a11 = d - (c[1, 0] * i[4] + c[1, 1] * i[7])
    a12 = -(c[1, 0] * i[5] + c[1, 2] * i[8])
    a20 = -(c[2, 0] * i[3] + c[2, 1] * i[6])
    a21 = -(c[2, 0] * i[4] + c[2, 1] * i[7])
    a22 = d - (c[2, 0] * i[5] + c[2, 2] * i[8])
    l10 = a10 / a00
    l20 = a20 / a00
    u11 = a11 - l10 * a01
    u12 = a12 - l10 * a02
    l21 = (a21 - l20 * a01) / u11
    u22 = a22 - l20 * a02 - l21 * u12
    return l10, l20, l21, a00, a01, a02, u11, u12, u22


@_compiled
def _solve(f: Nine, b0: float, b1: float, b2: float) -> Three:
    y1 = b1 - f[0] * b0
    y2 = b2 - f[1] * b0 - f[2] * y1
    z2 = y2 / f[8]
    z1 = (y1 - f[7] * z2) / f[6]
    return (b0 - f[4] * z1 - f[5] * z2) / f[3], z1, z2


@_compiled
def _step(m: Neurons, k: int, mode: int, h: float, y: Three, i: Nine) -> tuple[Three, float]:
    """One RODAS3 step of `h` s from y, whose currents are i; returns (new y, error V)."""
    d = _rates(m, mode, i)
    f = _factor(m, mode, h, i)
    a = _solve(f, d[0], d[1], d[2])
    g = 4.0 / h
    b = _solve(f, d[0] + g * a[0], d[1] + g * a[1], d[2] + g * a[2])
    i = _currents(m, k, y[0] + 2.0 * a[0], y[1] + 2.0 * a[1], y[2] + 2.0 * a[2])
    d = _rates(m, mode, i)
    g = 1.0 / h
    c = _solve(f, d[0] + g * (a[0] - b[0]), d[1] + g * (a[1] - b[1]), d[2] + g * (a[2] - b[2]))
    n = (y[0] + 2.0 * a[0] + c[0], y[1] + 2.0 * a[1] + c[1], y[2] + 2.0 * a[2] + c[2])
    i = _currents(m, k, n[0], n[1], n[2])
    d = _rates(m, mode, i)
    w = 8.0 / 3.0
    z = _solve(
        f,
        d[0] + g * (a[0] - b[0] - w * c[0]),
        d[1] + g * (a[1] - b[1] - w * c[1]),
        d[2] + g * (a[2] - b[2] - w * c[2]),
    )
    return (n[0] + z[0], n[1] + z[1], n[2] + z[2]), max(abs(z[0]), abs(z[1]), abs(z[2]))


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
    for _ in range(200):
        i = _currents(m, k, v, r, x)
        determinant = i[3] * i[7] - i[4] * i[6]
        dv = (i[0] * i[7] - i[4] * i[1]) / determinant
        dr = (i[3] * i[1] - i[6] * i[0]) / determinant
        v -= min(max(dv, -0.05), 0.05)
        r -= min(max(dr, -0.05), 0.05)
        if abs(dv) + abs(dr) < 1e-9:
            break
    s[:] = 0.0
    s[V_MEM], s[V_R], s[V_EX], s[NOW], s[STEP] = v, r, x, time, _EVENT_STEP
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
    s[STEP] = _EVENT_STEP


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
            s[CHARGE], s[CHARGE_LOW], s[NEAR], s[STEP] = 0.0, 0.0, 0.0, _EVENT_STEP
            return spike
        if s[DOZE] == DOZING:
            return np.inf
        s[NOW] = stop
        if stop == s[RELEASE] or stop == s[RESET_END]:
            s[STEP] = _FIRST_STEP
        if stop == s[ECHO_START]:
            _hold(m, s, V_EX, s[ECHO_LEVEL])
            if held:
                s[V_MEM] = m.v_held[k]
            s[STEP] = _EVENT_STEP
        if stop == s[ECHO_END]:
            s[V_EX] += m.echo_step[k]
            s[STEP] = _EVENT_STEP
    return np.inf


@_compiled
def _integrate(m: Neurons, k: int, mode: int, s: F64, stop: float) -> float:  # noqa: C901, PLR0912, PLR0915 - one loop with its scalars
    """Integrate in one mode to `stop` or to a spike (its time, else inf)."""
    y = (s[V_MEM], s[V_R], s[V_EX])
    t, h = s[NOW], s[STEP]
    i = _currents(m, k, y[0], y[1], y[2])
    d = _rates(m, mode, i)
    threshold, enough, margin = m.v_threshold[k], m.axon_charge[k], m.margin[k]
    charge, low, high, near = s[CHARGE], s[CHARGE_LOW], 0.0, s[NEAR]
    spike, end = np.inf, stop
    kept = y
    while t < end:
        if spike == np.inf and max(abs(d[0]), abs(d[1]), abs(d[2])) < SETTLED and y[0] < threshold - 0.05:
            break
        last = h >= end - t
        step = min(h, end - t)
        n, error = _step(m, k, mode, step, y, i)
        scale = 0.9 * (TOLERANCE / max(error, 1e-12)) ** (1.0 / 3.0)
        if not error <= TOLERANCE:
            h = step * max(scale, 0.1) if error == error else 0.1 * step  # noqa: PLR0124 - a NaN
            continue
        i = _currents(m, k, n[0], n[1], n[2])
        e = _rates(m, mode, i)
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
        h = step * min(max(scale, 0.2), 5.0) if not last else max(h, step * min(scale, 5.0))
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
