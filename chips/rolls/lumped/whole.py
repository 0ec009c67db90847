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
_CLOSE = 1e-9  # V, that of one which others depend on
_SETTLED = 1e-6  # V, of a diode's gate, 3e-5 of its current; ours
_NUDGE = 1e-3  # V, of a numerical slope
_WIDEST = 0.1  # V, ours: of a step of a pair's common source
_LEAST = 1e-18  # A, ours: below every current of a diode
_TOGETHER = 30  # steps of all nodes of a network together, after which each is sought by itself
_ROUNDS = 12  # of a mirror and what feeds it, each of which leaves less than a tenth of the error; ours

_Summed = tuple[Terms, Terms, Terms, Terms, Terms, Terms, Terms]


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
def _guess(new: float, low: float, high: float) -> float:
    """A guess that is between its bounds, else their middle."""
    return new if low < new < high else 0.5 * (low + high)


@compiled(forceinline=True)
def _first_between(
    lower: Terms, upper: Terms, gates: tuple[float, float], ends: tuple[float, float]
) -> float:
    """Voltage between two devices in series without second-order effects, V, by what either carries alone.

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
    y = _guess(_first_between(lower, upper, (low_gate, high_gate), (0.0, drain)), low, high)
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
        moved = _guess(y - f / (by_lower - by_upper), low, high) - y
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
        new = _guess(new, low, high)
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
                moved = _guess(y - f / (by_up + by_held + by_down + by_lost), low, high) - y
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
        new = _guess(new, low, high)
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


@compiled(forceinline=True)
def _sum(rows: F64, gate: F64, k: int, drain: float, source: float) -> tuple[float, float, float]:
    """Sum of three currents, A, and its derivatives by their drains and their sources, S."""
    total = by_drain = by_source = 0.0
    for j in range(3):
        carried, d, _, s = channel(terms_at(rows[j], k), drain, gate[j, k], source)
        total += carried
        by_drain += d
        by_source += s
    return total, by_drain, by_source


@compiled(forceinline=True)
def _between(
    lower: Terms, upper: Terms, gates: tuple[float, float], ends: tuple[float, float], y: float
) -> float:
    """Voltage between two devices in series, from `y` on; ends: of the lower source and the upper drain."""
    low, high = ends[0], max(ends[0], ends[1])
    y = _guess(y, low, high)
    for _ in range(_ITERATIONS):
        below, by_below, _, _ = channel(lower, y, gates[0], ends[0])
        above, _, _, by_above = channel(upper, ends[1], gates[1], y)
        f = below - above
        if f > 0.0:
            high = y
        else:
            low = y
        step = -f / (by_below - by_above)
        new = _guess(y + step, low, high)
        if abs(new - y) < _CLOSE:
            return new
        y = new
    return y


@compiled(forceinline=True)
def _branch(
    lower: Terms, upper: Terms, gates: tuple[float, float], ends: tuple[float, float], y: float
) -> tuple[float, float, float]:
    """Current of two devices in series, A, its derivative by the lower source, S, and what is between them.

    ends, y: as in `_between`.
    """
    y = _between(lower, upper, gates, ends, y)
    below, by_below, _, by_source = channel(lower, y, gates[0], ends[0])
    above, _, _, by_above = channel(upper, ends[1], gates[1], y)
    # of the transistor that limits, as in `series_current`
    current = below if by_below < -by_above else above
    return current, by_source * by_above / (by_above - by_below), y


@compiled(forceinline=True)
def _nearer(
    lower: Terms, upper: Terms, gates: tuple[float, float], ends: tuple[float, float], e: float
) -> tuple[float, float, float, float]:
    """One step of Newton's method for two devices in series, with `e` V between them.

    Returns their current, A, its derivative by the lower source, S, the step of `e`, V, and its derivative by
    the lower source; ends: as in `_between`.
    """
    below, by_below, _, by_source = channel(lower, e, gates[0], ends[0])
    above, _, _, by_above = channel(upper, ends[1], gates[1], e)
    both = by_below - by_above
    current = (above * by_below - below * by_above) / both
    return current, -by_source * by_above / both, (above - below) / both, -by_source / both


@compiled(forceinline=True)
def _widest(x: float) -> float:
    """A step within its bounds, V."""
    return min(max(x, -_WIDEST), _WIDEST)


@compiled(forceinline=True)
def _placed(rows: tuple[F64, F64, F64], k: int) -> _Summed:
    """The devices of `mirrored_sum` at place k: the switch, the five of the lines, and the mirror."""
    top, lines, mirror = rows
    return (
        terms_at(top, k), terms_at(lines[0], k), terms_at(lines[1], k), terms_at(lines[2], k),
        terms_at(lines[3], k), terms_at(lines[4], k), terms_at(mirror, k),
    )  # fmt: skip


@compiled()
def _mirrored(c: _Summed, gates: F64, k: int, at: tuple[float, float]) -> tuple[float, float, float, float]:
    """What `mirrored_sum` fills, all nodes stepped together, and the last step, V."""
    (top, first, second, behind, third, last, mirror), (switch, supply) = c, at
    gate, total, left = 0.3 * supply, 0.0, supply
    drain = supply - gate
    y = _guess(_first_between(top, first, (switch, gates[0, k]), (0.0, drain)), 0.0, supply)
    e0 = _guess(_first_between(second, behind, (gates[1, k], gates[2, k]), (y, drain)), 0.0, supply)
    e1 = _guess(_first_between(third, last, (gates[3, k], gates[4, k]), (y, drain)), 0.0, supply)
    for _ in range(_TOGETHER):
        drain = supply - gate
        given, by_given, _, _ = channel(top, y, switch, 0.0)
        a, _, _, by_a = channel(first, drain, gates[0, k], y)
        b, by_b, move0, with0 = _nearer(second, behind, (gates[1, k], gates[2, k]), (y, drain), e0)
        d, by_d, move1, with1 = _nearer(third, last, (gates[3, k], gates[4, k]), (y, drain), e1)
        total, by_total = a + b + d, by_a + by_b + by_d
        if given > 0.0 and total > 0.0:
            # on the logarithm, as either side is a power or an exponential
            up = -math.log(given / total) / (by_given / given - by_total / total)
        else:
            up = (total - given) / (by_given - by_total)
        up = max(_widest(up), -0.9 * y)
        total += by_total * up
        held, by_drain, by_gate, _ = channel(mirror, gate, gate, 0.0)
        leak, by_junction, by_induced = leaked(mirror, gate, gate)
        held += leak
        by_held = by_drain + by_gate + by_junction + by_induced
        more = math.log(max(total, _LEAST) / held) * held / by_held
        more = max(min(more, 3.0 * _WIDEST), -3.0 * _WIDEST, -0.9 * gate)
        move0, move1 = _widest(move0 + with0 * up), _widest(move1 + with1 * up)
        y, e0, e1, gate = y + up, e0 + move0, e1 + move1, gate + more
        left = abs(up) + abs(move0) + abs(move1) + abs(more)
        if not left >= _CLOSE:
            break
    return total, gate, y, left


@compiled()
def _mirrored_surely(c: _Summed, gates: F64, k: int, at: tuple[float, float]) -> tuple[float, float, float]:
    """What `mirrored_sum` fills, each node between its bounds inside the next one's loop."""
    (t, first, second, behind, third, last, n), (switch, supply) = c, at
    gate, y, total = 0.3 * supply, 0.0, 0.0
    # between each device and its switch: at the switch's pinch-off, or at the diode
    e0 = min(max(pinched(behind, gates[2, k])[0], 0.0), supply - gate)
    e1 = min(max(pinched(last, gates[4, k])[0], 0.0), supply - gate)
    for _ in range(_ROUNDS):
        low, high, drain = 0.0, supply, supply - gate
        for _ in range(_ITERATIONS):
            given, by_given, _, _ = channel(t, y, switch, 0.0)
            a, _, _, by_a = channel(first, drain, gates[0, k], y)
            b, by_b, e0 = _branch(second, behind, (gates[1, k], gates[2, k]), (y, drain), e0)
            d, by_d, e1 = _branch(third, last, (gates[3, k], gates[4, k]), (y, drain), e1)
            total = a + b + d
            f = given - total
            if f > 0.0:
                high = y
            else:
                low = y
            new = y - f / (by_given - by_a - by_b - by_d)
            new = new if low <= new <= high else 0.5 * (low + high)
            if abs(new - y) < _CLOSE:
                break
            y = new
        new = diode_from(n, total, supply, gate)
        if abs(new - gate) < _SETTLED:
            break
        gate = new
    return total, gate, y


@compiled()
def mirrored_sum(top: F64, lines: F64, gates: F64, mirror: F64, at: tuple[float, float], out: F64) -> None:
    """Fill `out` with the sum of three currents whose common source hangs on a switch, and their diode.

    top: the switch, a pFET whose source is at the supply, its gate `at[0]` V below it; lines: the first
    device, and of the others each device before its own switch, float64[5, TERMS, n]; gates: below the
    supply, V, float64[5, n]; mirror: the nFET that they feed; at[1]: the supply, V; out: float64[3, n], the
    current, A, the voltage across the diode, and that of the common source below the supply, V.
    """
    for k in range(out.shape[1]):
        devices = _placed((top, lines, mirror), k)
        total, gate, y, left = _mirrored(devices, gates, k, at)
        if not left < _CLOSE:
            total, gate, y = _mirrored_surely(devices, gates, k, at)
        out[0, k], out[1, k], out[2, k] = total, gate, y


@compiled()
def sunk_sum(top: F64, lines: F64, gates: F64, switch: float, grid: F64, out: F64) -> None:
    """Fill `out` with the current that three nFETs at ground draw through a switch from a line, A.

    top: the switch, its gate at `switch` V; lines, gates: as in `mirrored_sum`, above ground; grid: voltages
    of the line, V; out: float64[n, grid].
    """
    for k in range(out.shape[0]):
        t = terms_at(top, k)
        for g in range(grid.size):
            low, high, y = 0.0, grid[g], grid[g]
            total = 0.0
            for _ in range(_ITERATIONS):
                given, _, _, by_given = channel(t, grid[g], switch, y)
                total, by_total, _ = _sum(lines, gates, k, y, 0.0)
                f = total - given
                if f > 0.0:
                    high = y
                else:
                    low = y
                new = y - f / (by_total - by_given)
                new = new if low <= new <= high else 0.5 * (low + high)
                total += by_total * (new - y)
                if abs(new - y) < _EXACT:
                    break
                y = new
            out[k, g] = total
