"""The networks of `chips.rolls.lumped.network` under the law with second-order effects, junctions included.

Every voltage is in V and counted from the bulk (downwards from the supply for pFETs). A device comes as its
numbers at each place, `rows`, float64[TERMS, n] in the order of `circuits.devices.channel.Terms`, with its
gate. Each network has one unknown node, whose balance of currents rises or falls throughout: Newton's method
between bounds. gate, drain, current: float64[n, points], at so many points of each place; out: the same.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import Terms, channel, leaked, pinched, terms_of
from circuits.devices.ekv import argument_of_root, root
from circuits.lowering.on_die import DieDevices, Fet

TERMS = len(Terms._fields)
_ITERATIONS = 80
_EXACT = 1e-9  # V, last update of a voltage by Newton's method, which leaves its square over U_T
_NUDGE = 1e-3  # V, of a numerical slope
_WIDEST = 0.1  # V, ours: of a step of a pair's common source


def rows_of(fet: Fet) -> F64:
    """Return the numbers of a device at each of its places, float64[TERMS, n]."""
    lone = terms_of(fet.law, 1.0, 1.0, 0.0, 0.0)
    n = fet.current.size
    found = np.empty((TERMS, n))
    for k, (name, value) in enumerate(zip(Terms._fields, lone, strict=True)):
        found[k] = {
            "specific": fet.current, "threshold": fet.threshold, "early": value / fet.length,
            "leakage": value * fet.width, "induced": value * fet.width,
        }.get(name, value)  # fmt: skip
    return found


def points_of(value: ArrayLike, n: int, points: int) -> F64:
    """Return one value a place, or one a point, or one for all, as one a point: float64[n, points]."""
    given = np.asarray(value, dtype=np.float64)
    given = given if given.ndim == 2 else np.reshape(given, (-1, 1))
    return np.ascontiguousarray(np.broadcast_to(given, (n, points)))


def middle_of(d: DieDevices, device: str) -> F64:
    """Return the numbers of a device as the mean of its places has them, float64[TERMS, 1]."""
    return np.asarray(rows_of(d.fet[device]).mean(axis=1, keepdims=True))


def coupling(d: DieDevices, device: str, gate: F64 | float) -> float:
    """Return dv_p/dv_g of a device at a gate (V over the bulk), the mean of its places, dimensionless."""
    more, less = (d.pinch(device, np.asarray(gate) + x) for x in (_NUDGE, -_NUDGE))
    return float(np.mean((more - less) * d.u_t / (2.0 * _NUDGE)))


@compiled(forceinline=True)
def terms_at(rows: F64, k: int) -> Terms:
    """Return the numbers of place k."""
    return Terms(
        rows[0, k], rows[1, k], rows[2, k], rows[3, k], rows[4, k], rows[5, k], rows[6, k], rows[7, k],
        rows[8, k], rows[9, k], rows[10, k], rows[11, k], rows[12, k],
    )  # fmt: skip


@compiled(forceinline=True)
def guess(new: float, low: float, high: float) -> float:
    """Return a guess that is between its bounds, else their middle."""
    return new if low < new < high else 0.5 * (low + high)


@compiled(forceinline=True)
def first_between(lower: Terms, upper: Terms, gates: tuple[float, float], ends: tuple[float, float]) -> float:
    """Return what is between two devices in series without second-order effects, V, by what either carries.

    In weak inversion that is exact: `I = A B / (A + B)`, of which the end of the device that does not limit
    is made. ends: of the lower source and the upper drain.
    """
    p, q = pinched(lower, gates[0])[0], pinched(upper, gates[1])[0]
    begin, end = root(2.0 * lower.half * (p - ends[0])) ** 2, root(2.0 * upper.half * (q - ends[1])) ** 2
    a, b = lower.specific * begin, upper.specific * root(2.0 * upper.half * (q - ends[0])) ** 2
    current = a * (b - upper.specific * end) / (a + b)
    if a < b:
        return q - 0.5 / upper.half * argument_of_root(math.sqrt(end + current / upper.specific))
    return p - 0.5 / lower.half * argument_of_root(math.sqrt(max(begin - current / lower.specific, 0.0)))


@compiled()
def series_current(lower: Terms, upper: Terms, low_gate: float, high_gate: float, drain: float) -> float:
    """Return what flows into the drain of the upper of two transistors in series, A."""
    low, high, moved = min(drain, 0.0), max(drain, 0.0), 0.0
    y = guess(first_between(lower, upper, (low_gate, high_gate), (0.0, drain)), low, high)
    by_lower = by_upper = below = above = 0.0
    for _ in range(_ITERATIONS):
        below, by_lower, _, _ = channel(lower, y, low_gate, 0.0)
        above, _, _, by_upper = channel(upper, drain, high_gate, y)
        first, by_first, _ = leaked(lower, y, low_gate)
        second, by_second, _ = leaked(upper, y, high_gate)
        below += first + second
        by_lower += by_first + by_second
        f = below - above
        if f > 0.0:
            high = y
        else:
            low = y
        moved = guess(y - f / (by_lower - by_upper), low, high) - y
        if abs(moved) < _EXACT:
            break
        y += moved
    # of the transistor that limits, or a small current is the difference of two large ones
    current = below + by_lower * moved if by_lower < -by_upper else above + by_upper * moved
    return current + leaked(upper, drain, high_gate)[0]


@compiled()
def series(lower: F64, upper: F64, low_gate: F64, high_gate: F64, drain: F64, out: F64) -> None:
    """Fill `out` with `series_current` of each network, A."""
    for k in range(out.shape[0]):
        a, b = terms_at(lower, k), terms_at(upper, k)
        for j in range(out.shape[1]):
            out[k, j] = series_current(a, b, low_gate[k, j], high_gate[k, j], drain[k, j])


@compiled()
def diode_voltage(t: Terms, current: float, highest: float) -> float:
    """Return the voltage across a diode-connected transistor that carries `current` (A), up to `highest`."""
    return diode_from(t, current, highest, 0.5 * highest)


@compiled()
def diode_from(t: Terms, current: float, highest: float, y: float, foot: float = 0.0) -> float:
    """Return what `diode_voltage` does, from a guess `y`, V; foot: where its source is, V."""
    low, high = 0.0, highest
    for _ in range(_ITERATIONS):
        carried, by_drain, by_gate, _ = channel(t, y, y, foot)
        leak, by_junction, by_induced = leaked(t, y, y)
        f = carried + leak - current
        if f > 0.0:
            high = y
        else:
            low = y
        slope = by_drain + by_gate + by_junction + by_induced
        # on the logarithm of the current, which is nearly a line
        if carried + leak > 0.0 and current > 0.0:
            new = y - math.log((carried + leak) / current) * (carried + leak) / slope
        else:
            new = y - f / slope
        new = guess(new, low, high)
        if abs(new - y) < _EXACT:
            return new
        y = new
    return y


@compiled()
def diode(rows: F64, current: F64, highest: float, out: F64) -> None:
    """Fill `out` with `diode_voltage` of each network, V."""
    for k in range(out.shape[0]):
        t = terms_at(rows, k)
        for j in range(out.shape[1]):
            out[k, j] = diode_voltage(t, current[k, j], highest)


@compiled()
def amplifier(pull: F64, hold: F64, gate: F64, bias: F64, supply: float, out: F64) -> None:
    """Fill `out` with how far an amplifier's output is below the supply, V.

    The nFET `pull` with its gate pulls it down, the pFET `hold` with its bias holds it up.
    """
    for k in range(out.shape[0]):
        n, p = terms_at(pull, k), terms_at(hold, k)
        for j in range(out.shape[1]):
            low, high, y = 0.0, supply, 0.0
            for _ in range(_ITERATIONS):
                up, by_up, _, _ = channel(p, y, bias[k, j], 0.0)
                down, by_down, _, _ = channel(n, supply - y, gate[k, j], 0.0)
                held, by_held, _ = leaked(p, y, bias[k, j])
                lost, by_lost, _ = leaked(n, supply - y, gate[k, j])
                f = up + held - down - lost
                if f > 0.0:
                    high = y
                else:
                    low = y
                moved = guess(y - f / (by_up + by_held + by_down + by_lost), low, high) - y
                y += moved
                if abs(moved) < _EXACT:
                    break
            out[k, j] = y


@compiled()
def pair_source(
    first: Terms, second: Terms, gates: tuple[float, float], drains: tuple[float, float], total: float
) -> float:
    """Return the common source of two transistors that carry `total` (A, above zero) together, V."""
    y = max(pinched(first, gates[0])[0], pinched(second, gates[1])[0])
    return _shared(first, second, gates, drains, (total, y))


@compiled(forceinline=True)
def _shared(
    first: Terms, second: Terms, gates: tuple[float, float], drains: tuple[float, float],
    known: tuple[float, float],
) -> float:  # fmt: skip
    """Common source of a pair; known: what both carry, A, and a guess of the source, V."""
    total, y = known
    for _ in range(_ITERATIONS):
        a, _, _, by_a = channel(first, drains[0], gates[0], y)
        b, _, _, by_b = channel(second, drains[1], gates[1], y)
        carried = a + b
        step = math.log(carried / total) * carried / -(by_a + by_b) if carried > 0.0 else -_WIDEST
        step = min(max(step, -_WIDEST), _WIDEST)
        y += step
        if abs(step) < _EXACT:
            break
    return y


@compiled()
def pair(
    first: F64, second: F64, gates: tuple[F64, F64], drains: tuple[F64, F64], total: F64, out: F64
) -> None:
    """Fill `out` with the common source (V) of two transistors that carry `total` (A) together."""
    for k in range(out.shape[0]):
        a, b, y = terms_at(first, k), terms_at(second, k), 0.0
        for j in range(out.shape[1]):
            g, d = (gates[0][k, j], gates[1][k, j]), (drains[0][k, j], drains[1][k, j])
            y = pair_source(a, b, g, d, total[k, j]) if j == 0 else _shared(a, b, g, d, (total[k, j], y))
            out[k, j] = y


@compiled(forceinline=True)
def _fed(n: Terms, p: Terms, at: tuple[float, float], ends: tuple[float, float], y: float) -> float:
    """Gate of a diode that an nFET feeds, V, from a guess `y`.

    at: gate and source of the nFET, V; ends: supply and foot, V.
    """
    low, high = 0.0, ends[0]
    for _ in range(_ITERATIONS):
        held, by_drain, by_gate, _ = channel(p, y, y, ends[1])
        leak, by_junction, by_induced = leaked(p, y, y)
        drawn, by_drawn, _, _ = channel(n, ends[0] - y, at[0], at[1])
        lost, by_lost, _ = leaked(n, ends[0] - y, at[0])
        held += leak
        drawn += lost
        if held > drawn:
            high = y
        else:
            low = y
        by_held, by_drawn = by_drain + by_gate + by_junction + by_induced, by_drawn + by_lost
        # on the logarithm of the ratio, which is nearly a line
        if held > 0.0 and drawn > 0.0:
            new = y - math.log(held / drawn) / (by_held / held + by_drawn / drawn)
        else:
            new = y - (held - drawn) / (by_held + by_drawn)
        new = guess(new, low, high)
        if abs(new - y) < _EXACT:
            return new
        y = new
    return y


@compiled()
def fed_diode(
    drawing: F64, mirror: F64, gate: F64, source: F64, supply: float, out: F64, foot: float = 0.0
) -> None:
    """Fill `out` with the gate of a diode-connected pFET that an nFET draws its current from, V.

    gate, source: of the nFET, V; its drain is at the diode; foot: source of the diode, V below the supply.
    """
    for k in range(out.shape[0]):
        n, p = terms_at(drawing, k), terms_at(mirror, k)
        y = foot + 0.3 * (supply - foot)
        for j in range(out.shape[1]):
            y = _fed(n, p, (gate[k, j], source[k, j]), (supply, foot), y)
            out[k, j] = y
