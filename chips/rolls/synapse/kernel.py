"""Compiled equations of ROLLS' synaptic filter: v_syn and its line, with a die's own devices.

`C (dv_syn, dv_line)/dt = (I_tau - I_2, I_1 + I_2 - I_w)`, C the capacitance matrix of both nodes, and with
`F(u) = ln^2(1 + e^(u/2))`, voltages in U_T:

    I_1   = I_S1 [F(p_thr - v_line) - F(p_thr - v_dd)],                p_thr = kappa_n (v_thr - V_T0)
    I_2   = I_S2 [F(p_2 - v_line) - F(p_2 - v_syn)],                   p_2 = kappa_n (v_syn - V_T0)
    I_tau = I_S3 [F(p_tau) - F(p_tau - (v_dd - v_syn))],               in triode near the supply
    I_syn = I_S5 F(kappa_p (v_dd - v_syn - V_T0)), mirrored by md6 and md7 in the inhibitory filter

The mirror's gate follows late, by C U_T / (kappa_n I). I_w is what the synapses draw from the line: a
saturated current times a shape over the line's voltage.
Stepped by RODAS3 (Sandu, Verwer, Blom, Spee, Carmichael, Potra 1997), four stages, order 3(2), L-stable.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.rolls.synapse.whole_kernel import currents, output
from circuits.arrays import F64, Bools
from circuits.compiled import compiled
from circuits.devices.ekv import argument_of_root, law

V_SYN, V_LINE, STEP, OUTPUT = range(4)  # columns of a filter's state: V, V, s, A
FILTER_COLUMNS = 4
TOLERANCE = 2e-5  # V, local error of a step; ours: 0.05 % of a current
FIRST_STEP = 1e-9  # s, after a pulse begins or ends
_SAFETY = 0.9


class Filters(NamedTuple):
    """Filters on a die, float64[n] each unless said; SI units, pinch-off voltages in U_T."""

    u_t: F64
    kappa_n: F64
    kappa_p: F64
    v_dd: F64
    i1: F64  # specific currents, A
    p_thr: F64
    i2: F64
    t2: F64  # threshold of md2, U_T
    i3: F64
    p_tau: F64
    i5: F64
    t5: F64
    i6: F64  # mirror, inhibitory alone: specific current and threshold of md6, md7
    t6: F64
    i7: F64
    t7: F64
    mirrored: Bools
    mirror_capacitance: F64  # F, at the mirror's gate
    inverse: F64  # float64[3, n], 1/F: C^-1, (syn syn), (syn line), (line line)
    off: F64  # A, drawn from the line between pulses
    shared: F64  # charge that a switch's far node takes from the line as a pulse begins, by the line's own
    highest: F64  # V, to which that node follows the line
    lift: F64  # V, by which the switch's gate moves the line, up as a pulse begins and down as it ends
    shape: F64  # float64[n, points]: share of a drawn current over the line's voltage from 0 V to the supply
    held: F64  # V, from which the switch's far node is lifted, its nodes' mean


class WholeFilters(NamedTuple):
    """What else filters need under the law with second-order effects.

    rows: float64[6, TERMS, n] of md1, md2, md3, md5, md6, md7 (`chips.rolls.synapse.whole_kernel`); gates:
    of md1, V, and of md3, V below the supply, float64[2, n]; end: of the output's node, V.
    """

    rows: F64
    gates: F64
    end: float


_compiled = compiled(fastmath={"contract"})
_Whole = WholeFilters | None  # by which a kernel is compiled for either law
_Six = tuple[float, float, float, float, float, float]


@_compiled
def _shape(row: F64, x: float) -> tuple[float, float]:
    """Table at position x (in points) and its slope a point; constant beyond the end."""
    last = row.size - 1
    i = min(max(int(x), 0), last - 1)
    t = min(x - i, 1.0)
    d = row[i + 1] - row[i]
    return row[i] + t * d, d if x < last else 0.0


@_compiled
def _rates(m: Filters, w: _Whole, k: int, v: float, line: float, drawn: float) -> _Six:
    """dv_syn/dt, dv_line/dt (V/s) and their derivatives by v_syn and the line (1/s), row by row."""
    if w is not None:
        return _whole_rates(m, w, k, v, line, drawn)
    u = m.u_t[k]
    supply, s, y = m.v_dd[k] / u, v / u, line / u
    p2 = m.kappa_n[k] * (s - m.t2[k])
    f1, d1 = law(m.p_thr[k] - y)
    far1, _ = law(m.p_thr[k] - supply)
    f2, d2 = law(p2 - y)
    far2, e2 = law(p2 - s)
    f3, _ = law(m.p_tau[k])
    far3, e3 = law(m.p_tau[k] - supply + s)
    points = m.shape.shape[1] - 1
    share, bend = _shape(m.shape[k], line / m.v_dd[k] * points)
    i1, i2, i3 = m.i1[k] * (f1 - far1), m.i2[k] * (f2 - far2), m.i3[k] * (f3 - far3)
    by_s2 = m.i2[k] * (m.kappa_n[k] * (d2 - e2) + e2) / u
    by_y1, by_y2 = -m.i1[k] * d1 / u, -m.i2[k] * d2 / u
    by_s3 = -m.i3[k] * e3 / u
    by_yw = drawn * bend * points / m.v_dd[k]
    a, b, c = m.inverse[0, k], m.inverse[1, k], m.inverse[2, k]
    js, jl = i3 - i2, i1 + i2 - drawn * share
    ss, sl, ls, ll = by_s3 - by_s2, -by_y2, by_s2, by_y1 + by_y2 - by_yw
    return (
        a * js + b * jl, b * js + c * jl, a * ss + b * ls, a * sl + b * ll, b * ss + c * ls, b * sl + c * ll,
    )  # fmt: skip


@_compiled
def _whole_rates(m: Filters, w: WholeFilters, k: int, v: float, line: float, drawn: float) -> _Six:
    """The same under the law with second-order effects."""
    js, jl, ss, sl, ls, ll = currents(w.rows, w.gates, k, m.v_dd[k], (v, line))
    points = m.shape.shape[1] - 1
    share, bend = _shape(m.shape[k], line / m.v_dd[k] * points)
    jl -= drawn * share
    ll -= drawn * bend * points / m.v_dd[k]
    a, b, c = m.inverse[0, k], m.inverse[1, k], m.inverse[2, k]
    return (
        a * js + b * jl, b * js + c * jl, a * ss + b * ls, a * sl + b * ll, b * ss + c * ls, b * sl + c * ll,
    )  # fmt: skip


@_compiled
def static_output(m: Filters, w: _Whole, k: int, v: float) -> float:
    """Return I_syn with v_syn at rest at `v` V, A, positive for both signs."""
    if w is not None:
        return output(w.rows, k, m.v_dd[k] - v, (m.v_dd[k], w.end), m.mirrored[k])
    u = m.u_t[k]
    current = m.i5[k] * law(m.kappa_p[k] * ((m.v_dd[k] - v) / u - m.t5[k]))[0]
    if not m.mirrored[k]:
        return float(current)
    kappa = m.kappa_n[k]
    # gate of the diode md6 by Newton on ln I, from saturation
    q = math.sqrt(current / m.i6[k])
    gate = m.t6[k] + argument_of_root(q) / kappa
    for _ in range(20):
        p = kappa * (gate - m.t6[k])
        f, df = law(p)
        g, dg = law(p - gate)
        step = (m.i6[k] * (f - g) - current) / (m.i6[k] * (kappa * df - (kappa - 1.0) * dg))
        gate -= step
        if abs(step) < 1e-9:
            break
    return float(m.i7[k] * law(kappa * (gate - m.t7[k]))[0])


@_compiled
def advance_filter(m: Filters, w: _Whole, k: int, s: F64, drawn: float, duration: float) -> None:
    """Advance filter k by `duration` s while synapses draw `drawn` A from its line."""
    left = duration
    v, y = s[V_SYN], s[V_LINE]
    total = drawn + m.off[k]
    while left > 0.0:
        h = min(s[STEP], left)
        r0, r1, ss, sl, ls, ll = _rates(m, w, k, v, y, total)
        while True:
            d = 2.0 / h
            determinant = (d - ss) * (d - ll) - sl * ls
            a00, a01, a10, a11 = (
                (d - ll) / determinant, sl / determinant, ls / determinant, (d - ss) / determinant,
            )  # fmt: skip
            a, b = a00 * r0 + a01 * r1, a10 * r0 + a11 * r1
            g = 4.0 / h
            x0, x1 = r0 + g * a, r1 + g * b
            c, e = a00 * x0 + a01 * x1, a10 * x0 + a11 * x1
            t0, t1, _, _, _, _ = _rates(m, w, k, v + 2.0 * a, y + 2.0 * b, total)
            g = 1.0 / h
            x0, x1 = t0 + g * (a - c), t1 + g * (b - e)
            p, q = a00 * x0 + a01 * x1, a10 * x0 + a11 * x1
            n0, n1 = v + 2.0 * a + p, y + 2.0 * b + q
            t0, t1, _, _, _, _ = _rates(m, w, k, n0, n1, total)
            third = 8.0 / 3.0
            x0, x1 = t0 + g * (a - c - third * p), t1 + g * (b - e - third * q)
            z0, z1 = a00 * x0 + a01 * x1, a10 * x0 + a11 * x1
            # the line's own voltage matters less than v_syn's by what its capacitance is smaller
            error = max(abs(z0), 0.1 * abs(z1)) / TOLERANCE
            if error <= 1.0:
                break
            h *= max(_SAFETY / error ** (1.0 / 3.0), 0.2)
        v, y = n0 + z0, n1 + z1
        left -= h
        if m.mirrored[k]:
            s[OUTPUT] = _late(m, k, s[OUTPUT], static_output(m, w, k, v), h)
        if h < s[STEP] and error < 0.1 and left <= 0.0:
            break  # a step cut short by the end says nothing of the next
        s[STEP] = h * min(_SAFETY / max(error, 1e-3) ** (1.0 / 3.0), 4.0)
    s[V_SYN], s[V_LINE] = v, y
    if not m.mirrored[k]:
        s[OUTPUT] = static_output(m, w, k, v)


@_compiled
def _late(m: Filters, k: int, current: float, given: float, h: float) -> float:
    """Mirror's output after h s, A: `C U_T dI/dt = kappa_n I (I_given - I)`, its weak inversion."""
    decay = math.exp(-min(m.kappa_n[k] * given * h / (m.mirror_capacitance[k] * m.u_t[k]), 500.0))
    return float(1.0 / (1.0 / given + (1.0 / current - 1.0 / given) * decay))


@_compiled
def rest_of(m: Filters, w: _Whole, state: F64) -> None:
    """Fill the state of filters without pulses, by growing steps from v_syn at the supply."""
    for k in range(m.u_t.size):
        s = state[k]
        s[V_SYN], s[V_LINE], s[STEP] = m.v_dd[k], 0.7 * m.v_dd[k], FIRST_STEP
        s[OUTPUT] = static_output(m, w, k, m.v_dd[k])
        advance_filter(m, w, k, s, 0.0, 1e3)
        s[STEP] = FIRST_STEP


@_compiled
def _jump(m: Filters, k: int, s: F64, volts: float) -> None:
    """Move the line at once; a charge on it moves v_syn too."""
    s[V_LINE] += volts
    s[V_SYN] += volts * m.inverse[1, k] / m.inverse[2, k]


@_compiled
def follow(
    m: Filters, w: _Whole, k: int, s: F64, drawn: float, pulses: tuple[F64, F64], times: F64, out: F64
) -> None:
    """Fill the output current (A) of filter k at `times` (s, rising from 0).

    drawn: current of its pulses, A; pulses: beginnings and ends of them, s.
    """
    starts, ends = pulses
    now = 0.0
    p = 0
    on = False
    for j in range(times.size):
        while now < times[j]:
            edge = np.inf
            if p < starts.size:
                edge = ends[p] if on else starts[p]
            until = min(edge, times[j])
            if until > now:
                advance_filter(m, w, k, s, drawn if on else 0.0, until - now)
                now = until
            if now >= edge:
                if on:
                    p += 1
                    _jump(m, k, s, -m.lift[k])
                else:
                    taken = m.shared[k] * (min(s[V_LINE], m.highest[k]) - m.held[k])
                    _jump(m, k, s, 2.0 * m.lift[k] - taken)
                on = not on
                s[STEP] = FIRST_STEP
        out[j] = s[OUTPUT]
