"""Nodes of a ROLLS neuron that move in a spike under the law with all its effects."""

from __future__ import annotations

import math
from typing import NamedTuple

from chips.rolls.lumped.whole import series_current, terms_at
from chips.rolls.neuron.spike_lanes import LANES, NODES, NUDGE, NUDGED, OWN, RATE, V
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import Terms, channel, leaked

STEEPEST = 4.0  # e-folds, ours: of a drive in a spike, beyond which mc4 and the reset are all that counts
MC1, MC2, MC4, MK4, MK5, MK6P, MK6N, MK8, MA1, MA2 = range(10)  # rows of devices


class WholeSpike(NamedTuple):
    """The nodes that move in a spike, of n neurons, float64[n] unless said.

    rows: of the devices of these rows, float64[10, TERMS, n]; gates: V, of mc2, mk4, mk5 and ma2, each
    from its bulk, float64[4, n]; thresholds: of the inverters behind v_o1 and k1, V, float64[2, n].
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


_compiled = compiled()


@_compiled
def _into(t: Terms, gate: float, drain: float) -> float:
    """Current into a drain, A, its source being at the bulk; V above the bulk (below, pFET)."""
    return float(channel(t, drain, gate, 0.0)[0] + leaked(t, drain, gate)[0])


@_compiled
def _rate(c: WholeSpike, k: int, node: int, v: F64) -> float:
    """dv/dt of one node, V/s; v: the four voltages."""
    dd, rows = c.v_dd, c.rows
    if node == 0:
        reset = dd if v[3] < c.thresholds[1, k] else 0.0
        more = min(c.steep[k] * max(v[0] - c.start[k], 0.0), STEEPEST)
        into = c.drive[k] * math.exp(more) if reset == 0.0 else 0.0
        into += _into(terms_at(rows[MC4], k), dd - v[1], dd - v[0])
        into -= _into(terms_at(rows[MK8], k), reset, v[0])
    elif node == 1:
        into = _into(terms_at(rows[MC2], k), c.gates[0, k], dd - v[1])
        into -= _into(terms_at(rows[MC1], k), v[0], v[1])
    elif node == 2:
        into = -_into(terms_at(rows[MK5], k), c.gates[2, k], v[2])
        if v[1] < c.thresholds[0, k]:
            into += _into(terms_at(rows[MK4], k), c.gates[1, k], dd - v[2])
    else:
        into = _into(terms_at(rows[MK6P], k), dd - v[2], dd - v[3])
        into -= _into(terms_at(rows[MK6N], k), v[2], v[3])
    return float(into / c.capacitance[node, k])


@_compiled
def fill_whole_rates(c: WholeSpike, first: int, count: int, w: F64) -> None:
    """Fill how fast all nodes of the lanes move, and how fast where the node itself is NUDGE higher."""
    v = w[OWN : OWN + NODES]
    for j in range(count):
        for node in range(NODES):
            v[node] = w[V + node * LANES + j]
        for node in range(NODES):
            kept = v[node]
            w[RATE + node * LANES + j] = _rate(c, first + j, node, v)
            v[node] = kept + NUDGE
            w[NUDGED + node * LANES + j] = _rate(c, first + j, node, v)
            v[node] = kept


@_compiled
def whole_adaptation(c: WholeSpike, first: int, v_o1: F64, out: F64) -> None:
    """Fill what ma1 and ma2 give with v_o1 (V) on ma1's gate, A, float64[times, neurons from `first` on]."""
    for j in range(v_o1.shape[1]):
        k = first + j
        lower, upper = terms_at(c.rows[MA1], k), terms_at(c.rows[MA2], k)
        for i in range(v_o1.shape[0]):
            out[i, j] = series_current(lower, upper, c.v_dd - v_o1[i, j], c.gates[3, k], 0.6 * c.v_dd)
