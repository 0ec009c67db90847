"""Compiled decision of the selection under a law with second-order effects (`chips.selection.whole`).

The nodes that a decision moves are integrated, with the whole law of each device at its own voltages
(`circuits.devices.channel`): the v_in of all cells, the gates of all risks, v_common, and of the cell that
carries most of the tail its `share` and `taken`. With C the capacitance matrix of these nodes,

    C d(v_in,k) / dt   = I_my,k - sum_d I_mg,k,d - I_m1,k
    C d(risk_k) / dt   = I_risk,k - I_mk,k
    C d(v_common) / dt = sum_k I_m2,k - I_mt
    C d(share) / dt    = I_mo - I_mb - I_m2,      C d(taken) / dt = I_ms - I_mr

from the rest in which all v_in are joined. The excitations' diodes are at rest. The mirrors of one risk have
v_p by the law at its gate, and their own deviations with the slope dv_p / dv_g that it has there.

Devices of all cells are evaluated side by side, in lanes (`circuits.vectors`).

Stepped by ROS2 (Verwer, Spee, Blom, Hundsdorfer, "A second-order Rosenbrock method applied to photochemical
dispersion problems", 1999), which has its order 2 with any matrix in the place of the Jacobian, and is
L-stable with the exact one. Here that is the diagonal, and what v_common and the v_in do to each other.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import Terms, channel
from circuits.devices.channel_lanes import Effects, bent, channel_affected
from circuits.devices.softplus import softplus_of_two
from circuits.vectors import vector
from circuits.vectors.vector import WIDTH, Lanes

NOBODY = -1  # the winner where no cell has a current above 0
LONGEST = 10e-3  # s, of a decision; ours
_GAMMA = 1.0 - 1.0 / math.sqrt(2.0)
_FIRST, _SHORTEST = 0.02e-6, 1e-12  # s, of a step
_STEPS = 20_000
_FINE, _BEHIND = 0.4e-3, 0.01  # tolerance of a step, V and a share of what a cell is behind; ours
_TAKEN = 20e-3  # V, tolerance of `taken` and of its crossing; ours
_ROUNDS = 60  # of Newton's method
_FARTHEST = 0.1  # V, of its steps
_EXACT = 1e-10  # V, after which it ends
_LEAST = 1e-30  # A: an excitation below it is none
V, CURRENT, K1, K2, NEXT, SLOPE, GM1, GM2, REST, GIVEN, GIVEN_SLOPE, RATE, SPARE = range(13)
ROWS = 15  # of the working space: see `decide_whole`
# Groups of `Whole.side`: of mk, m1 and m2 of all cells what they carry on the die, V at their terminals, and
# their currents and derivatives; then currents of the mirrors, A, and their derivative by v_in, S; then of
# each mirror of a cell its specific current, its threshold above what the polarity shares, and its gate.
SPECIFIC, THRESHOLD, DRAIN, GATE, SOURCE, CARRIED, BY_DRAIN, BY_GATE, BY_SOURCE = range(9)
DEVICE = 9  # groups of a device
TAKEN, BY_INPUT = 3 * DEVICE, 3 * DEVICE + 1
MIRRORS = 3 * DEVICE + 2
MIRROR = 3  # groups of a mirror


class Whole(NamedTuple):
    """A winner-take-all circuit on a die at a temperature under its whole law; N cells, M mirrors each.

    shared: `Terms` of each device without its own deviations, in the order below, float64[13, terms]; mt, md
    and me are lone devices, with them. own: those of the cells' devices with theirs, float64[9, N, terms].
    side: what stands side by side, in groups of as many rows of WIDTH numbers as the cells need,
    float64[rows, WIDTH]; flat: the same numbers in one row, `span` a group. mirrors: M. quiet: drain of an
    m2 that does not lead, V. inverse_capacitance: of v_in, of the risks and of v_common, 1/F,
    float64[2 N + 1, 2 N + 1]. near: joined v_in, v_common and the joint's middle, V, from where the rest of a
    decision is looked for. All arrays are empty where the law has no second-order effects.
    """

    v_dd: float
    u_t: float
    v_tail: float
    quiet: float
    shared: F64
    own: F64
    side: F64
    flat: F64
    span: int
    mirrors: int
    threshold_of_line: F64  # [N], V, of `taken`
    leak: tuple[float, float]  # A, out of a v_in and of a risk by junctions
    inverse_capacitance: F64
    share_capacitance: float  # F
    taken_capacitance: float
    near: tuple[float, float, float]
    begin: float  # s, from the release to when the v_in are no longer joined
    work: F64  # [ROWS, 2 N + 3], working space


MX, MY, MK, M1, M2, MO, MB, MS, MR, MG, MT, MD, ME = range(13)

_compiled = compiled()
_inlined = compiled(forceinline=True)
every, load, root, store = vector.every, vector.load, vector.root, vector.store


@_compiled
def _carried(t: Terms, v_d: float, v_g: float, v_s: float) -> tuple[float, float, float, float]:
    """`circuits.devices.channel.channel`, compiled once for all devices here."""
    return channel(t, v_d, v_g, v_s)


@_inlined
def _of(row: F64) -> Terms:
    """A device from its numbers; one function to compile, where names of devices would be as many."""
    return Terms(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10], row[11],
        row[12],
    )  # fmt: skip


@_compiled
def _diode_gate(t: Terms, current: float, near: float) -> float:
    """Gate (V) of a diode that carries a current (A), by Newton's method on the current's logarithm."""
    gate = near
    for _ in range(_ROUNDS):
        found, by_drain, by_gate, _ = _carried(t, gate, gate, 0.0)
        step = found * math.log(current / found) / (by_drain + by_gate)
        gate += min(max(step, -_FARTHEST), _FARTHEST)
        if abs(step) < _EXACT:
            break
    return gate


@_compiled
def _prepare(w: Whole, excite: F64, risk: F64) -> None:
    """Gates of all risks at rest, V, and what each my gives at a v_in of 0, A, and its slope by v_in, S."""
    given, slope, v = w.work[GIVEN], w.work[GIVEN_SLOPE], w.work[V]
    near = w.near[0]
    gate = 1.0
    for k in range(excite.size):
        given[k], slope[k] = 0.0, 0.0
        if excite[k] > _LEAST:
            gate = _diode_gate(_of(w.own[MX, k]), excite[k], gate)
            current, by_drain, _, _ = _carried(_of(w.own[MY, k]), w.v_dd - near, gate, 0.0)
            given[k], slope[k] = current + by_drain * near, -by_drain
    gate = 0.5
    for k in range(excite.size):
        gate = _diode_gate(_of(w.own[MK, k]), max(risk[k] - w.leak[1], _LEAST), gate)
        v[excite.size + k] = gate


@_inlined
def _pinched(t: Terms, above: Lanes) -> tuple[Lanes, Lanes]:
    """v_p (V), and dv_p/dv_g, where the gate is so far above the threshold, V."""
    lift = t.surface + t.gamma * math.sqrt(t.surface)
    return bent(t.kappa * above, every(t.kappa), above + lift, every(t.gamma), every(t.surface))


@_compiled
def _devices(w: Whole, group: int, t: Terms, rows: int) -> None:
    """Currents of a device in all cells, and their derivatives; t: what it shares."""
    side, half = w.side, every(t.half)
    effects = Effects(every(t.early), every(t.early_rise), every(t.reduction), every(2.0 * w.u_t * w.u_t))
    for i in range(rows):
        row = group * rows + i
        above = load(side, row + GATE * rows) - load(side, row + THRESHOLD * rows)
        v_p, kappa = _pinched(t, above)
        current, by_drain, by_pinch, by_source = channel_affected(
            load(side, row + SPECIFIC * rows), half, effects, load(side, row + DRAIN * rows), v_p,
            load(side, row + SOURCE * rows),
        )  # fmt: skip
        store(side, row + CARRIED * rows, current)
        store(side, row + BY_DRAIN * rows, by_drain)
        store(side, row + BY_GATE * rows, kappa * by_pinch)
        store(side, row + BY_SOURCE * rows, by_source)


@_compiled
def _mirrors(w: Whole, t: Terms, rows: int) -> None:
    """What the mirrors of the risks take from all v_in, A, and its derivative by v_in, S."""
    side, half, drain_group = w.side, every(t.half), (M1 - MK) * DEVICE + DRAIN
    for i in range(rows):
        drain = load(side, drain_group * rows + i)
        total, slope = every(0.0), every(0.0)
        for m in range(w.mirrors):
            row = (MIRRORS + m * MIRROR) * rows + i
            v_p, kappa = _pinched(t, load(side, row + 2 * rows) - t.threshold)
            around = root(v_p * v_p + 2.0 * w.u_t * w.u_t)
            scale = load(side, row) / (1.0 + t.reduction * 0.5 * (v_p + around))
            x = half * (v_p - kappa * load(side, row + rows))
            forward, reverse, _, by_x = softplus_of_two(x, x - half * drain)
            plain = (forward - reverse) * (forward + reverse)
            early = t.early / (1.0 + t.early_rise * (forward + reverse))
            along = 1.0 + early * drain
            total = total + scale * plain * along
            slope = slope + scale * (plain * early + 2.0 * half * reverse * by_x * along)
        store(side, TAKEN * rows + i, total)
        store(side, BY_INPUT * rows + i, slope)


@_compiled
def _evaluate(w: Whole, v: F64, cells: int, leader: int) -> None:
    """Fill in the currents of mk, m1, m2 and the mirrors of all cells, and their derivatives.

    v: v_in, risks and v_common, V, and of a leader's `share` the drop below the supply; leader: -1 for none.
    """
    flat, span, c = w.flat, w.span, v[2 * cells]
    rows, reach = span // WIDTH, w.mirrors // 2
    one, two = (M1 - MK) * DEVICE * span, (M2 - MK) * DEVICE * span
    for k in range(cells):
        flat[DRAIN * span + k] = flat[GATE * span + k] = v[cells + k]
        flat[one + DRAIN * span + k], flat[one + GATE * span + k] = v[k], c
        flat[two + DRAIN * span + k], flat[two + GATE * span + k] = w.quiet, v[k]
        flat[two + SOURCE * span + k] = c
    if leader >= 0:
        flat[two + DRAIN * span + leader] = w.v_dd - v[2 * cells + 1]
    for m in range(w.mirrors):
        gate = (MIRRORS + m * MIRROR + 2) * span
        for k in range(max(0, reach - m), min(cells, cells + reach - m)):
            flat[gate + k] = v[cells + k + m - reach]
    for d in range(MK, M2 + 1):
        _devices(w, (d - MK) * DEVICE, _of(w.shared[d]), rows)
    _mirrors(w, _of(w.shared[MG]), rows)


@_inlined
def _at(w: Whole, device: int, quantity: int, k: int) -> float:
    """A number of mk, m1 or m2 of cell k that `_evaluate` has filled in."""
    found: float = w.flat[((device - MK) * DEVICE + quantity) * w.span + k]
    return found


@_inlined
def _net(w: Whole, v: F64, k: int) -> tuple[float, float]:
    """Current that is left for m1 of cell k, A, and its derivative by v_in, S, as `_evaluate` found them."""
    slope = w.work[GIVEN_SLOPE, k]
    net = w.work[GIVEN, k] + slope * v[k] - w.flat[TAKEN * w.span + k] - w.leak[0]
    return net, slope - w.flat[BY_INPUT * w.span + k]


@_compiled
def _rest(w: Whole, cells: int) -> bool:
    """Fill in the rest where all v_in are joined; false where there is none.

    Newton's method on the joined v_in, v_common and the middle of the joint's two diodes.
    """
    v = w.work[V]
    x, c, h = w.near
    for _ in range(_ROUNDS):
        top, top_d, top_g, top_s = _carried(_of(w.shared[MD]), x, x, h)
        low, low_d, low_g, _ = _carried(_of(w.shared[ME]), h, h, 0.0)
        sunk, sunk_d, _, _ = _carried(_of(w.shared[MT]), c, w.v_tail, 0.0)
        f_x, f_xx, f_xc, f_c, f_cx, f_cc = -top, -top_d - top_g, 0.0, -sunk, 0.0, -sunk_d
        for k in range(cells):
            v[k] = x
        v[2 * cells] = c
        _evaluate(w, v, cells, -1)
        for k in range(cells):
            net, slope = _net(w, v, k)
            f_x, f_xx = f_x + net - _at(w, M1, CARRIED, k), f_xx + slope - _at(w, M1, BY_DRAIN, k)
            f_xc -= _at(w, M1, BY_GATE, k)
            f_c, f_cx = f_c + _at(w, M2, CARRIED, k), f_cx + _at(w, M2, BY_GATE, k)
            f_cc += _at(w, M2, BY_SOURCE, k)
        f_h, f_hx, f_hh, f_xh = top - low, top_d + top_g, top_s - low_d - low_g, -top_s
        # h first: it touches x alone
        f_xx, f_x = f_xx - f_xh * f_hx / f_hh, f_x - f_xh * f_h / f_hh
        determinant = f_xx * f_cc - f_xc * f_cx
        d_x = (f_xc * f_c - f_cc * f_x) / determinant
        d_c = (f_cx * f_x - f_xx * f_c) / determinant
        d_h = -(f_h + f_hx * d_x) / f_hh
        far = max(abs(d_x), abs(d_c), abs(d_h))
        part = min(1.0, _FARTHEST / far)
        x, c, h = x + part * d_x, c + part * d_c, h + part * d_h
        if far < _EXACT:
            for k in range(cells):
                v[k] = x
            v[2 * cells] = c
            return True
    return False


@_compiled
def _rates(w: Whole, v: F64, risk: F64, leader: int, out: F64, matrix: F64) -> int:
    """Rates of change of all nodes, V/s, into `out`; returns the cell that carries most of the tail.

    matrix: rows of the step's matrix, which are filled in too. v: v_in, risks, v_common, drop of the leader's
    `share` below the supply, and its `taken`, V.
    """
    cells = risk.size
    nodes = 2 * cells + 1
    current, slope, gm1, gm2 = w.work[CURRENT], matrix[0], matrix[1], matrix[2]
    _evaluate(w, v, cells, leader)
    sunk, sunk_d, _, _ = _carried(_of(w.shared[MT]), v[2 * cells], w.v_tail, 0.0)
    balance, balance_d, most, first = -sunk, -sunk_d, -1.0, 0
    for k in range(cells):
        net, net_d = _net(w, v, k)
        part = _at(w, M2, CARRIED, k)
        current[k] = net - _at(w, M1, CARRIED, k)
        current[cells + k] = risk[k] - w.leak[1] - _at(w, MK, CARRIED, k)
        balance, balance_d = balance + part, balance_d + _at(w, M2, BY_SOURCE, k)
        slope[k] = net_d - _at(w, M1, BY_DRAIN, k)
        slope[cells + k] = -_at(w, MK, BY_DRAIN, k) - _at(w, MK, BY_GATE, k)
        gm1[k], gm2[k] = -_at(w, M1, BY_GATE, k), _at(w, M2, BY_GATE, k)
        if part > most:
            most, first = part, k
    led, led_s = _at(w, M2, CARRIED, leader), _at(w, M2, BY_SOURCE, leader)
    current[2 * cells] = balance
    slope[2 * cells], gm1[2 * cells] = balance_d, led_s
    for i in range(nodes):
        out[i] = 0.0
    for j in range(nodes):
        for i in range(nodes):  # side by side, as the matrix is symmetric
            out[i] += w.inverse_capacitance[j, i] * current[j]
    _comparator(w, v, leader, nodes, led, out, matrix)
    return first


@_compiled
def _comparator(w: Whole, v: F64, k: int, nodes: int, led: float, out: F64, matrix: F64) -> None:
    """Rates of the leader's `share` and `taken`; led: current of its m2, A."""
    slope, gm1 = matrix[0], matrix[1]
    e, y = v[nodes], v[nodes + 1]
    mo, mo_d, mo_g, _ = _carried(_of(w.own[MO, k]), e, e, 0.0)
    mb, mb_d, _, _ = _carried(_of(w.own[MB, k]), w.v_dd - e, w.v_tail, 0.0)
    ms, ms_d, ms_g, _ = _carried(_of(w.own[MS, k]), w.v_dd - y, e, 0.0)
    mr, mr_d, _, _ = _carried(_of(w.own[MR, k]), y, w.v_tail, 0.0)
    out[nodes] = (led + mb - mo) / w.share_capacitance
    out[nodes + 1] = (ms - mr) / w.taken_capacitance
    slope[nodes], slope[nodes + 1] = -mb_d - mo_d - mo_g, -ms_d - mr_d
    gm1[nodes + 1] = ms_g


@_compiled
def _solve(w: Whole, h: float, leader: int, cells: int, x: F64) -> None:
    """Replace x by `(1 - gamma h A)^-1 x` with the step's matrix A."""
    slope, gm1, gm2 = w.work[SLOPE], w.work[GM1], w.work[GM2]
    step, common = _GAMMA * h, 2 * cells
    inverse = w.inverse_capacitance
    for k in range(cells, common):
        x[k] /= 1.0 - step * inverse[k, k] * slope[k]
    pivot, right = 1.0 - step * inverse[common, common] * slope[common], x[common]
    for k in range(cells):
        own = 1.0 - step * inverse[k, k] * slope[k]
        up = step * inverse[common, common] * gm2[k]
        x[k] /= own
        right += up * x[k]
        pivot -= up * step * inverse[k, k] * gm1[k] / own
    x[common] = right / pivot
    for k in range(cells):
        own = 1.0 - step * inverse[k, k] * slope[k]
        x[k] += step * inverse[k, k] * gm1[k] / own * x[common]
    a = step / w.share_capacitance
    x[common + 1] += a * (gm2[leader] * x[leader] + gm1[common] * x[common])
    x[common + 1] /= 1.0 - a * slope[common + 1]
    b = step / w.taken_capacitance
    x[common + 2] = (x[common + 2] + b * gm1[common + 2] * x[common + 1]) / (1.0 - b * slope[common + 2])


@_compiled
def _merits(w: Whole, leader: int, cells: int, merit: F64) -> tuple[int, float]:
    """Merits of all cells with the risks at rest, A; returns the greatest and its margin over the second.

    All at the leader's v_in and at v_common. A merit is a cell's current over the strength of its m1, which
    is what that takes there over what it would without deviations.
    """
    v, rest, at = w.work[V], w.work[REST], w.work[NEXT]
    drain, c = v[leader], v[2 * cells]
    for k in range(cells):
        at[k], at[cells + k] = drain, rest[cells + k]
    at[2 * cells] = c
    _evaluate(w, at, cells, -1)
    plain = _carried(_of(w.shared[M1]), drain, c, 0.0)[0]
    best, second = -1, -1
    for k in range(cells):
        net = _net(w, at, k)[0]
        merit[k] = net * plain / _at(w, M1, CARRIED, k) if net > 0.0 else net
        if best < 0 or merit[k] > merit[best]:
            best, second = k, best
        elif second < 0 or merit[k] > merit[second]:
            second = k
    if merit[best] <= 0.0:
        return NOBODY, 0.0
    return best, math.log(merit[best] / merit[second]) if merit[second] > 0.0 else math.inf


@_compiled
def decide_whole(w: Whole, excite: F64, risk: F64, scratch: F64) -> tuple[int, float, float]:
    """Return what `chips.selection.kernel.decide` does, under the whole law.

    The rows of the working space: voltages, currents, both stages of a step, voltages to be, slopes of the
    nodes' own currents, of those of v_common and of the v_in on each other, voltages at rest; what the
    mirrors of the excitations give at 0 V and its slope; rates, and room for slopes that nobody asks for.
    """
    cells = excite.size
    v, rest = w.work[V], w.work[REST]
    _prepare(w, excite, risk)
    for k in range(cells):
        v[k] = w.near[0]
        rest[cells + k] = v[cells + k]
    v[2 * cells] = w.near[1]
    leader, time, winner, margin = 0, math.inf, NOBODY, 0.0
    for decided in (False, True):
        if decided:
            leader, time = _run(w, risk)
        winner, margin = _merits(w, leader, cells, scratch[0])
        if winner == NOBODY or (not decided and not _rest(w, cells)):
            return NOBODY, math.inf, 0.0
    if time < math.inf and winner != leader:
        return leader, time, 0.0
    return winner, time, margin


@_compiled
def _run(w: Whole, risk: F64) -> tuple[int, float]:
    """From the rest to when `taken` of a cell passes its threshold: the cell, and the time, s, or inf.

    Each function is called in one place, for what is called in several is compiled as often.
    """
    cells = risk.size
    last = 2 * cells + 2  # taken
    v, ahead = w.work[V], w.work[NEXT]
    leader, time, h, moved, led = cells - 1, 0.0, _FIRST, True, False
    for _ in range(_STEPS):
        if moved:
            first = _rates(w, v, risk, leader, w.work[RATE], w.work[SLOPE:REST])
            if not led and (first != leader or time == 0.0):
                leader, led = first, True
                _lead(w, leader, cells)
                continue
            led = False
        error, threshold = _step(w, risk, h, leader), w.threshold_of_line[leader]
        moved = (error <= 1.0 and ahead[last] < threshold + 0.5 * _TAKEN) or h < _SHORTEST
        if moved:
            time += h
            if ahead[last] > threshold - 0.5 * _TAKEN:
                return leader, w.begin + time - (ahead[last] - threshold) * h / (ahead[last] - v[last])
            for i in range(last + 1):
                v[i] = ahead[i]
            if time >= LONGEST:
                break
            h *= min(3.0, 0.9 / math.sqrt(max(error, 1e-6)))
            continue
        smaller = 0.9 / math.sqrt(error)
        if error <= 1.0:
            smaller = (threshold - v[last]) / (ahead[last] - v[last])
        h *= min(max(smaller, 0.05), 0.95)
    return leader, math.inf


@_compiled
def _step(w: Whole, risk: F64, h: float, leader: int) -> float:
    """Fill in the voltages after a step of h, s; returns its error over what is allowed."""
    v, k1, k2, ahead, rate = w.work[V], w.work[K1], w.work[K2], w.work[NEXT], w.work[RATE]
    cells, size = risk.size, v.size
    for i in range(size):
        k1[i] = rate[i]
    _solve(w, h, leader, cells, k1)
    for i in range(size):
        ahead[i] = v[i] + h * k1[i]
    _rates(w, ahead, risk, leader, k2, w.work[SPARE:])
    for i in range(size):
        k2[i] -= 2.0 * k1[i]
    _solve(w, h, leader, cells, k2)
    most = 0.0
    for i in range(size):
        allowed = _FINE
        if i < cells:
            allowed += _BEHIND * max(v[leader] - v[i], 0.0)
        elif i == size - 1:
            allowed = _TAKEN
        most = max(most, 0.5 * h * abs(k1[i] + k2[i]) / allowed)
        ahead[i] = v[i] + h * (1.5 * k1[i] + 0.5 * k2[i])
    return most


@_compiled
def _lead(w: Whole, leader: int, cells: int) -> None:
    """Put the comparator of a new leader to rest, whose `taken` is then at ground."""
    v = w.work[V]
    part = _carried(_of(w.own[M2, leader]), w.quiet, v[leader], v[2 * cells])[0]
    bleed = _carried(_of(w.own[MB, leader]), w.quiet, w.v_tail, 0.0)[0]
    v[2 * cells + 1] = _diode_gate(_of(w.own[MO, leader]), part + bleed, w.v_dd - w.quiet)
    v[2 * cells + 2] = 0.0
