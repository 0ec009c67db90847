"""Nodes of a ROLLS neuron that move in a spike under the law with all its effects."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.whole import TERMS, series, terms_in
from chips.rolls.neuron.spike_lanes import (
    CAPACITANCE,
    DRAIN,
    DRAIN_NUDGED,
    DRIVE,
    INTO,
    LANES,
    LET_GO,
    MA1,
    MA2,
    MC1,
    MC2,
    MC4,
    MK4,
    MK5,
    MK6N,
    MK6P,
    MK8,
    MOVING,
    NODES,
    NUDGE,
    OWN,
    START,
    STEEP,
    TAKES,
    TAKES_NUDGED,
    V,
    put_drains,
    put_rates,
)
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.packable import LIMIT, even_channel, even_exp, even_leaked

STEEPEST = 4.0  # e-folds, ours: of a drive in a spike, beyond which mc4 and the reset are all that counts


class WholeSpike(NamedTuple):
    """The nodes that move in a spike, of n neurons, float64[n] unless said.

    rows: of the devices MC1 to MA2, float64[10, TERMS, n]; gates: V, of mc2, mk4, mk5 and ma2, each from its
    bulk, float64[4, n]; thresholds: of the inverters behind v_o1 and k1, V, float64[2, n].
    """

    v_dd: float
    capacitance: F64  # of v_mem, v_o1, v_ref, k1, F, float64[4, n]
    rows: F64
    gates: F64
    thresholds: F64
    start: F64  # V, of v_mem
    start_drop: F64  # V, of v_o1 below the supply
    drive: F64  # A, into v_mem at the start
    steep: F64  # 1/V, of the drive's logarithm over v_mem


_ROW = MOVING * LANES  # of a term of all moving devices; their gates stand behind the terms
_GATE = OWN + TERMS * _ROW


@compiled()
def take_whole_lanes(c: WholeSpike, first: int, count: int, w: F64) -> None:
    """Fill the lanes' own numbers with those of the neurons from `first` on."""
    for j in range(count):
        k = first + j
        for device in range(MOVING):
            for term in range(TERMS):
                w[OWN + term * _ROW + device * LANES + j] = c.rows[device, term, k]
        for gate, device in enumerate((MC2, MK4, MK5)):
            w[_GATE + device * LANES + j] = c.gates[gate, k]
        for node in range(NODES):
            w[CAPACITANCE + node * LANES + j] = c.capacitance[node, k]
        w[START + j], w[DRIVE + j], w[STEEP + j] = c.start[k], c.drive[k], c.steep[k]


@compiled()
def fill_whole_rates(v_dd: float, count: int, w: F64) -> None:
    """Fill how fast all nodes of the lanes move, and how fast where the node itself is NUDGE higher."""
    put_drains(w, v_dd)
    for j in range(LANES):
        resets = w[V + 3 * LANES + j] < w[LET_GO + j]
        w[_GATE + MK8 * LANES + j] = v_dd if resets else 0.0
        w[_GATE + MC4 * LANES + j] = v_dd - w[V + LANES + j]
        w[_GATE + MC1 * LANES + j] = w[V + j]
        w[_GATE + MK6P * LANES + j] = v_dd - w[V + 2 * LANES + j]
        w[_GATE + MK6N * LANES + j] = w[V + 2 * LANES + j]
        for row, v in ((0, w[V + j]), (1, w[V + j] + NUDGE)):
            more = min(w[STEEP + j] * max(v - w[START + j], 0.0), STEEPEST)
            into = w[DRIVE + j] * even_exp(max(more, -LIMIT))
            w[INTO + row * LANES + j] = 0.0 if resets else into
    for j in range(min(_ROW, _ROW * count)):
        t, gate = terms_in(w, j, OWN, _ROW), w[_GATE + j]
        for drain, takes in ((DRAIN, TAKES), (DRAIN_NUDGED, TAKES_NUDGED)):
            v = w[drain + j]
            w[takes + j] = even_channel(t, v, gate, 0.0)[0] + even_leaked(t, v, gate)[0]
    for j in range(LANES):
        # first of all that flows into v_mem
        w[TAKES + MC4 * LANES + j] += w[INTO + j]
        w[TAKES_NUDGED + MC4 * LANES + j] += w[INTO + LANES + j]
        w[INTO + j], w[INTO + LANES + j] = 0.0, 0.0
    put_rates(w)


@compiled(_nrt=True)
def whole_adaptation(c: WholeSpike, first: int, v_o1: F64, out: F64) -> None:
    """Fill what ma1 and ma2 give with v_o1 (V) on ma1's gate, A, float64[times, neurons from `first` on]."""
    count = v_o1.shape[1]
    found, gates = np.empty((count, v_o1.shape[0])), np.empty((3, count, v_o1.shape[0]))
    for j in range(count):
        for i in range(v_o1.shape[0]):
            gates[0, j, i], gates[1, j, i] = c.v_dd - v_o1[i, j], c.gates[3, first + j]
            gates[2, j, i] = 0.6 * c.v_dd
    some = slice(first, first + count)
    series(c.rows[MA1][:, some].copy(), c.rows[MA2][:, some].copy(), gates[0], gates[1], gates[2], found)
    for j in range(count):
        for i in range(v_o1.shape[0]):
            out[i, j] = found[j, i]
