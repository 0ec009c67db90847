"""The input at which a comparator turns, under the law with all its effects.

A pair of nFETs shares a tail; one has its gate at a voltage that is known, and the other's is sought. Above
them is a mirror of pFETs, whose diode is on either side; the node of its copy is the comparator's output, and
is where what follows turns. In balance

    I_mirror(gate, drain) + J_p = I_pair + J_n  at either node,   I_known + I_other = I_tail(v_tail) + J_tail

with J of the junctions. The tail is found by steps of `U_T ln` of the ratio of both sides of the last one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.whole import terms_at
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import Terms, channel, leaked

TAIL, KNOWN, OTHER, KNOWN_MIRROR, OTHER_MIRROR = range(5)  # rows of devices
_ITERATIONS = 60
_EXACT = 1e-9  # V
_WIDEST = 0.1  # V, ours: of a step of a gate


class Comparator(NamedTuple):
    """Comparators at n places.

    rows: of TAIL to OTHER_MIRROR, float64[5, TERMS, n]; gates: of the tail and of the known side, V,
    float64[2, n]; output: V, float64[n]; diode: 1.0 for the side whose mirror's device is the diode, else
    0.0, of the known and of the other side; supply, u_t: V.
    """

    rows: F64
    gates: F64
    output: F64
    diode: tuple[float, float]
    supply: float
    u_t: float


@compiled(forceinline=True)
def _into(t: Terms, gate: float, drain: float, source: float) -> tuple[float, float]:
    """Current of a channel, and that of the junction at its drain, A; V above the bulk (below, pFET)."""
    return channel(t, drain, gate, source)[0], leaked(t, drain, gate)[0]


@compiled(forceinline=True)
def _nearer(y: float, current: float, carried: float, slope: float) -> tuple[float, float]:
    """The step (V) from a gate at `y` V, which brings `carried`, to one that brings `current` (A); its end.

    It is of the currents' logarithm, which is nearly a line; slope: of the carried one, A/V.
    """
    step = math.log(max(current, 1e-30) / max(carried, 1e-30)) * carried / slope
    return step, y + min(max(step, -_WIDEST), _WIDEST)


@compiled()
def _mirror_gate(t: Terms, current: float, diode: float, far: float, y: float) -> float:
    """Gate of a mirror's device that brings `current` (A), V below the supply, from `y` V on.

    diode: 1.0 where its drain is at its gate; far: where it is else, V below the supply.
    """
    for _ in range(_ITERATIONS):
        drain = y if diode > 0.0 else far
        carried, by_drain, by_gate, _ = channel(t, drain, y, 0.0)
        carried += leaked(t, drain, y)[0]
        slope = by_gate + diode * by_drain
        step, y = _nearer(y, current, carried, slope)
        if abs(step) < _EXACT:
            break
    return y


@compiled()
def _pair_gate(t: Terms, current: float, drain: float, source: float, y: float) -> float:
    """Gate at which a device of the pair carries `current` (A), V, from `y` V on."""
    for _ in range(_ITERATIONS):
        carried, _, by_gate, _ = channel(t, drain, y, source)
        step, y = _nearer(y, current, carried, by_gate)
        if abs(step) < _EXACT:
            break
    return y


@compiled()
def turns_at(c: Comparator, out: F64) -> None:
    """Fill `out` with the gate of the other side in balance, V, float64[n]."""
    for k in range(out.size):
        tail, known, other = (
            terms_at(c.rows[TAIL], k), terms_at(c.rows[KNOWN], k), terms_at(c.rows[OTHER], k),
        )  # fmt: skip
        above, beside = terms_at(c.rows[KNOWN_MIRROR], k), terms_at(c.rows[OTHER_MIRROR], k)
        reference, far = c.gates[1, k], c.supply - c.output[k]
        low, high, y = 0.0, reference, 0.5 * reference
        b, rest, drain = 0.25 * c.supply, 0.0, far
        for _ in range(_ITERATIONS):
            at = b if c.diode[0] > 0.0 else far
            held, lost = _into(known, reference, c.supply - at, y)
            b = _mirror_gate(above, held + lost, c.diode[0], far, b)
            drain = b if c.diode[1] > 0.0 else far
            given, brought = _into(beside, b, drain, 0.0)
            rest = given + brought - leaked(other, c.supply - drain, reference)[0]
            taken, sunk = _into(tail, c.gates[0, k], y, 0.0)
            step = c.u_t * math.log(max(held + rest, 1e-30) / max(taken + sunk, 1e-30))
            if step > 0.0:
                low = y
            else:
                high = y
            if abs(step) < _EXACT:
                break
            y = y + step if low < y + step < high else 0.5 * (low + high)
        out[k] = _pair_gate(other, rest, c.supply - drain, y, reference)


def inputs_at_balance(c: Comparator) -> F64:
    """Return the input at which each comparator turns, V, float64[n]."""
    out = np.empty(c.output.size)
    turns_at(c, out)
    return out
