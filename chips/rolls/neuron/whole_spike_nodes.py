"""Nodes of a ROLLS neuron that move in a spike under the law with all its effects."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.whole import TERMS, series, terms_in
from chips.rolls.neuron.spike_lanes import FIRED, LANES, LET_GO, NODES, NUDGE, NUDGED, OWN, RATE, V
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.packable import LIMIT, even_channel, even_exp, even_leaked

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


_MOVING = MK8 + 1  # devices that move nodes
# where a lane's own numbers stand: those of the devices, gates of mc2, mk4 and mk5, each node's capacitance
_GATES = OWN + _MOVING * TERMS * LANES
_BUF, _CHARGING, _RFR2 = (_GATES + k * LANES for k in range(3))
_CAPACITANCE = _GATES + 3 * LANES
_START, _DRIVE, _STEEP = (_CAPACITANCE + (NODES + k) * LANES for k in range(3))


@compiled()
def take_whole_lanes(c: WholeSpike, first: int, count: int, w: F64) -> None:
    """Fill the lanes' own numbers with those of the neurons from `first` on."""
    for j in range(count):
        k = first + j
        for device in range(_MOVING):
            for term in range(TERMS):
                w[OWN + (device * TERMS + term) * LANES + j] = c.rows[device, term, k]
        for gate in range(3):
            w[_GATES + gate * LANES + j] = c.gates[gate, k]
        for node in range(NODES):
            w[_CAPACITANCE + node * LANES + j] = c.capacitance[node, k]
        w[_START + j], w[_DRIVE + j], w[_STEEP + j] = c.start[k], c.drive[k], c.steep[k]


@compiled(forceinline=True)
def _into(w: F64, j: int, device: int, gate: float, drain: float) -> float:
    """Current into a drain, A, its source being at the bulk; V above the bulk (below, pFET)."""
    t = terms_in(w, j, OWN + device * TERMS * LANES, LANES)
    return float(even_channel(t, drain, gate, 0.0)[0] + even_leaked(t, drain, gate)[0])


@compiled(forceinline=True)
def _reset_into(w: F64, j: int, v: float, v_dd: float) -> float:
    """Current into v_mem at v, A."""
    resets = w[V + 3 * LANES + j] < w[LET_GO + j]
    more = min(w[_STEEP + j] * max(v - w[_START + j], 0.0), STEEPEST)
    into = 0.0 if resets else w[_DRIVE + j] * even_exp(max(more, -LIMIT))
    into += _into(w, j, MC4, v_dd - w[V + LANES + j], v_dd - v)
    return into - _into(w, j, MK8, v_dd if resets else 0.0, v)


@compiled(forceinline=True)
def _fired_into(w: F64, j: int, v: float, v_dd: float) -> float:
    """Current into v_o1 at v, A."""
    return _into(w, j, MC2, w[_BUF + j], v_dd - v) - _into(w, j, MC1, w[V + j], v)


@compiled(forceinline=True)
def _held_into(w: F64, j: int, v: float, v_dd: float) -> float:
    """Current into v_ref at v, A."""
    drawn, filled = -_into(w, j, MK5, w[_RFR2 + j], v), _into(w, j, MK4, w[_CHARGING + j], v_dd - v)
    return drawn + filled if w[V + LANES + j] < w[FIRED + j] else drawn


@compiled(forceinline=True)
def _ending_into(w: F64, j: int, v: float, v_dd: float) -> float:
    """Current into k1 at v, A."""
    gate = w[V + 2 * LANES + j]
    return _into(w, j, MK6P, v_dd - gate, v_dd - v) - _into(w, j, MK6N, gate, v)


@compiled(forceinline=True)
def _put(w: F64, j: int, node: int, into: float, higher: float) -> None:
    """Put how fast a node moves with a current into it, V/s, and with that which it gets NUDGE higher."""
    at = node * LANES + j
    w[RATE + at], w[NUDGED + at] = into / w[_CAPACITANCE + at], higher / w[_CAPACITANCE + at]


@compiled()
def fill_whole_rates(v_dd: float, count: int, w: F64) -> None:
    """Fill how fast all nodes of the lanes move, and how fast where the node itself is NUDGE higher."""
    for j in range(min(count, LANES)):
        v = w[V + j]
        _put(w, j, 0, _reset_into(w, j, v, v_dd), _reset_into(w, j, v + NUDGE, v_dd))
    for j in range(min(count, LANES)):
        v = w[V + LANES + j]
        _put(w, j, 1, _fired_into(w, j, v, v_dd), _fired_into(w, j, v + NUDGE, v_dd))
    for j in range(min(count, LANES)):
        v = w[V + 2 * LANES + j]
        _put(w, j, 2, _held_into(w, j, v, v_dd), _held_into(w, j, v + NUDGE, v_dd))
    for j in range(min(count, LANES)):
        v = w[V + 3 * LANES + j]
        _put(w, j, 3, _ending_into(w, j, v, v_dd), _ending_into(w, j, v + NUDGE, v_dd))


@compiled(_nrt=True)
def whole_adaptation(c: WholeSpike, first: int, v_o1: F64, out: F64) -> None:
    """Fill what ma1 and ma2 give with v_o1 (V) on ma1's gate, A, float64[times, neurons from `first` on]."""
    count = v_o1.shape[1]
    found, gates = np.empty((count, v_o1.shape[0])), np.empty((3, count, v_o1.shape[0]))
    gates[0], gates[2] = c.v_dd - v_o1.T, 0.6 * c.v_dd
    for j in range(count):
        gates[1, j] = c.gates[3, first + j]
    some = slice(first, first + count)
    series(c.rows[MA1][:, some].copy(), c.rows[MA2][:, some].copy(), gates[0], gates[1], gates[2], found)
    out[:] = found.T
