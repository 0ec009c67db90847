"""Currents at rest in the small networks of transistors that ROLLS consists of, solved by the EKV law.

Every voltage is in units of U_T and counted from the bulk (downwards from the supply for pFETs), a gate
enters as its pinch-off voltage `p = kappa (v_g - V_T0) / U_T`, and `F(u) = ln^2(1 + e^(u/2))`, so that a
transistor carries `I_S [F(p - v_s) - F(p - v_d)]`. All arrays are float64[n] and of one length.

Networks are solved side by side in the lanes of a team (`chips.rolls.lumped.team`): a lane has the bits that
its network has by itself.
"""

from __future__ import annotations

import math

import numpy as np

from chips.rolls.lumped.team import (
    EXACT,
    GIVEN,
    ITERATIONS,
    LANES,
    LEFT,
    START,
    Y,
    between,
    closer,
    exchanged,
    moved,
    moved_to_end,
    not_beyond,
    team_of,
)
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.ekv import law
from circuits.devices.packable import even_interpolation, even_law

_A, _B, _C, _D, _E, _F, _G, _H, _I = (LANES * k for k in range(GIVEN, GIVEN + 9))


@compiled()
def _stack(i1: float, p1: float, i2: float, p2: float, drain: float) -> float:
    """Voltage between two transistors in series, the lower one's source at 0."""
    low, high = min(drain, 0.0), max(drain, 0.0)
    y = 0.5 * (low + high)
    f1, _ = law(p1)
    f2, _ = law(p2 - drain)
    for _ in range(ITERATIONS):
        a, da = law(p1 - y)
        b, db = law(p2 - y)
        f = i1 * (f1 - a) - i2 * (b - f2)
        low, high = closer(y, f, low, high)
        new = between(y - f / (i1 * da + i2 * db), low, high)
        if abs(new - y) < EXACT:
            break
        y = new
    return y


@compiled()
def stack_current(i1: float, p1: float, i2: float, p2: float, drain: float) -> float:
    """Return the current of two transistors in series between 0 and `drain`, A."""
    y = _stack(i1, p1, i2, p2, drain)
    full, passed = law(p1)[0], law(p2 - y)[0]
    # of the transistor that limits, or a small current is the difference of two large ones
    if i1 * full < i2 * passed:
        return i1 * (full - law(p1 - y)[0])
    return i2 * (passed - law(p2 - drain)[0])


@compiled()
def _stack_moves(w: F64, active: int) -> None:
    """Newton's step of all active lanes of `stack`."""
    for j in range(min(active, LANES)):
        a, da = even_law(w[_B + j] - w[Y + j])
        b, db = even_law(w[_D + j] - w[Y + j])
        f = w[_A + j] * (w[_E + j] - a) - w[_C + j] * (b - w[_F + j])
        moved(w, j, f, f / (w[_A + j] * da + w[_C + j] * db))


@compiled(_nrt=True)
def stack(i1: F64, p1: F64, i2: F64, p2: F64, drain: F64, out: F64) -> None:
    """Fill `out` with `stack_current` of each network."""
    given = np.empty((START + 6, out.size))
    for k in range(out.size):
        low, high = min(drain[k], 0.0), max(drain[k], 0.0)
        given[0, k], given[1, k], given[2, k] = 0.5 * (low + high), low, high
        given[3, k], given[4, k], given[5, k], given[6, k] = i1[k], p1[k], i2[k], p2[k]
        given[7, k], given[8, k] = even_interpolation(p1[k]), even_interpolation(p2[k] - drain[k])
    rows, points, found = np.empty((0, out.size)), given.reshape(given.shape[0], -1, 1), out.reshape(-1, 1)
    w, who, active, following = team_of(rows, points)
    while active > 0:
        _stack_moves(w, active)
        active, following = exchanged(w, who, rows, points, found, active, following, Y)
    for k in range(out.size):
        full, passed, last = given[7, k], even_interpolation(p2[k] - out[k]), given[8, k]
        by_first = i1[k] * (full - even_interpolation(p1[k] - out[k]))
        # of the transistor that limits, as `stack_current`
        out[k] = by_first if i1[k] * full < i2[k] * passed else i2[k] * (passed - last)


@compiled()
def _diode_moves(w: F64, active: int, kappa: float) -> None:
    """Newton's step of all active lanes of `diode`."""
    for j in range(min(active, LANES)):
        p1 = kappa * (w[Y + j] - w[_B + j])
        a, da = even_law(p1)
        b, db = even_law(p1 - w[Y + j])
        f = w[_A + j] * (a - b) - w[_C + j]
        moved(w, j, f, f / (w[_A + j] * (kappa * da - (kappa - 1.0) * db)))


@compiled(_nrt=True)
def diode(i1: F64, t1: F64, kappa: float, current: F64, highest: float, out: F64) -> None:
    """Fill `out` with the voltage across a diode-connected transistor, from 0 to `highest`.

    t1: threshold; current: that it carries, A.
    """
    given = np.empty((START + 3, out.size))
    for k in range(out.size):
        y = min(max(t1[k] + (math.log(max(current[k], 1e-30) / i1[k])) / kappa, 0.0), highest)
        given[0, k], given[1, k], given[2, k] = y, 0.0, highest
        given[3, k], given[4, k], given[5, k] = i1[k], t1[k], current[k]
    rows, points, found = np.empty((0, out.size)), given.reshape(given.shape[0], -1, 1), out.reshape(-1, 1)
    w, who, active, following = team_of(rows, points)
    while active > 0:
        _diode_moves(w, active, kappa)
        active, following = exchanged(w, who, rows, points, found, active, following, Y)


@compiled()
def _amplifier_moves(w: F64, active: int, supply: float) -> None:
    """Newton's step of all active lanes of `amplifier`."""
    for j in range(min(active, LANES)):
        a, da = even_law(w[_B + j] - supply + w[Y + j])
        b, db = even_law(w[_D + j] - w[Y + j])
        f = w[_C + j] * (w[_F + j] - b) - w[_A + j] * (w[_E + j] - a)
        moved(w, j, f, f / (w[_A + j] * da + w[_C + j] * db))


@compiled(_nrt=True)
def amplifier(i1: F64, p1: F64, i2: F64, p2: F64, supply: float, out: F64) -> None:
    """Fill `out` with how far an amplifier's output is below the supply.

    The nFET (i1, p1) pulls it down, the pFET (i2, p2) holds it up.
    """
    given = np.empty((START + 6, out.size))
    for k in range(out.size):
        given[0, k], given[1, k], given[2, k] = 0.0, 0.0, supply
        given[3, k], given[4, k], given[5, k], given[6, k] = i1[k], p1[k], i2[k], p2[k]
        given[7, k], given[8, k] = even_interpolation(p1[k]), even_interpolation(p2[k])
    rows, points, found = np.empty((0, out.size)), given.reshape(given.shape[0], -1, 1), out.reshape(-1, 1)
    w, who, active, following = team_of(rows, points)
    while active > 0:
        _amplifier_moves(w, active, supply)
        active, following = exchanged(w, who, rows, points, found, active, following, Y)


@compiled()
def pair_share(i1: float, a: float, i2: float, b: float, total: float) -> float:
    """Return the current of the second of two saturated transistors with a common source, A.

    They carry `total` (A) together; a, b: their pinch-off voltages. Newton's method on the logarithm of the
    total begins at weak inversion, where it is exact.
    """
    if total <= 0.0:
        return 0.0
    top = max(a, b)
    w = math.log(total / (i1 * math.exp(a - top) + i2 * math.exp(b - top))) - top
    f2 = 0.0
    for _ in range(ITERATIONS):
        f1, d1 = law(a + w)
        f2, d2 = law(b + w)
        sum_ = i1 * f1 + i2 * f2
        step = math.log(total / sum_) * sum_ / (i1 * d1 + i2 * d2)
        w += step
        if abs(step) < 1e-9:
            break
    return i2 * law(b + w)[0]


@compiled()
def _pair_moves(w: F64, active: int) -> None:
    """Newton's step of all active lanes of `pair`, whose logarithms are taken one by one."""
    for j in range(min(active, LANES)):
        f1, d1 = even_law(w[_B + j] + w[Y + j])
        f2, d2 = even_law(w[_D + j] + w[Y + j])
        w[_F + j] = w[_A + j] * f1 + w[_C + j] * f2
        w[_G + j] = w[_A + j] * d1 + w[_C + j] * d2
    for j in range(min(active, LANES)):
        step = math.log(w[_E + j] / w[_F + j]) * w[_F + j] / w[_G + j]
        w[Y + j] += step
        w[LEFT + j] = 0.0 if abs(step) < 1e-9 else w[LEFT + j] - 1.0


@compiled(_nrt=True)
def pair(i1: F64, a: F64, i2: F64, b: F64, total: F64, out: F64) -> None:
    """Fill `out` with `pair_share` of each network."""
    given = np.empty((START + 7, out.size))
    for k in range(out.size):
        top = max(a[k], b[k])
        # without a current there is nothing to divide: taken for one, and nothing below
        some = total[k] if total[k] > 0.0 else i2[k]
        given[0, k] = math.log(some / (i1[k] * math.exp(a[k] - top) + i2[k] * math.exp(b[k] - top))) - top
        given[1, k], given[2, k], given[3, k], given[4, k] = 0.0, 0.0, i1[k], a[k]
        given[5, k], given[6, k], given[7, k] = i2[k], b[k], some
    rows, points, found = np.empty((0, out.size)), given.reshape(given.shape[0], -1, 1), out.reshape(-1, 1)
    w, who, active, following = team_of(rows, points)
    while active > 0:
        _pair_moves(w, active)
        active, following = exchanged(w, who, rows, points, found, active, following, Y)
    for k in range(out.size):
        share = i2[k] * even_interpolation(b[k] + out[k])
        out[k] = share if total[k] > 0.0 else 0.0


@compiled()
def _degenerated_sum_moves(w: F64, active: int) -> None:
    """Newton's step of all active lanes of `degenerated_sum`."""
    for j in range(min(active, LANES)):
        y = w[Y + j]
        b, db = even_law(w[_H + j] - y)
        f, df = w[_G + j] * (w[_I + j] - b), w[_G + j] * db
        a, da = even_law(w[_B + j] - y)
        f, df = f - w[_A + j] * a, df + w[_A + j] * da
        a, da = even_law(w[_D + j] - y)
        f, df = f - w[_C + j] * a, df + w[_C + j] * da
        a, da = even_law(w[_F + j] - y)
        f, df = f - w[_E + j] * a, df + w[_E + j] * da
        moved_to_end(w, j, f, f / df)


@compiled(_nrt=True)
def degenerated_sum(i_top: F64, p_top: F64, lines: F64, far: float, out: F64) -> None:
    """Fill `out` with the sum of three saturated currents whose common source hangs on a switch, A.

    i_top, p_top: of the switch, whose source is at the bulk; lines: specific current and pinch-off voltage of
    each of the three, float64[6, n]; far: voltage of the common source at most.
    """
    given = np.empty((START + 9, out.size))
    for k in range(out.size):
        for row in range(6):
            given[START + row, k] = lines[row, k]
        given[0, k], given[1, k], given[2, k] = 0.0, 0.0, far
        given[9, k], given[10, k], given[11, k] = i_top[k], p_top[k], even_interpolation(p_top[k])
    rows, points, found = np.empty((0, out.size)), given.reshape(given.shape[0], -1, 1), out.reshape(-1, 1)
    w, who, active, following = team_of(rows, points)
    while active > 0:
        _degenerated_sum_moves(w, active)
        active, following = exchanged(w, who, rows, points, found, active, following, Y)
    for k in range(out.size):
        y = out[k]
        total = lines[0, k] * even_interpolation(lines[1, k] - y)
        total += lines[2, k] * even_interpolation(lines[3, k] - y)
        out[k] = total + lines[4, k] * even_interpolation(lines[5, k] - y)


@compiled()
def sink_over_line(i_top: F64, p_top: F64, lines: F64, grid: F64, out: F64) -> None:
    """Fill `out` with the current that three transistors at ground draw through a switch from a line, A.

    grid: voltages of the line; out: float64[n, grid]; the others as in `degenerated_sum`.
    """
    for k in range(i_top.size):
        for g in range(grid.size):
            low, high = 0.0, grid[g]
            y = high
            far = law(p_top[k] - grid[g])[0]
            total = 0.0
            for _ in range(ITERATIONS):
                b, db = law(p_top[k] - y)
                f, df = -i_top[k] * (b - far), i_top[k] * db
                total = 0.0
                for j in range(3):
                    i, p = lines[2 * j, k], lines[2 * j + 1, k]
                    c, dc = law(p - y)
                    total += i * (law(p)[0] - c)
                    df += i * dc
                f += total
                low, high = closer(y, f, low, high)
                new = not_beyond(y - f / df, low, high)
                if abs(new - y) < EXACT:
                    break
                y = new
            out[k, g] = total
