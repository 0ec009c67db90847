"""Nodes of `chips.rolls.lumped.whole_sum.mirrored_sum` stepped together, of synapses side by side in lanes.

A number of all lanes is a row of `LANES` numbers of an array, a row after the other, float64[ROOM]; a lane
whose nodes have settled stays as it is. What is packed has no branch and no logarithm: those stand between.
"""

from __future__ import annotations

import math

from chips.rolls.lumped.whole import TERMS, first_between, guess, terms_in
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import Terms
from circuits.devices.ekv import argument_of_root
from circuits.devices.packable import even_channel, even_leaked

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
_TERMS = _GATES + 5 * LANES  # of the switch, the five of the lines, and the mirror
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


@compiled()
def begin(w: F64, switch: float, supply: float) -> None:
    """Put the nodes where either device of each pair would have them without second-order effects."""
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
    lower: Terms, upper: Terms, gates: tuple[float, float], ends: tuple[float, float], e: float
) -> tuple[float, float, float, float]:
    """One step of Newton's method for two devices in series, with `e` V between them.

    Returns their current, A, its derivative by the lower source, S, the step of `e`, V, and its derivative by
    the lower source; gates: V; ends: of the lower source and the upper drain.
    """
    below, by_below, _, by_source = even_channel(lower, e, gates[0], ends[0])
    above, _, _, by_above = even_channel(upper, ends[1], gates[1], e)
    both = by_below - by_above
    current = (above * by_below - below * by_above) / both
    return current, -by_source * by_above / both, (above - below) / both, -by_source / both


@compiled()
def _balance(w: F64, switch: float, supply: float) -> None:
    """Fill the currents of all lanes, and how they change."""
    for j in range(LANES):
        y, drain = w[SOURCE + j], supply - w[GATE + j]
        given, by_given, _, _ = even_channel(_terms(w, j, _TOP), y, switch, 0.0)
        a, _, _, by_a = even_channel(_terms(w, j, _FIRST), drain, w[_GATES + j], y)
        w[_GIVEN + j], w[_BY_GIVEN + j], w[_HELD + j], w[_BY_HELD + j] = given, by_given, a, by_a
    for j in range(LANES):
        ends = w[SOURCE + j], supply - w[GATE + j]
        gates = w[_GATES + LANES + j], w[_GATES + 2 * LANES + j]
        b, by_b, move, along = _nearer(
            _terms(w, j, _SECOND), _terms(w, j, _BEHIND), gates, ends, w[FIRST_MIDDLE + j]
        )
        w[_MOVE0 + j], w[_WITH0 + j] = move, along
        w[_HELD + j], w[_BY_HELD + j] = w[_HELD + j] + b, w[_BY_HELD + j] + by_b
    for j in range(LANES):
        ends = w[SOURCE + j], supply - w[GATE + j]
        gates = w[_GATES + 3 * LANES + j], w[_GATES + 4 * LANES + j]
        d, by_d, move, along = _nearer(
            _terms(w, j, _THIRD), _terms(w, j, _LAST), gates, ends, w[LAST_MIDDLE + j]
        )
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
def step_together(w: F64, switch: float, supply: float) -> int:
    """Step all nodes of the lanes that go on; how many do so still."""
    _balance(w, switch, supply)
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
