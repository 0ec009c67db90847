"""The networks of `chips.rolls.lumped.network` under the law with second-order effects, junctions included.

Every voltage is in V and counted from the bulk (downwards from the supply for pFETs). A device comes as its
numbers at each place, `rows`, float64[TERMS, n] in the order of `circuits.devices.channel.Terms`, with its
gate. Each network has one unknown node, whose balance of currents rises or falls throughout: Newton's method
between bounds, of a team of networks side by side (`chips.rolls.lumped.team`). gate, drain, current:
float64[n, points], at so many points of each place; out: the same.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from chips.rolls.lumped.team import (
    FIRST,
    FOURTH,
    GIVEN,
    LANES,
    SECOND,
    START,
    THIRD,
    Y,
    bounded,
    exchanged,
    settled,
    team_of,
)
from circuits.arrays import F64, in_rows
from circuits.compiled import compiled
from circuits.devices.channel import Terms, channel, leaked, pinched, terms_of
from circuits.devices.ekv import argument_of_root
from circuits.devices.packable import even_channel, even_interpolation, even_leaked
from circuits.lowering.on_die import DieDevices, Fet

TERMS = len(Terms._fields)
_ITERATIONS = 80
_EXACT = 1e-9  # V, last update of a voltage by Newton's method, which leaves its square over U_T
_NUDGE = 1e-3  # V, of a numerical slope
_WIDEST = 0.1  # V, ours: of a step of a pair's common source
_A, _B, _C, _D, _E = (LANES * k for k in range(GIVEN, GIVEN + 5))  # what lanes are given of a point
_TERMS = 7 * LANES  # of both devices, behind what is of a first guess


def rows_of(fet: Fet) -> F64:
    """Return the numbers of a device at each of its places, float64[TERMS, n]."""
    lone = terms_of(fet.law, 1.0, 1.0, 0.0, 0.0)
    n = fet.current.size
    found = np.empty((TERMS, n))
    own: Mapping[str, F64] = {
        "specific": fet.current, "threshold": fet.threshold, "early": lone.early / fet.length,
        "leakage": lone.leakage * fet.width, "induced": lone.induced * fet.width,
    }  # fmt: skip
    for k, (name, value) in enumerate(zip(Terms._fields, lone, strict=True)):
        found[k] = own.get(name, value)
    return found


def points_of(value: ArrayLike, n: int, points: int) -> F64:
    """Return one value a place, or one a point, or one for all, as one a point: float64[n, points]."""
    given = np.asarray(value, dtype=np.float64)
    given = given if given.ndim == 2 else np.reshape(given, (-1, 1))
    return in_rows(np.broadcast_to(given, (n, points)))


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
def terms_in(w: F64, j: int, first: int, lanes: int = LANES) -> Terms:
    """Return the numbers of lane j, which stand from w[first] on in rows of so many lanes."""
    return Terms(
        w[first + j], w[first + lanes + j], w[first + 2 * lanes + j], w[first + 3 * lanes + j],
        w[first + 4 * lanes + j], w[first + 5 * lanes + j], w[first + 6 * lanes + j],
        w[first + 7 * lanes + j], w[first + 8 * lanes + j], w[first + 9 * lanes + j],
        w[first + 10 * lanes + j], w[first + 11 * lanes + j], w[first + 12 * lanes + j],
    )  # fmt: skip


@compiled(forceinline=True)
def guess(new: float, low: float, high: float) -> float:
    """Return a guess that is between its bounds, else their middle."""
    return new if low < new < high else 0.5 * (low + high)


@compiled(forceinline=True)
def first_between(
    lower: Terms, upper: Terms, gates: tuple[float, float], ends: tuple[float, float]
) -> tuple[float, float, float]:
    """Return what is between two devices in series without second-order effects, V, by what either carries.

    In weak inversion that is exact: `I = A B / (A + B)`, of which the end of the device that does not limit
    is made. It is the first number less the second times `argument_of_root` of the third. ends: of the lower
    source and the upper drain.
    """
    p, q = pinched(lower, gates[0])[0], pinched(upper, gates[1])[0]
    begin = even_interpolation(2.0 * lower.half * (p - ends[0]))
    end = even_interpolation(2.0 * upper.half * (q - ends[1]))
    a = lower.specific * begin
    b = upper.specific * even_interpolation(2.0 * upper.half * (q - ends[0]))
    current = a * (b - upper.specific * end) / (a + b)
    first = a < b
    square = end + current / upper.specific if first else max(begin - current / lower.specific, 0.0)
    return q if first else p, 0.5 / (upper.half if first else lower.half), math.sqrt(square)


@compiled()
def _series_moves(w: F64, active: int) -> None:
    """Newton's step of all active lanes of `series`."""
    for j in range(min(active, LANES)):
        lower, upper = terms_in(w, j, _D), terms_in(w, j, _D + TERMS * LANES)
        y, low_gate, high_gate, drain = w[Y + j], w[_A + j], w[_B + j], w[_C + j]
        below, by_lower, _, _ = even_channel(lower, y, low_gate, 0.0)
        above, _, _, by_upper = even_channel(upper, drain, high_gate, y)
        first, by_first, _ = even_leaked(lower, y, low_gate)
        second, by_second, _ = even_leaked(upper, y, high_gate)
        below += first + second
        by_lower += by_first + by_second
        moved = bounded(w, j, below - above, y - (below - above) / (by_lower - by_upper)) - y
        # of the transistor that limits, or a small current is the difference of two large ones
        w[FIRST + j] = below + by_lower * moved if by_lower < -by_upper else above + by_upper * moved
        settled(w, j, y + moved, abs(moved) < _EXACT)


@compiled()
def _first_series(w: F64) -> None:
    """Fill the parts of the first guess of `series` in all lanes, and what the upper junction takes."""
    for j in range(LANES):
        lower, upper = terms_in(w, j, _TERMS), terms_in(w, j, _TERMS + TERMS * LANES)
        low_gate, high_gate, drain = w[j], w[LANES + j], w[2 * LANES + j]
        base, factor, square_root = first_between(lower, upper, (low_gate, high_gate), (0.0, drain))
        w[3 * LANES + j], w[4 * LANES + j], w[5 * LANES + j] = base, factor, square_root
        w[6 * LANES + j] = even_leaked(upper, drain, high_gate)[0]


@compiled(_nrt=True)
def series(lower: F64, upper: F64, low_gate: F64, high_gate: F64, drain: F64, out: F64) -> None:
    """Fill `out` with what flows into the drain of the upper of two transistors in series, A."""
    rows, points, leak = (
        np.concatenate((lower, upper)),
        np.empty((START + 3, *out.shape)),
        np.empty(out.shape),
    )
    w = np.zeros((_TERMS // LANES + 2 * TERMS) * LANES)
    for begin in range(0, out.size, LANES):
        count = min(LANES, out.size - begin)
        for j in range(count):
            k, at = divmod(begin + j, out.shape[1])
            w[j], w[LANES + j], w[2 * LANES + j] = low_gate[k, at], high_gate[k, at], drain[k, at]
            for term in range(2 * TERMS):
                w[_TERMS + term * LANES + j] = rows[term, k]
        _first_series(w)
        for j in range(count):
            k, at = divmod(begin + j, out.shape[1])
            end, root_of = w[2 * LANES + j], w[5 * LANES + j]
            low, high = min(end, 0.0), max(end, 0.0)
            y = guess(w[3 * LANES + j] - w[4 * LANES + j] * argument_of_root(root_of), low, high)
            points[0, k, at], points[1, k, at], points[2, k, at] = y, low, high
            points[START, k, at], points[START + 1, k, at] = w[j], w[LANES + j]
            points[START + 2, k, at], leak[k, at] = end, w[6 * LANES + j]
    w, who, active, following = team_of(rows, points)
    while active > 0:
        _series_moves(w, active)
        active, following = exchanged(w, who, rows, points, out, active, following, FIRST)
    for k in range(out.shape[0]):
        for at in range(out.shape[1]):
            out[k, at] += leak[k, at]


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
def _diode_moves(w: F64, active: int) -> None:
    """Newton's step of all active lanes of `diode`, as in `diode_from`."""
    for j in range(min(active, LANES)):
        t, y = terms_in(w, j, _B), w[Y + j]
        carried, by_drain, by_gate, _ = even_channel(t, y, y, 0.0)
        leak, by_junction, by_induced = even_leaked(t, y, y)
        w[FIRST + j] = carried + leak
        w[SECOND + j] = by_drain + by_gate + by_junction + by_induced
        w[THIRD + j] = carried + leak - w[_A + j]
    for j in range(min(active, LANES)):
        y, carried, current = w[Y + j], w[FIRST + j], w[_A + j]
        if carried > 0.0 and current > 0.0:
            new = y - math.log(carried / current) * carried / w[SECOND + j]
        else:
            new = y - w[THIRD + j] / w[SECOND + j]
        new = bounded(w, j, w[THIRD + j], new)
        settled(w, j, new, abs(new - y) < _EXACT)


@compiled(_nrt=True)
def diode(rows: F64, current: F64, highest: float, out: F64) -> None:
    """Fill `out` with `diode_voltage` of each network, V."""
    points = np.empty((START + 1, *out.shape))
    for k in range(out.shape[0]):
        for j in range(out.shape[1]):
            points[0, k, j], points[1, k, j], points[2, k, j] = 0.5 * highest, 0.0, highest
            points[START, k, j] = current[k, j]
    w, who, active, following = team_of(rows, points)
    while active > 0:
        _diode_moves(w, active)
        active, following = exchanged(w, who, rows, points, out, active, following, Y)


@compiled()
def _amplifier_moves(w: F64, active: int, supply: float) -> None:
    """Newton's step of all active lanes of `amplifier`."""
    for j in range(min(active, LANES)):
        n, p = terms_in(w, j, _C), terms_in(w, j, _C + TERMS * LANES)
        y, gate, bias = w[Y + j], w[_A + j], w[_B + j]
        up, by_up, _, _ = even_channel(p, y, bias, 0.0)
        down, by_down, _, _ = even_channel(n, supply - y, gate, 0.0)
        held, by_held, _ = even_leaked(p, y, bias)
        lost, by_lost, _ = even_leaked(n, supply - y, gate)
        f = up + held - down - lost
        moved = bounded(w, j, f, y - f / (by_up + by_held + by_down + by_lost)) - y
        settled(w, j, y + moved, abs(moved) < _EXACT)


@compiled(_nrt=True)
def amplifier(pull: F64, hold: F64, gate: F64, bias: F64, supply: float, out: F64) -> None:
    """Fill `out` with how far an amplifier's output is below the supply, V.

    The nFET `pull` with its gate pulls it down, the pFET `hold` with its bias holds it up.
    """
    rows, points = np.concatenate((pull, hold)), np.empty((START + 2, *out.shape))
    for k in range(out.shape[0]):
        for j in range(out.shape[1]):
            points[0, k, j], points[1, k, j], points[2, k, j] = 0.0, 0.0, supply
            points[START, k, j], points[START + 1, k, j] = gate[k, j], bias[k, j]
    w, who, active, following = team_of(rows, points)
    while active > 0:
        _amplifier_moves(w, active, supply)
        active, following = exchanged(w, who, rows, points, out, active, following, Y)


@compiled()
def _pair_moves(w: F64, active: int) -> None:
    """Newton's step of all active lanes of `pair`."""
    for j in range(min(active, LANES)):
        first, second, y = terms_in(w, j, _E + LANES), terms_in(w, j, _E + (1 + TERMS) * LANES), w[Y + j]
        a, _, _, by_a = even_channel(first, w[_C + j], w[_A + j], y)
        b, _, _, by_b = even_channel(second, w[_D + j], w[_B + j], y)
        w[FIRST + j], w[SECOND + j] = a + b, by_a + by_b
    for j in range(min(active, LANES)):
        carried = w[FIRST + j]
        step = math.log(carried / w[_E + j]) * carried / -w[SECOND + j] if carried > 0.0 else -_WIDEST
        step = min(max(step, -_WIDEST), _WIDEST)
        settled(w, j, w[Y + j] + step, abs(step) < _EXACT)


@compiled(_nrt=True)
def pair(
    first: F64, second: F64, gates: tuple[F64, F64], drains: tuple[F64, F64], total: F64, out: F64
) -> None:
    """Fill `out` with the common source (V) of two transistors that carry `total` (A) together."""
    rows, points = np.concatenate((first, second)), np.empty((START + 5, *out.shape))
    for k in range(out.shape[0]):
        for j in range(out.shape[1]):
            points[0, k, j], points[1, k, j], points[2, k, j] = np.nan, 0.0, 0.0
            points[START, k, j], points[START + 1, k, j] = gates[0][k, j], gates[1][k, j]
            points[START + 2, k, j], points[START + 3, k, j] = drains[0][k, j], drains[1][k, j]
            points[START + 4, k, j] = total[k, j]
        a, b = terms_at(first, k), terms_at(second, k)
        points[0, k, 0] = max(pinched(a, gates[0][k, 0])[0], pinched(b, gates[1][k, 0])[0])
    w, who, active, following = team_of(rows, points)
    while active > 0:
        _pair_moves(w, active)
        active, following = exchanged(w, who, rows, points, out, active, following, Y)


@compiled()
def _fed_moves(w: F64, active: int, supply: float, foot: float) -> None:
    """Newton's step of all active lanes of `fed_diode`."""
    for j in range(min(active, LANES)):
        n, p, y = terms_in(w, j, _C), terms_in(w, j, _C + TERMS * LANES), w[Y + j]
        held, by_drain, by_gate, _ = even_channel(p, y, y, foot)
        leak, by_junction, by_induced = even_leaked(p, y, y)
        drawn, by_drawn, _, _ = even_channel(n, supply - y, w[_A + j], w[_B + j])
        lost, by_lost, _ = even_leaked(n, supply - y, w[_A + j])
        w[FIRST + j], w[SECOND + j] = held + leak, drawn + lost
        by_held, by_drawn = by_drain + by_gate + by_junction + by_induced, by_drawn + by_lost
        w[THIRD + j] = by_held / (held + leak) + by_drawn / (drawn + lost)
        w[FOURTH + j] = by_held + by_drawn
    for j in range(min(active, LANES)):
        held, drawn, y = w[FIRST + j], w[SECOND + j], w[Y + j]
        # on the logarithm of the ratio, which is nearly a line
        if held > 0.0 and drawn > 0.0:
            new = y - math.log(held / drawn) / w[THIRD + j]
        else:
            new = y - (held - drawn) / w[FOURTH + j]
        new = bounded(w, j, held - drawn, new)
        settled(w, j, new, abs(new - y) < _EXACT)


@compiled(_nrt=True)
def fed_diode(
    drawing: F64, mirror: F64, gate: F64, source: F64, supply: float, out: F64, foot: float
) -> None:
    """Fill `out` with the gate of a diode-connected pFET that an nFET draws its current from, V.

    gate, source: of the nFET, V; its drain is at the diode; foot: source of the diode, V below the supply.
    """
    rows, points = np.concatenate((drawing, mirror)), np.empty((START + 2, *out.shape))
    for k in range(out.shape[0]):
        for j in range(out.shape[1]):
            points[0, k, j], points[1, k, j], points[2, k, j] = np.nan, 0.0, supply
            points[START, k, j], points[START + 1, k, j] = gate[k, j], source[k, j]
        points[0, k, 0] = foot + 0.3 * (supply - foot)
    w, who, active, following = team_of(rows, points)
    while active > 0:
        _fed_moves(w, active, supply, foot)
        active, following = exchanged(w, who, rows, points, out, active, following, Y)
