"""Nodes of `chips.rolls.lumped.whole_sum.mirrored_sum` stepped together, of synapses side by side in lanes.

A number of all lanes is a row of `LANES` numbers of an array, a row after the other, float64[ROOM]; a lane
whose nodes have settled stays as it is. What is packed has no branch and no logarithm: those stand between.
"""

from __future__ import annotations

import math

from chips.rolls.lumped.whole import TERMS, first_between, guess, terms_in
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import Terms, field_at, pinched
from circuits.devices.ekv import argument_of_root
from circuits.devices.packable import even_channel, even_channel_in, even_leaked

LANES = 32
CLOSE = 1e-9  # V, last step of a network whose nodes have settled
TOGETHER = 30  # steps of all nodes of a network together, after which each is sought by itself
_WIDEST = 0.1  # V, ours: of a step of a node
_LEAST = 1e-18  # A, ours: below every current of a diode

SOURCE, FIRST_MIDDLE, LAST_MIDDLE, GATE, TOTAL, LEFT = (
    LANES * k for k in range(6)
)  # nodes, V; current; step
_GOES, _GIVEN, _BY_GIVEN, _BY_TOTAL, _MOVE0, _WITH0, _MOVE1, _WITH1, _HELD, _BY_HELD = (
    LANES * k for k in range(6, 16)
)
_GATES = 16 * LANES  # of the lines, V
_HELD_ROWS = (
    5  # what holds of a device while its gate stays: pinch-off voltage and its slope, M and its parts
)
_STAYS = _GATES + 5 * LANES  # of the switch and the five of the lines
_TERMS = _STAYS + 6 * _HELD_ROWS * LANES  # of the switch, the five of the lines, and the mirror
ROOM = _TERMS + 7 * TERMS * LANES
_TOP, _FIRST, _SECOND, _BEHIND, _THIRD, _LAST, _MIRROR = (_TERMS + k * TERMS * LANES for k in range(7))


@compiled()
def take(rows: tuple[F64, F64, F64], gates: F64, first: int, count: int, w: F64) -> None:
    """Put the devices of so many synapses from `first` on into the lanes; rows: switch, lines and mirror."""
    top, lines, mirror = rows
    for term in range(TERMS):
        for j in range(count):
            w[_TOP + term * LANES + j] = top[term, first + j]
            w[_MIRROR + term * LANES + j] = mirror[term, first + j]
        for line in range(5):
            for j in range(count):
                w[_FIRST + (line * TERMS + term) * LANES + j] = lines[line, term, first + j]
    for line in range(5):
        for j in range(count):
            w[_GATES + line * LANES + j] = gates[line, first + j]
    for j in range(LANES):
        w[_GOES + j], w[TOTAL + j] = 1.0 if j < count else 0.0, 0.0


@compiled(forceinline=True)
def _terms(w: F64, j: int, first: int) -> Terms:
    return terms_in(w, j, first, LANES)


@compiled(forceinline=True)
def _held(w: F64, j: int, device: int, gate: float) -> None:
    """Put what holds of a device while its gate stays, V."""
    at, t = _STAYS + device * _HELD_ROWS * LANES + j, _terms(w, j, _TERMS + device * TERMS * LANES)
    v_p, kappa = pinched(t, gate)
    w[at], w[at + LANES] = v_p, kappa
    w[at + 2 * LANES], w[at + 3 * LANES], w[at + 4 * LANES] = field_at(t, v_p)


@compiled(forceinline=True)
def _carried(w: F64, j: int, device: int, drain: float, source: float) -> tuple[float, float, float]:
    """Current of a device whose gate stays, A, and its derivatives by drain and source, S."""
    at, t = _STAYS + device * _HELD_ROWS * LANES + j, _terms(w, j, _TERMS + device * TERMS * LANES)
    field = w[at + 2 * LANES], w[at + 3 * LANES], w[at + 4 * LANES]
    current, by_drain, _, by_source = even_channel_in(t, (drain, source), (w[at], w[at + LANES]), field)
    return current, by_drain, by_source


@compiled()
def _hold(w: F64, switch: float) -> None:
    """Put what holds of all devices whose gates stay."""
    for j in range(LANES):
        _held(w, j, 0, switch)
        _held(w, j, 1, w[_GATES + j])
    for j in range(LANES):
        _held(w, j, 2, w[_GATES + LANES + j])
        _held(w, j, 3, w[_GATES + 2 * LANES + j])
    for j in range(LANES):
        _held(w, j, 4, w[_GATES + 3 * LANES + j])
        _held(w, j, 5, w[_GATES + 4 * LANES + j])


@compiled()
def begin(w: F64, switch: float, supply: float) -> None:
    """Put the nodes where either device of each pair would have them without second-order effects."""
    _hold(w, switch)
    gate, drain = 0.3 * supply, supply - 0.3 * supply
    for j in range(LANES):
        found = first_between(_terms(w, j, _TOP), _terms(w, j, _FIRST), (switch, w[_GATES + j]), (0.0, drain))
        w[_GIVEN + j], w[_MOVE0 + j], w[_WITH0 + j] = found
    for j in range(LANES):
        between = w[_GIVEN + j] - w[_MOVE0 + j] * argument_of_root(w[_WITH0 + j])
        w[SOURCE + j], w[GATE + j], w[LEFT + j] = guess(between, 0.0, supply), gate, supply
    for j in range(LANES):
        y = w[SOURCE + j]
        gates = w[_GATES + LANES + j], w[_GATES + 2 * LANES + j]
        found = first_between(_terms(w, j, _SECOND), _terms(w, j, _BEHIND), gates, (y, drain))
        w[_GIVEN + j], w[_MOVE0 + j], w[_WITH0 + j] = found
        gates = w[_GATES + 3 * LANES + j], w[_GATES + 4 * LANES + j]
        found = first_between(_terms(w, j, _THIRD), _terms(w, j, _LAST), gates, (y, drain))
        w[_BY_GIVEN + j], w[_MOVE1 + j], w[_WITH1 + j] = found
    for j in range(LANES):
        between = w[_GIVEN + j] - w[_MOVE0 + j] * argument_of_root(w[_WITH0 + j])
        w[FIRST_MIDDLE + j] = guess(between, 0.0, supply)
        between = w[_BY_GIVEN + j] - w[_MOVE1 + j] * argument_of_root(w[_WITH1 + j])
        w[LAST_MIDDLE + j] = guess(between, 0.0, supply)


@compiled(forceinline=True)
def _nearer(
    w: F64, j: int, device: int, ends: tuple[float, float], e: float
) -> tuple[float, float, float, float]:
    """One step of Newton's method for two devices in series, `device` and the next, with `e` V between them.

    Returns their current, A, its derivative by the lower source, S, the step of `e`, V, and its derivative by
    the lower source; ends: of the lower source and the upper drain, V.
    """
    below, by_below, by_source = _carried(w, j, device, e, ends[0])
    above, _, by_above = _carried(w, j, device + 1, ends[1], e)
    both = by_below - by_above
    current = (above * by_below - below * by_above) / both
    return current, -by_source * by_above / both, (above - below) / both, -by_source / both


@compiled()
def _balance(w: F64, supply: float) -> None:
    """Fill the currents of all lanes, and how they change."""
    for j in range(LANES):
        y = w[SOURCE + j]
        given, by_given, _ = _carried(w, j, 0, y, 0.0)
        a, _, by_a = _carried(w, j, 1, supply - w[GATE + j], y)
        w[_GIVEN + j], w[_BY_GIVEN + j], w[_HELD + j], w[_BY_HELD + j] = given, by_given, a, by_a
    for j in range(LANES):
        ends = w[SOURCE + j], supply - w[GATE + j]
        b, by_b, move, along = _nearer(w, j, 2, ends, w[FIRST_MIDDLE + j])
        w[_MOVE0 + j], w[_WITH0 + j] = move, along
        w[_HELD + j], w[_BY_HELD + j] = w[_HELD + j] + b, w[_BY_HELD + j] + by_b
    for j in range(LANES):
        ends = w[SOURCE + j], supply - w[GATE + j]
        d, by_d, move, along = _nearer(w, j, 4, ends, w[LAST_MIDDLE + j])
        w[_MOVE1 + j], w[_WITH1 + j] = move, along
        w[TOTAL + j] = w[_HELD + j] + d if w[_GOES + j] > 0.0 else w[TOTAL + j]
        w[_BY_TOTAL + j] = w[_BY_HELD + j] + by_d
    for j in range(LANES):
        t, gate = _terms(w, j, _MIRROR), w[GATE + j]
        held, by_drain, by_gate, _ = even_channel(t, gate, gate, 0.0)
        leak, by_junction, by_induced = even_leaked(t, gate, gate)
        w[_HELD + j], w[_BY_HELD + j] = held + leak, by_drain + by_gate + by_junction + by_induced


@compiled(forceinline=True)
def _widest(x: float) -> float:
    """A step within its bounds, V."""
    return min(max(x, -_WIDEST), _WIDEST)


@compiled()
def step_together(w: F64, supply: float) -> int:
    """Step all nodes of the lanes that go on; how many do so still."""
    _balance(w, supply)
    going = 0
    for j in range(LANES):
        if not w[_GOES + j] > 0.0:
            continue
        given, by_given, total, by_total = w[_GIVEN + j], w[_BY_GIVEN + j], w[TOTAL + j], w[_BY_TOTAL + j]
        y, gate = w[SOURCE + j], w[GATE + j]
        if given > 0.0 and total > 0.0:
            # on the logarithm, as either side is a power or an exponential
            up = -math.log(given / total) / (by_given / given - by_total / total)
        else:
            up = (total - given) / (by_given - by_total)
        up = max(_widest(up), -0.9 * y)
        total += by_total * up
        held, by_held = w[_HELD + j], w[_BY_HELD + j]
        more = math.log(max(total, _LEAST) / held) * held / by_held
        more = max(min(more, 3.0 * _WIDEST), -3.0 * _WIDEST, -0.9 * gate)
        move0, move1 = (
            _widest(w[_MOVE0 + j] + w[_WITH0 + j] * up),
            _widest(w[_MOVE1 + j] + w[_WITH1 + j] * up),
        )
        w[SOURCE + j], w[GATE + j], w[TOTAL + j] = y + up, gate + more, total
        w[FIRST_MIDDLE + j], w[LAST_MIDDLE + j] = w[FIRST_MIDDLE + j] + move0, w[LAST_MIDDLE + j] + move1
        w[LEFT + j] = abs(up) + abs(move0) + abs(move1) + abs(more)
        w[_GOES + j] = 1.0 if w[LEFT + j] >= CLOSE else 0.0
        going += 1 if w[LEFT + j] >= CLOSE else 0
    return going
