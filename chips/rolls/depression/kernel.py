"""Compiled events of a ROLLS chip's depressed synapses, to which nothing is done between their events.

At an event of a synapse, at the beginning of a step, each weight device of its level has

    R -> 1 - (1 - R) e^(-t / tau)                                  t since its last event
    mean over the pulse of F(p - kappa x / U_T) = F + (a / 2) F'',  a the variance of kappa x / U_T in it
    F = q^2,  F'' = (s^2 + q s (1 - s)) / 2,  q = ln(1 + E),  s = E / (1 + E)
    E = e^((p - kappa m / U_T) / 2) R^(kappa / 2)                  m the mean of x, from that before the pulse
    R -> R e^(-d / U_T)

The charge of the event is a cubic of the share that the sum of these currents is of its value at rest: what
the common switch, the mirror and its lateness do to it (`chips.rolls.depression.model`). All is in float32,
without calls of a mathematical library; powers and logarithms are within 3e-6.

Noise: both directions of the recovery's current are shot noise, `dR/dt` has the density
`(q / (C U_T)) R (1 + R) / tau`, at rest kT/C; so is the step, of which an electron has n of noise with what
its mirror's diode and its bias add (`chips.rolls.depression.model`). With e = e^(-t / tau) and R as the last
event left it, an event finds R with the variance

    (q / (C U_T)) [1 - e^2 - 3 (1 - R) e (1 - e) + (1 - R)^2 e^2 t / tau] + n q d / (C U_T^2) R^2 e^2

A draw is of the step, the column and the device, so that two events of a synapse in one step share theirs.
Left out: flicker, the noise of the recovery's bias, which is nothing at rest and 1/16 of the current else.
"""

from __future__ import annotations

import math

import numpy as np

from chips.noise_draw import draw
from chips.rolls.depression.layout import (
    Depressing,
    DepressionArrays,
    DepressionNoise,
    DepressionScratch,
    DepressionTables,
)
from chips.rolls.layout import (
    HALF,
    LAST,
    ONE,
    READ,
    TWO,
    VIRTUAL,
    ZERO,
    Scratch,
    Traffic,
    step_compiled,
    step_inlined,
)
from circuits.arrays import F32

LEAST = np.float32(1e-30)  # of R: so that its logarithm is a number
FARTHEST, SQUARED, OVER = np.float32(40.0), 6, np.float32(1.0 / 64.0)  # of an exponent; e^-x = (e^(-x/64))^64
THIRD, FIFTH, SEVENTH, NINTH = (np.float32(1.0 / n) for n in (3, 5, 7, 9))
QUARTER, LN2, EIGHT = np.float32(0.25), np.float32(math.log(2.0)), np.float32(8.0)
EXPONENT, MANTISSA, UNIT = np.int32(23), np.int32(0x7FFFFF), np.int32(0x3F800000)  # of a float32
BIAS = np.int32(127)
COLUMN, THREE = 64, np.float32(3.0)  # first stream of the columns' draws, behind those of a chip's filters


@step_inlined
def _fallen(x: np.float32) -> np.float32:
    """e^-x of an x from 0 on; without a call, so that loops are packed."""
    z = min(x, FARTHEST) * OVER
    p = ONE / (ONE + z * (ONE + z * HALF * (ONE + z * THIRD * (ONE + z * QUARTER))))
    for _ in range(SQUARED):
        p *= p
    return p


@step_inlined
def _odd(t: np.float32) -> np.float32:
    """Atanh t of a t up to 1/3."""
    u = t * t
    return t * (ONE + u * (THIRD + u * (FIFTH + u * (SEVENTH + u * NINTH))))


@step_inlined
def _recovered(
    d: DepressionTables, a: DepressionArrays, w: DepressionScratch, lo: int, hi: int, now: int
) -> None:
    """R that an event of the devices `lo` to `hi` finds, into w.found."""
    at = np.int32(now)
    resource, seen, fall = a.resource[lo:hi], a.seen[lo:hi], d.fall[lo:hi]
    for k in range(hi - lo):
        gone = np.float32(at - seen[k])
        w.found[k] = max(ONE - (ONE - resource[k]) * _fallen(gone * fall[k]), LEAST)


@step_inlined
def _disturb(noise: DepressionNoise | None, d: Depressing, lo: int, hi: int, now: int, column: int) -> None:
    """Noise onto what `_recovered` has found."""
    if noise is None:
        return
    draw(noise.draws, now, COLUMN + column)
    at, first, diffuse = np.int32(now), d.tables.first[d.tables.start[column]], noise.diffuse[0]
    resource, seen, fall = d.arrays.resource[lo:hi], d.arrays.seen[lo:hi], d.tables.fall[lo:hi]
    shot, normal, found = noise.shot[lo:hi], noise.draws.normal[lo - first : hi - first], d.scratch.found
    for k in range(hi - lo):
        gone = min(np.float32(at - seen[k]) * fall[k], FARTHEST)
        left, away = _fallen(gone), ONE - resource[k]
        spread = ONE - left * left - THREE * away * left * (ONE - left) + away * away * left * left * gone
        variance = diffuse * max(spread, ZERO) + shot[k] * resource[k] * resource[k] * left * left
        found[k] = max(found[k] + math.sqrt(variance) * normal[k], LEAST)


@step_inlined
def _shares(
    d: DepressionTables, a: DepressionArrays, w: DepressionScratch, lo: int, hi: int, now: int
) -> None:
    """A pulse of the devices `lo` to `hi` at w.found: parts of the current into w.share, and their state."""
    n, at, half = hi - lo, np.int32(now), d.half[0]
    resource, seen, kept = a.resource[lo:hi], a.seen[lo:hi], d.kept[lo:hi]
    scale, bend, part = d.scale[lo:hi], d.bend[lo:hi], d.part[lo:hi]
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


@step_inlined
def _bring(d: Depressing, begin: int, end: int, now: int, column: int, exciting: F32) -> None:
    """An event of the synapses `begin` to `end` of a column: their charges, in z."""
    tables, w = d.tables, d.scratch
    lo, hi = tables.first[begin], tables.first[end]
    _recovered(tables, d.arrays, w, lo, hi, now)
    _disturb(d.noise, d, lo, hi, now, column)
    _shares(tables, d.arrays, w, lo, hi, now)
    for slot in range(begin, end):
        share = ZERO
        for j in range(tables.first[slot] - lo, tables.first[slot + 1] - lo):
            share += w.share[j]
        c = tables.shape[slot]
        exciting[tables.post[slot]] += max(c[0] + share * (c[1] + share * (c[2] + share * c[3])), ZERO)


@step_compiled
def deliver_depressed(d: Depressing, t: Traffic, now: int, until: float, s: Scratch) -> None:
    """Deliver the last step's spikes, and the events before `until` s, to depressed synapses.

    now: number of the step. `t` is left as it is: what else these events do is done behind this.
    """
    exciting = s.charge[0]
    for j in range(t.counts[LAST]):
        column = t.last[j]
        _bring(d, d.tables.start[column], d.tables.start[column + 1], now, column, exciting)
    j = t.counts[READ]
    while j < t.times.size and t.times[j] < until:
        if t.columns[j] >= VIRTUAL:
            column = t.columns[j] - VIRTUAL
            slot = d.tables.slot[column, t.neurons[j]]
            if slot >= 0:
                _bring(d, slot, slot + 1, now, column, exciting)
        j += 1


@step_compiled
def recover(d: Depressing, now: int) -> None:
    """Bring the state of all synapses to the beginning of step `now`."""
    tables, arrays = d.tables, d.arrays
    for j in range(arrays.seen.size):
        gone = np.float32(np.int32(now) - arrays.seen[j])
        arrays.resource[j] = ONE - (ONE - arrays.resource[j]) * math.exp(-gone * tables.fall[j])
        arrays.seen[j] = now
