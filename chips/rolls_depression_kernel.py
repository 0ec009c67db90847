"""Compiled events of a ROLLS chip's depressed synapses: nothing is done to one between its events.

At an event of a synapse, at the beginning of a step, each weight device of its level has

    R -> 1 - (1 - R) e^(-t / tau)                                  t since its last event
    mean over the pulse of F(p - kappa x / U_T) = F + (a^2 / 24) F'',  a = kappa d / U_T
    F = q^2,  F'' = (s^2 + q s (1 - s)) / 2,  q = ln(1 + E),  s = E / (1 + E)
    E = e^(p / 2 - a / 4) R^(kappa / 2)                             in the middle of the pulse
    R -> R e^(-d / U_T)

The charge of the event is a cubic of the share that the sum of these currents is of its value at rest: what
the common switch, the mirror and its lateness do to it (`chips.rolls_depression`).
"""

from __future__ import annotations

import math

import numpy as np

from chips import rolls_chip_layout, rolls_depression_layout
from chips.rolls_chip_layout import LAST, ONE, READ, VIRTUAL, ZERO, Scratch, Traffic
from chips.rolls_depression_layout import Depressing, DepressionArrays, DepressionTables
from circuits.compiled import compiled

_CALLEES = (rolls_chip_layout, rolls_depression_layout)
_compiled = compiled(callees=_CALLEES, fastmath={"contract", "nsz", "arcp"})
_inlined = compiled(callees=_CALLEES, fastmath={"contract", "nsz", "arcp"}, forceinline=True)

LEAST = np.float32(1e-30)  # of R: so that its logarithm is a number


@_inlined
def _charge(d: DepressionTables, a: DepressionArrays, slot: int, now: int) -> np.float32:
    """Charge of an event, in z, and the state behind it."""
    gone = np.float32(now - a.seen[slot])
    share = ZERO
    for j in range(d.first[slot], d.first[slot + 1]):
        found = max(ONE - (ONE - a.resource[j]) * math.exp(-gone * d.fall[j]), LEAST)
        e = d.scale[j] * math.exp(d.half[0] * math.log(found))
        q, s = math.log1p(e), e / (ONE + e)
        share += d.part[j] * (q * q + d.bend[j] * s * (s + q * (ONE - s)))
        a.resource[j] = found * d.kept[j]
    a.seen[slot] = now
    c = d.shape[slot]
    return max(c[0] + share * (c[1] + share * (c[2] + share * c[3])), ZERO)


@_compiled
def deliver_depressed(d: Depressing, t: Traffic, now: int, until: float, s: Scratch) -> None:
    """Charges of the last step's spikes, and of the events before `until` s, at depressed synapses.

    now: number of the step. `t` is left as it is: what else these events do is done behind this.
    """
    tables, arrays, exciting = d.tables, d.arrays, s.charge[0]
    for j in range(t.counts[LAST]):
        column = t.last[j]
        for slot in range(tables.start[column], tables.start[column + 1]):
            exciting[tables.post[slot]] += _charge(tables, arrays, slot, now)
    j = t.counts[READ]
    while j < t.times.size and t.times[j] < until:
        if t.columns[j] >= VIRTUAL:
            slot = tables.slot[t.columns[j] - VIRTUAL, t.neurons[j]]
            if slot >= 0:
                exciting[t.neurons[j]] += _charge(tables, arrays, slot, now)
        j += 1


@_compiled
def recover(d: Depressing, now: int) -> None:
    """Bring the state of all synapses to the beginning of step `now`."""
    tables, arrays = d.tables, d.arrays
    for slot in range(arrays.seen.size):
        gone = np.float32(now - arrays.seen[slot])
        for j in range(tables.first[slot], tables.first[slot + 1]):
            arrays.resource[j] = ONE - (ONE - arrays.resource[j]) * math.exp(-gone * tables.fall[j])
        arrays.seen[slot] = now
