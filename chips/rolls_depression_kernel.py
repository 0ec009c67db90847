"""Compiled events of a ROLLS chip's depressed synapses: nothing is done to one between its events.

At an event of a synapse, at the beginning of a step, each weight device of its level has

    R -> 1 - (1 - R) e^(-t / tau)                                  t since its last event
    mean over the pulse of F(p - kappa x / U_T) = F + (a / 2) F'',  a the variance of kappa x / U_T in it
    F = q^2,  F'' = (s^2 + q s (1 - s)) / 2,  q = ln(1 + E),  s = E / (1 + E)
    E = e^((p - kappa m / U_T) / 2) R^(kappa / 2)                  m the mean of x, from that before the pulse
    R -> R e^(-d / U_T)

The charge of the event is a cubic of the share that the sum of these currents is of its value at rest: what
the common switch, the mirror and its lateness do to it (`chips.rolls_depression`). All is in float32, without
calls of a mathematical library; powers and logarithms are within 3e-6.
"""

from __future__ import annotations

import math

import numpy as np

from chips.rolls_chip_layout import F32, HALF, LAST, ONE, READ, TWO, VIRTUAL, ZERO, Scratch, Traffic
from chips.rolls_depression_layout import Depressing, DepressionArrays, DepressionScratch, DepressionTables
from circuits.compiled import compiled

_compiled = compiled(fastmath={"contract", "nsz", "arcp"})
_inlined = compiled(fastmath={"contract", "nsz", "arcp"}, forceinline=True)

LEAST = np.float32(1e-30)  # of R: so that its logarithm is a number
FARTHEST, SQUARED, OVER = np.float32(40.0), 6, np.float32(1.0 / 64.0)  # of an exponent; e^-x = (e^(-x/64))^64
THIRD, FIFTH, SEVENTH, NINTH = (np.float32(1.0 / n) for n in (3, 5, 7, 9))
QUARTER, LN2, EIGHT = np.float32(0.25), np.float32(math.log(2.0)), np.float32(8.0)
EXPONENT, MANTISSA, UNIT = np.int32(23), np.int32(0x7FFFFF), np.int32(0x3F800000)  # of a float32
BIAS = np.int32(127)


@_inlined
def _fallen(x: np.float32) -> np.float32:
    """e^-x of an x from 0 on; without a call, so that loops are packed."""
    z = min(x, FARTHEST) * OVER
    p = ONE / (ONE + z * (ONE + z * HALF * (ONE + z * THIRD * (ONE + z * QUARTER))))
    for _ in range(SQUARED):
        p *= p
    return p


@_inlined
def _odd(t: np.float32) -> np.float32:
    """Atanh t of a t up to 1/3."""
    u = t * t
    return t * (ONE + u * (THIRD + u * (FIFTH + u * (SEVENTH + u * NINTH))))


@_inlined
def _shares(
    d: DepressionTables, a: DepressionArrays, w: DepressionScratch, lo: int, hi: int, now: int
) -> None:
    """An event of the devices `lo` to `hi`: their parts of the current into w.share, and their state."""
    n, at, half = hi - lo, np.int32(now), d.half[0]
    resource, seen, fall, kept = a.resource[lo:hi], a.seen[lo:hi], d.fall[lo:hi], d.kept[lo:hi]
    scale, bend, part = d.scale[lo:hi], d.bend[lo:hi], d.part[lo:hi]
    for k in range(n):
        gone = np.float32(at - seen[k])
        w.found[k] = max(ONE - (ONE - resource[k]) * _fallen(gone * fall[k]), LEAST)
    for k in range(n):
        bits = w.found_bits[k]
        w.power[k] = np.float32((bits >> EXPONENT) - BIAS)
        w.mantissa_bits[k] = (bits & MANTISSA) | UNIT
    for k in range(n):
        m = w.mantissa[k]
        log = w.power[k] * LN2 + TWO * _odd((m - ONE) / (m + ONE))
        e = scale[k] * _fallen(-half * log)
        # ln(1 + E) by two roots: 8 atanh of what their fourth root leaves
        r = math.sqrt(ONE + e)
        rr = math.sqrt(r)
        q, s = EIGHT * _odd(e / ((r + ONE) * (rr + ONE) * (rr + ONE))), e / (ONE + e)
        w.share[k] = part[k] * (q * q + bend[k] * s * (s + q * (ONE - s)))
    for k in range(n):
        resource[k] = w.found[k] * kept[k]
        seen[k] = at


@_inlined
def _bring(d: Depressing, begin: int, end: int, now: int, exciting: F32) -> None:
    """An event of the synapses `begin` to `end`: their charges, in z."""
    tables, w = d.tables, d.scratch
    lo = tables.first[begin]
    _shares(tables, d.arrays, w, lo, tables.first[end], now)
    for slot in range(begin, end):
        share = ZERO
        for j in range(tables.first[slot] - lo, tables.first[slot + 1] - lo):
            share += w.share[j]
        c = tables.shape[slot]
        exciting[tables.post[slot]] += max(c[0] + share * (c[1] + share * (c[2] + share * c[3])), ZERO)


@_compiled
def deliver_depressed(d: Depressing, t: Traffic, now: int, until: float, s: Scratch) -> None:
    """Charges of the last step's spikes, and of the events before `until` s, at depressed synapses.

    now: number of the step. `t` is left as it is: what else these events do is done behind this.
    """
    exciting = s.charge[0]
    for j in range(t.counts[LAST]):
        column = t.last[j]
        _bring(d, d.tables.start[column], d.tables.start[column + 1], now, exciting)
    j = t.counts[READ]
    while j < t.times.size and t.times[j] < until:
        if t.columns[j] >= VIRTUAL:
            slot = d.tables.slot[t.columns[j] - VIRTUAL, t.neurons[j]]
            if slot >= 0:
                _bring(d, slot, slot + 1, now, exciting)
        j += 1


@_compiled
def recover(d: Depressing, now: int) -> None:
    """Bring the state of all synapses to the beginning of step `now`."""
    tables, arrays = d.tables, d.arrays
    for j in range(arrays.seen.size):
        gone = np.float32(np.int32(now) - arrays.seen[j])
        arrays.resource[j] = ONE - (ONE - arrays.resource[j]) * math.exp(-gone * tables.fall[j])
        arrays.seen[j] = now
