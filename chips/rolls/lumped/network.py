"""Currents at rest in the small networks of transistors that ROLLS consists of, solved by the EKV law.

Every voltage is in units of U_T and counted from the bulk (downwards from the supply for pFETs), a gate
enters as its pinch-off voltage `p = kappa (v_g - V_T0) / U_T`, and `F(u) = ln^2(1 + e^(u/2))`, so that a
transistor carries `I_S [F(p - v_s) - F(p - v_d)]`. All arrays are float64[n] and of one length.
"""

from __future__ import annotations

import math

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.ekv import law

_ITERATIONS = 80
_EXACT = 1e-12  # U_T, last update of a voltage


@compiled(forceinline=True)
def _closer(y: float, f: float, low: float, high: float) -> tuple[float, float]:
    """Bounds of the root of a rising f, closer by what f is at y, which is between them."""
    return (low, y) if f > 0.0 else (y, high)


@compiled(forceinline=True)
def _between(new: float, low: float, high: float) -> float:
    """A guess that is between its bounds, else their middle."""
    return new if low < new < high else 0.5 * (low + high)


@compiled(forceinline=True)
def _not_beyond(new: float, low: float, high: float) -> float:
    """A guess that is between its bounds or one of them, else their middle."""
    return new if low <= new <= high else 0.5 * (low + high)


@compiled()
def _stack(i1: float, p1: float, i2: float, p2: float, drain: float) -> float:
    """Voltage between two transistors in series, the lower one's source at 0."""
    low, high = min(drain, 0.0), max(drain, 0.0)
    y = 0.5 * (low + high)
    f1, _ = law(p1)
    f2, _ = law(p2 - drain)
    for _ in range(_ITERATIONS):
        a, da = law(p1 - y)
        b, db = law(p2 - y)
        f = i1 * (f1 - a) - i2 * (b - f2)
        low, high = _closer(y, f, low, high)
        new = _between(y - f / (i1 * da + i2 * db), low, high)
        if abs(new - y) < _EXACT:
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
def stack(i1: F64, p1: F64, i2: F64, p2: F64, drain: F64, out: F64) -> None:
    """Fill `out` with `stack_current` of each network."""
    for k in range(out.size):
        out[k] = stack_current(i1[k], p1[k], i2[k], p2[k], drain[k])


@compiled()
def diode(i1: F64, t1: F64, kappa: float, current: F64, highest: float, out: F64) -> None:
    """Fill `out` with the voltage across a diode-connected transistor, from 0 to `highest`.

    t1: threshold; current: that it carries, A.
    """
    for k in range(out.size):
        low, high = 0.0, highest
        y = min(max(t1[k] + (math.log(max(current[k], 1e-30) / i1[k])) / kappa, 0.0), highest)
        for _ in range(_ITERATIONS):
            p1 = kappa * (y - t1[k])
            a, da = law(p1)
            b, db = law(p1 - y)
            f = i1[k] * (a - b) - current[k]
            low, high = _closer(y, f, low, high)
            new = _between(y - f / (i1[k] * (kappa * da - (kappa - 1.0) * db)), low, high)
            if abs(new - y) < _EXACT:
                break
            y = new
        out[k] = y


@compiled()
def amplifier(i1: F64, p1: F64, i2: F64, p2: F64, supply: float, out: F64) -> None:
    """Fill `out` with how far an amplifier's output is below the supply.

    The nFET (i1, p1) pulls it down, the pFET (i2, p2) holds it up.
    """
    for k in range(out.size):
        low, high = 0.0, supply
        pull, hold = law(p1[k])[0], law(p2[k])[0]
        y = 0.0
        for _ in range(_ITERATIONS):
            a, da = law(p1[k] - supply + y)
            b, db = law(p2[k] - y)
            f = i2[k] * (hold - b) - i1[k] * (pull - a)
            low, high = _closer(y, f, low, high)
            new = _between(y - f / (i1[k] * da + i2[k] * db), low, high)
            if abs(new - y) < _EXACT:
                break
            y = new
        out[k] = y


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
    for _ in range(_ITERATIONS):
        f1, d1 = law(a + w)
        f2, d2 = law(b + w)
        sum_ = i1 * f1 + i2 * f2
        step = math.log(total / sum_) * sum_ / (i1 * d1 + i2 * d2)
        w += step
        if abs(step) < 1e-9:
            break
    return i2 * law(b + w)[0]


@compiled()
def pair(i1: F64, a: F64, i2: F64, b: F64, total: F64, out: F64) -> None:
    """Fill `out` with `pair_share` of each network."""
    for k in range(out.size):
        out[k] = pair_share(i1[k], a[k], i2[k], b[k], total[k])


@compiled()
def degenerated_sum(i_top: F64, p_top: F64, lines: F64, far: float, out: F64) -> None:
    """Fill `out` with the sum of three saturated currents whose common source hangs on a switch, A.

    i_top, p_top: of the switch, whose source is at the bulk; lines: specific current and pinch-off voltage of
    each of the three, float64[6, n]; far: voltage of the common source at most.
    """
    for k in range(out.size):
        low, high = 0.0, far
        y = 0.0
        top = law(p_top[k])[0]
        for _ in range(_ITERATIONS):
            b, db = law(p_top[k] - y)
            f, df = i_top[k] * (top - b), i_top[k] * db
            for j in range(3):
                a, da = law(lines[2 * j + 1, k] - y)
                f -= lines[2 * j, k] * a
                df += lines[2 * j, k] * da
            low, high = _closer(y, f, low, high)
            new = _not_beyond(y - f / df, low, high)
            if abs(new - y) < _EXACT:
                break
            y = new
        total = 0.0
        for j in range(3):
            total += lines[2 * j, k] * law(lines[2 * j + 1, k] - y)[0]
        out[k] = total


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
            for _ in range(_ITERATIONS):
                b, db = law(p_top[k] - y)
                f, df = -i_top[k] * (b - far), i_top[k] * db
                total = 0.0
                for j in range(3):
                    i, p = lines[2 * j, k], lines[2 * j + 1, k]
                    c, dc = law(p - y)
                    total += i * (law(p)[0] - c)
                    df += i * dc
                f += total
                low, high = _closer(y, f, low, high)
                new = _not_beyond(y - f / df, low, high)
                if abs(new - y) < _EXACT:
                    break
                y = new
            out[k, g] = total
