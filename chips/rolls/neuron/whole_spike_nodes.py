"""Nodes of a ROLLS neuron that move in a spike under the law with all its effects."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.whole import TERMS, series, terms_in
from chips.rolls.neuron import spike_lanes as lanes
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


_ROW = lanes.MOVING * lanes.LANES  # of a term of all moving devices; their gates stand behind the terms
_GATE = lanes.OWN + TERMS * _ROW


@compiled()
def take_whole_lanes(c: WholeSpike, first: int, count: int, w: F64) -> None:
    """Fill the lanes' own numbers with those of the neurons from `first` on."""
    for j in range(count):
        k = first + j
        for device in range(lanes.MOVING):
            for term in range(TERMS):
                w[lanes.OWN + term * _ROW + device * lanes.LANES + j] = c.rows[device, term, k]
        for gate, device in enumerate((lanes.MC2, lanes.MK4, lanes.MK5)):
            w[_GATE + device * lanes.LANES + j] = c.gates[gate, k]
        for node in range(lanes.NODES):
            w[lanes.CAPACITANCE + node * lanes.LANES + j] = c.capacitance[node, k]
        w[lanes.START + j], w[lanes.DRIVE + j], w[lanes.STEEP + j] = c.start[k], c.drive[k], c.steep[k]


@compiled()
def fill_whole_rates(v_dd: float, w: F64) -> None:
    """Fill how fast all nodes of the lanes move, and how fast where the node itself is lanes.NUDGE higher."""
    lanes.put_drains(w, v_dd)
    for j in range(lanes.LANES):
        resets = w[lanes.V + 3 * lanes.LANES + j] < w[lanes.LET_GO + j]
        w[_GATE + lanes.MK8 * lanes.LANES + j] = v_dd if resets else 0.0
        w[_GATE + lanes.MC4 * lanes.LANES + j] = v_dd - w[lanes.V + lanes.LANES + j]
        w[_GATE + lanes.MC1 * lanes.LANES + j] = w[lanes.V + j]
        w[_GATE + lanes.MK6P * lanes.LANES + j] = v_dd - w[lanes.V + 2 * lanes.LANES + j]
        w[_GATE + lanes.MK6N * lanes.LANES + j] = w[lanes.V + 2 * lanes.LANES + j]
        for row, v in ((0, w[lanes.V + j]), (1, w[lanes.V + j] + lanes.NUDGE)):
            more = min(w[lanes.STEEP + j] * max(v - w[lanes.START + j], 0.0), STEEPEST)
            into = w[lanes.DRIVE + j] * even_exp(max(more, -LIMIT))
            w[lanes.INTO + row * lanes.LANES + j] = 0.0 if resets else into
    for j in range(_ROW):  # of which that many are there, or the loop is not packed
        t, gate = terms_in(w, j, lanes.OWN, _ROW), w[_GATE + j]
        v, nudged = w[lanes.DRAIN + j], w[lanes.DRAIN_NUDGED + j]
        takes = even_channel(t, v, gate, 0.0)[0] + even_leaked(t, v, gate)[0]
        more = even_channel(t, nudged, gate, 0.0)[0] + even_leaked(t, nudged, gate)[0]
        w[lanes.TAKES + j], w[lanes.TAKES_NUDGED + j] = takes, more
    for j in range(lanes.LANES):
        # first of all that flows into v_mem
        w[lanes.TAKES + lanes.MC4 * lanes.LANES + j] += w[lanes.INTO + j]
        w[lanes.TAKES_NUDGED + lanes.MC4 * lanes.LANES + j] += w[lanes.INTO + lanes.LANES + j]
        w[lanes.INTO + j], w[lanes.INTO + lanes.LANES + j] = 0.0, 0.0
    lanes.put_rates(w)


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
    series(
        c.rows[lanes.MA1][:, some].copy(),
        c.rows[lanes.MA2][:, some].copy(),
        gates[0],
        gates[1],
        gates[2],
        found,
    )
    for j in range(count):
        for i in range(v_o1.shape[0]):
            out[i, j] = found[j, i]
