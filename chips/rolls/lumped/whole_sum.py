"""Sums of a synapse's currents under the law with second-order effects (`chips.rolls.lumped.whole`).

Three currents meet at a node that hangs on a switch. Two of them come through switches of their own, so that
up to four nodes are sought together; where that does not settle, each is sought between its bounds inside the
loop of the next one.
"""

from __future__ import annotations

import numpy as np

from chips.rolls.lumped.whole import diode_from, guess, terms_at
from chips.rolls.lumped.whole_sum_lanes import (
    CLOSE,
    GATE,
    LANES,
    LEFT,
    ROOM,
    SOURCE,
    TOGETHER,
    TOTAL,
    begin,
    step_together,
    take,
)
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import Terms, channel, pinched

_ITERATIONS = 80
_EXACT = 1e-9  # V, last update of a voltage by Newton's method, which leaves its square over U_T
_SETTLED = 1e-6  # V, of a diode's gate, 3e-5 of its current; ours
_ROUNDS = 12  # of a mirror and what feeds it, each of which leaves less than a tenth of the error; ours

_Summed = tuple[Terms, Terms, Terms, Terms, Terms, Terms, Terms]


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
    y = guess(y, low, high)
    for _ in range(_ITERATIONS):
        below, by_below, _, _ = channel(lower, y, gates[0], ends[0])
        above, _, _, by_above = channel(upper, ends[1], gates[1], y)
        f = below - above
        if f > 0.0:
            high = y
        else:
            low = y
        step = -f / (by_below - by_above)
        new = guess(y + step, low, high)
        if abs(new - y) < CLOSE:
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
    # of the transistor that limits, as in `series`
    current = below if by_below < -by_above else above
    return current, by_source * by_above / (by_above - by_below), y


@compiled(forceinline=True)
def _placed(rows: tuple[F64, F64, F64], k: int) -> _Summed:
    """The devices of `mirrored_sum` at place k: the switch, the five of the lines, and the mirror."""
    top, lines, mirror = rows
    return (
        terms_at(top, k), terms_at(lines[0], k), terms_at(lines[1], k), terms_at(lines[2], k),
        terms_at(lines[3], k), terms_at(lines[4], k), terms_at(mirror, k),
    )  # fmt: skip


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
            if abs(new - y) < CLOSE:
                break
            y = new
        new = diode_from(n, total, supply, gate)
        if abs(new - gate) < _SETTLED:
            break
        gate = new
    return total, gate, y


@compiled(_nrt=True)
def mirrored_sum(top: F64, lines: F64, gates: F64, mirror: F64, at: tuple[float, float], out: F64) -> None:
    """Fill `out` with the sum of three currents whose common source hangs on a switch, and their diode.

    top: the switch, a pFET whose source is at the supply, its gate `at[0]` V below it; lines: the first
    device, and of the others each device before its own switch, float64[5, TERMS, n]; gates: below the
    supply, V, float64[5, n]; mirror: the nFET that they feed; at[1]: the supply, V; out: float64[3, n], the
    current, A, the voltage across the diode, and that of the common source below the supply, V.
    """
    w, rows, count = np.zeros(ROOM), (top, lines, mirror), out.shape[1]
    for first in range(0, count, LANES):
        few = min(LANES, count - first)
        take(rows, gates, first, few, w)
        begin(w, at[0], at[1])
        going, steps = few, 0
        while going > 0 and steps < TOGETHER:
            going = step_together(w, at[1])
            steps += 1
        for j in range(few):
            k, total, gate, y = first + j, w[TOTAL + j], w[GATE + j], w[SOURCE + j]
            if not w[LEFT + j] < CLOSE:
                total, gate, y = _mirrored_surely(_placed(rows, k), gates, k, at)
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
