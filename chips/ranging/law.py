"""Compiled equations of the rebound neuron: its currents, its rates of change, and one step of time.

States: v_mem, v_r, v_ex. With C the capacitance matrix of these nodes in the circuit (parasitics and overlaps
included, other nodes held), the devices' EKV currents and q(x) = ln(1 + e^x):

    C d(v_mem, v_r, v_ex)/dt = (I_rslope + I_me5 - I_m1, I_rtau - I_m2, I_me4)
    I_m1 = I_S [q((v_p - v_rest)/2U_T)^2 - q((v_p - v_mem)/2U_T)^2],  v_p = kappa_n (v_r - V_T0)
    I_m2 = I_S q((kappa_p (V_dd - v_mem - V_T0) - V_dd + v_r)/2U_T)^2
    I_me5 = I_S q(kappa_p (V_dd - v_ex - V_T0)/2U_T)^2
    I_me4 = I_S [q(v_p4/2U_T)^2 - q((v_p4 - V_dd + v_ex)/2U_T)^2]

That is the ideal law. Where the process has second-order effects (`Effects`), v_p follows the gate by the
body effect, and each current is multiplied by E M as in `circuits.devices.channel`: those of mr1 and mr2 by
an E that is a straight line over their drains, that of me4 by an M that is constant. Junctions are taken to
be reverse biased. The ideal law is compiled without any of it.

Stepped by RODAS3 (Sandu, Verwer, Blom, Spee, Carmichael, Potra 1997), four stages, order 3(2), L-stable.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.softplus import softplus_at, softplus_five

Three = tuple[float, float, float]
Nine = tuple[float, float, float, float, float, float, float, float, float]

_HALVINGS = 40  # of the supply: far below a nanovolt
_TINY = 1e-300  # keeps a square root from 0 where there is no body effect


class Effects(NamedTuple):
    """Second-order effects of one rebound neuron; those of n are float64[n, fields], in this order.

    two: 2 U_T^2, V^2; v_dd, v_rest: V. Of nFETs and pFETs: gamma, V^0.5, surface potential, V, and what v_p
    is multiplied by, which is kappa where it is constant, else 1; theta: fall of the mobility, 1/V; rise: of
    the Early voltage. offset: what makes v_x of a gate voltage, V; early: 1 / (V_E L), 1/V, of mr1 and mr2
    over the rise with their inversion too. me4_root: sqrt of its forward inversion; me4_leak: of v_ex's
    junctions over its square, A. r_leak: of junctions into v_r, A; mem_leak: of junctions and of the resets,
    which are off, out of v_mem, A.
    """

    two: float
    v_dd: float
    v_rest: float
    n_gamma: float
    n_surface: float
    n_scale: float
    n_theta: float
    n_rise: float
    p_gamma: float
    p_surface: float
    p_scale: float
    p_theta: float
    p_rise: float
    m1_offset: float
    m2_offset: float
    me5_offset: float
    m1_early: float
    m2_early: float
    me4_early: float
    me5_early: float
    mr1_early: float
    mr2_early: float
    me4_root: float
    me4_leak: float
    r_leak: float
    mem_leak: float


class Neurons(NamedTuple):
    """Numbers of n rebound neurons on a die, float64[n] each unless said, in SI units."""

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
    inverse_capacitance: F64  # float64[n, 4, 3, 3], 1/F: by what is held (1: v_mem, 2: v_ex)
    follow: F64  # float64[n, 3, 3]: step of a free node (row) for one of a held node (column)
    effects: F64 | None = None  # float64[n, fields of Effects], None under the ideal law


class Numbers(NamedTuple):
    """What the equations of one neuron need, as the arguments of q are linear in the voltages.

    g, gn, gp: 1 / (2 U_T), and that times kappa_n and kappa_p, 1/V; rest to me4: constant parts of the
    arguments of m1 (source at v_rest, at v_mem), m2, me5 and me4; i_m1 to i_me4: specific currents, A;
    forward to i_rtau: constant currents, A; effects: None under the ideal law.
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
    effects: Effects | None = None


_compiled = compiled(fastmath={"contract"})
# part of every step, so that arguments are not copied from function to function
_inlined = compiled(fastmath={"contract"}, forceinline=True)


@_inlined
def _effects_of(e: F64 | None, k: int) -> Effects | None:
    """Effects of neuron k; None, known when compiled, under the ideal law."""
    if e is None:
        return None
    return Effects(
        e[k, 0], e[k, 1], e[k, 2], e[k, 3], e[k, 4], e[k, 5], e[k, 6], e[k, 7], e[k, 8], e[k, 9],
        e[k, 10], e[k, 11], e[k, 12], e[k, 13], e[k, 14], e[k, 15], e[k, 16], e[k, 17], e[k, 18], e[k, 19],
        e[k, 20], e[k, 21], e[k, 22], e[k, 23], e[k, 24], e[k, 25],
    )  # fmt: skip


@_inlined
def numbers_of(m: Neurons, k: int) -> Numbers:
    """Return what the equations of neuron k need."""
    g, vdd = m.inverse_2ut[k], m.v_dd[k]
    gn, gp = g * m.kappa_n[k], g * m.kappa_p[k]
    return Numbers(
        g, gn, gp, gn * m.m1_threshold[k] + g * m.v_rest[k], gn * m.m1_threshold[k],
        gp * (vdd - m.m2_threshold[k]) - g * vdd, gp * (vdd - m.me5_threshold[k]), g * (m.me4_pinch[k] - vdd),
        m.m1_current[k], m.m2_current[k], m.me5_current[k], m.me4_current[k], m.me4_forward[k], m.i_rslope[k],
        m.i_rtau[k], _effects_of(m.effects, k),
    )  # fmt: skip


@_inlined
def matrix_of(m: Neurons, k: int, mode: int) -> Nine:
    """Return C^-1 of neuron k row by row, 1/F, while the nodes of `mode` are held (1: v_mem, 2: v_ex)."""
    c = m.inverse_capacitance[k, mode]
    return c[0, 0], c[0, 1], c[0, 2], c[1, 0], c[1, 1], c[1, 2], c[2, 0], c[2, 1], c[2, 2]


@_inlined
def currents(p: Numbers, v: float, r: float, x: float) -> Nine:
    """Return the currents into v_mem, v_r and v_ex (A), and their derivatives (S).

    Their order is i_mem, i_r, i_ex, di_mem/dv, di_mem/dr, di_mem/dx, di_r/dv, di_r/dr, di_ex/dx.
    """
    return _by_law(p, p.effects, v, r, x)


@_inlined
def _by_law(p: Numbers, o: Effects | None, v: float, r: float, x: float) -> Nine:
    """Return what `currents` does; the branch is taken when this is compiled."""
    if o is not None:
        return _whole(p, o, v, r, x)
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


@_inlined
def _pinched(height: float, gamma: float, surface: float, scale: float) -> tuple[float, float]:
    """v_p (V) where v_x is `height` V, and its derivative by the gate; its tangent below flat band."""
    above = max(height, 0.0)
    root = math.sqrt(above + 0.25 * gamma * gamma + _TINY)
    kappa = 1.0 - 0.5 * gamma / root
    v_p = above - surface - gamma * (root - 0.5 * gamma) + kappa * (height - above)
    return scale * v_p, scale * kappa


@_inlined
def _moved(v_p: float, theta: float, two: float) -> tuple[float, float]:
    """M at a pinch-off voltage (V), and its derivative by it over M, 1/V; two: 2 U_T^2, V^2."""
    root = math.sqrt(v_p * v_p + two)
    v_m = 0.5 * (v_p + root)
    m = 1.0 / (1.0 + theta * v_m)
    return m, -theta * v_m * m / root


@_inlined
def _whole(p: Numbers, o: Effects, v: float, r: float, x: float) -> Nine:
    """Return what `currents` does under a law with second-order effects."""
    v1, k1 = _pinched(r + o.m1_offset, o.n_gamma, o.n_surface, o.n_scale)
    v2, k2 = _pinched(o.m2_offset - v, o.p_gamma, o.p_surface, o.p_scale)
    v5, k5 = _pinched(o.me5_offset - x, o.p_gamma, o.p_surface, o.p_scale)
    g = p.g
    a, b, c, e, q, da, db, dc, de, dq = softplus_five(
        g * (v1 - o.v_rest), g * (v1 - v), g * (v2 - o.v_dd + r), g * v5, g * x + p.me4
    )
    m1, n1 = _moved(v1, o.n_theta, o.two)
    m2, n2 = _moved(v2, o.p_theta, o.two)
    m5, n5 = _moved(v5, o.p_theta, o.two)
    # m1: source at v_rest, drain at v_mem, which may change places
    span = v - o.v_rest
    sign = 1.0 if span >= 0.0 else -1.0
    w = 1.0 / (1.0 + o.n_rise * (a + b))
    early, bent = o.m1_early * abs(span) * w, o.n_rise * w
    scale, plain = p.i_m1 * m1, (a - b) * (a + b)
    i_m1 = scale * plain * (1.0 + early)
    by_q = -scale * plain * early * bent  # by a or b, through the rise
    by_a = 2.0 * scale * (1.0 + early) * a + by_q
    by_b = -2.0 * scale * (1.0 + early) * b + by_q
    m1_v = -g * by_b * db + sign * scale * plain * o.m1_early * w
    m1_r = k1 * (g * (by_a * da + by_b * db) + i_m1 * n1)
    # m2: source at v_r, drain at ground
    w = 1.0 / (1.0 + o.p_rise * c)
    early, bent = o.m2_early * r * w, o.p_rise * w
    scale = p.i_m2 * m2
    i_m2 = scale * c * c * (1.0 + early)
    by_c = (2.0 * scale * c * (1.0 + early) - scale * c * c * early * bent) * g * dc
    m2_r = by_c + scale * c * c * o.m2_early * w
    m2_v = -k2 * (by_c + i_m2 * n2)
    # me5: drain at v_mem, far
    w = 1.0 / (1.0 + o.p_rise * e)
    early, bent = o.me5_early * (o.v_dd - v) * w, o.p_rise * w
    scale = p.i_me5 * m5
    i_me5 = scale * e * e * (1.0 + early)
    by_e = (2.0 * scale * e * (1.0 + early) - scale * e * e * early * bent) * g * de
    me5_v = -scale * e * e * o.me5_early * w
    me5_x = -k5 * (by_e + i_me5 * n5)
    # me4: drain at v_ex, its gate stays
    w = 1.0 / (1.0 + o.p_rise * (o.me4_root + q))
    early, bent = o.me4_early * (o.v_dd - x) * w, o.p_rise * w
    plain, scale = (o.me4_root - q) * (o.me4_root + q), p.i_me4
    i_me4 = plain * (scale * (1.0 + early) + o.me4_leak)
    me4_x = (
        g * dq * (-2.0 * q * (scale * (1.0 + early) + o.me4_leak) - plain * scale * early * bent)
        - plain * scale * o.me4_early * w
    )
    return (
        p.i_rslope * (1.0 + o.mr1_early * (o.v_dd - v)) - o.mem_leak + i_me5 - i_m1,
        p.i_rtau * (1.0 + o.mr2_early * (o.v_dd - r)) + o.r_leak - i_m2,
        i_me4,
        me5_v - m1_v - p.i_rslope * o.mr1_early,
        -m1_r,
        me5_x,
        -m2_v,
        -m2_r - p.i_rtau * o.mr2_early,
        me4_x,
    )


@_inlined
def excited(p: Numbers, o: Effects, v: float, x: float) -> float:
    """Return the current of me5 into v_mem under a law with second-order effects, A."""
    v5, _ = _pinched(o.me5_offset - x, o.p_gamma, o.p_surface, o.p_scale)
    moved, _ = _moved(v5, o.p_theta, o.two)
    e = softplus_at(p.g * v5)
    return p.i_me5 * moved * e * e * (1.0 + o.me5_early * (o.v_dd - v) / (1.0 + o.p_rise * e))


@_inlined
def rates(c: Nine, i: Nine) -> Three:
    """Return dv/dt of the three nodes, V/s, 0 for a node that is held."""
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
def stepped(p: Numbers, matrix: Nine, h: float, y: Three, i: Nine) -> tuple[Three, float]:
    """Make one RODAS3 step of `h` s from y, whose currents are i; return the new y and its error, V."""
    d = rates(matrix, i)
    f = _inverse(matrix, h, i)
    a = _solve(f, d[0], d[1], d[2])
    g = 4.0 / h
    b = _solve(f, d[0] + g * a[0], d[1] + g * a[1], d[2] + g * a[2])
    i = currents(p, y[0] + 2.0 * a[0], y[1] + 2.0 * a[1], y[2] + 2.0 * a[2])
    d = rates(matrix, i)
    g = 1.0 / h
    c = _solve(f, d[0] + g * (a[0] - b[0]), d[1] + g * (a[1] - b[1]), d[2] + g * (a[2] - b[2]))
    n = (y[0] + 2.0 * a[0] + c[0], y[1] + 2.0 * a[1] + c[1], y[2] + 2.0 * a[2] + c[2])
    i = currents(p, n[0], n[1], n[2])
    d = rates(matrix, i)
    w = 8.0 / 3.0
    z = _solve(
        f,
        d[0] + g * (a[0] - b[0] - w * c[0]),
        d[1] + g * (a[1] - b[1] - w * c[1]),
        d[2] + g * (a[2] - b[2] - w * c[2]),
    )
    return (n[0] + z[0], n[1] + z[1], n[2] + z[2]), max(abs(z[0]), abs(z[1]), abs(z[2]))


class Pull(NamedTuple):
    """What pulls v_mem of n neurons low: specific currents (A) and voltages (V), float64[n] each."""

    v_rest: F64
    m1_current: F64
    m1_threshold: F64
    mi12_current: F64
    mi12_pinch: F64  # v_p with its gate at the supply
    v_r: F64  # v_r - kappa_p v_mem while m2 carries I_rtau
    i_rslope: F64


@_compiled
def pull_low(p: Pull, u_t: float, kappa_n: float, kappa_p: float, out: F64) -> None:
    """Fill `out` with v_mem at which mi12 sinks I_rslope and what m1 brings from v_rest, V, float64[n]."""
    for k in range(out.size):
        low, high = 0.0, p.v_rest[k]
        for _ in range(_HALVINGS):
            v = 0.5 * (low + high)
            pinch = kappa_n * (p.v_r[k] + kappa_p * v - p.m1_threshold[k])
            brought = (
                softplus_at(0.5 * (pinch - v) / u_t) ** 2
                - softplus_at(0.5 * (pinch - p.v_rest[k]) / u_t) ** 2
            )
            full = p.mi12_pinch[k]
            sunk = softplus_at(0.5 * full / u_t) ** 2 - softplus_at(0.5 * (full - v) / u_t) ** 2
            if p.mi12_current[k] * sunk < p.m1_current[k] * brought + p.i_rslope[k]:
                low = v
            else:
                high = v
        out[k] = 0.5 * (low + high)
