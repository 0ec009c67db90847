"""Nodes of a ROLLS neuron that move in a spike, with constant kappa: `chips.rolls.neuron.spike`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.network import stack
from chips.rolls.neuron.spike_lanes import LANES, NODES, NUDGE, NUDGED, OWN, RATE, V
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.packable import even_interpolation

# Rows of `devices`: specific current (A) and threshold (V).
MC1, MC2, MC4, MK4, MK5, MK6P, MK6N, MK8, MA1, MA2 = range(10)

# Rows of a lane's own numbers: current and threshold of the devices that move nodes; each node's capacitance;
# drive and thresholds; pinch-off voltages of fixed gates with what they carry saturated, over I_S.
_CURRENT, _THRESHOLD, _CAPACITANCE = OWN, OWN + 8 * LANES, OWN + 16 * LANES
_DRIVE, _FIRED, _LET_GO = (OWN + (16 + NODES + k) * LANES for k in range(3))
_FIXED = OWN + (19 + NODES) * LANES
_BUF, _RFR2, _CHARGING, _RESET, _HELD = (_FIXED + 2 * k * LANES for k in range(5))


class SpikeCircuit(NamedTuple):
    """The nodes that move in a spike, of n neurons, float64[n] unless said.

    devices: specific current (A) and threshold (V) in the order of the rows above, float64[10, 2, n].
    """

    u_t: float
    kappa_n: float
    kappa_p: float
    v_dd: float
    capacitance: F64  # of v_mem, v_o1, v_ref, k1, F, float64[4, n]
    devices: F64
    buf: F64  # V below the supply, gate of mc2
    charging: F64  # A, I_rfr1 as mk1 has it: gate of mk4 as a pinch-off voltage in U_T
    rfr2: F64  # V, gate of mk5
    ahw: F64  # V below the supply, gate of ma2
    spike_threshold: F64  # V, of the inverter behind v_o1
    reset_threshold: F64  # V, of the one behind k1
    start: F64  # V, of v_mem
    start_drop: F64  # V, of v_o1 below the supply
    drive: F64  # A, into v_mem


@compiled()
def take_lanes(c: SpikeCircuit, first: int, count: int, w: F64) -> None:
    """Fill the lanes' own numbers with those of the neurons from `first` on."""
    for j in range(count):
        k = first + j
        for row in range(MK8 + 1):
            w[_CURRENT + row * LANES + j] = c.devices[row, 0, k]
            w[_THRESHOLD + row * LANES + j] = c.devices[row, 1, k]
        for node in range(NODES):
            w[_CAPACITANCE + node * LANES + j] = c.capacitance[node, k]
        w[_DRIVE + j], w[_FIRED + j], w[_LET_GO + j] = c.drive[k], c.spike_threshold[k], c.reset_threshold[k]
        w[_BUF + j] = c.kappa_p * (c.buf[k] - c.devices[MC2, 1, k]) / c.u_t
        w[_RFR2 + j] = c.kappa_n * (c.rfr2[k] - c.devices[MK5, 1, k]) / c.u_t
        w[_CHARGING + j] = c.charging[k]
        w[_RESET + j] = c.kappa_n * (c.v_dd - c.devices[MK8, 1, k]) / c.u_t
        w[_HELD + j] = c.kappa_n * (0.0 - c.devices[MK8, 1, k]) / c.u_t
        for row in range(_FIXED, _FIXED + 10 * LANES, 2 * LANES):
            w[row + LANES + j] = even_interpolation(w[row + j])


@compiled(forceinline=True)
def _left(w: F64, j: int, device: int, p: float, full: float, drain: float) -> float:
    """Current of a device whose source is at its bulk, A.

    p, full: its pinch-off voltage in U_T, and what it carries saturated, over I_S; drain: U_T.
    """
    return float(w[_CURRENT + device * LANES + j] * (full - even_interpolation(p - drain)))


@compiled(forceinline=True)
def _gated(w: F64, j: int, device: int, kappa: float, gate: float, u_t: float) -> tuple[float, float]:
    """Pinch-off voltage (U_T) of a device with its gate at `gate` (V), and what it carries, over I_S."""
    p = kappa * (gate - w[_THRESHOLD + device * LANES + j]) / u_t
    return p, even_interpolation(p)


@compiled(forceinline=True)
def _put(w: F64, j: int, node: int, row: int, into: float) -> None:
    """Put how fast a node moves with a current into it, V/s."""
    w[row + node * LANES + j] = into / w[_CAPACITANCE + node * LANES + j]


@compiled()
def fill_rates(c: SpikeCircuit, count: int, w: F64) -> None:
    """Fill how fast all nodes of the lanes move, and how fast where the node itself is NUDGE higher."""
    u_t, dd, n, p = c.u_t, c.v_dd, c.kappa_n, c.kappa_p
    for j in range(min(count, LANES)):
        resets = w[V + 3 * LANES + j] < w[_LET_GO + j]
        given = 0.0 if resets else w[_DRIVE + j]
        p_reset, f_reset, p_held, f_held = (
            w[_RESET + j],
            w[_RESET + LANES + j],
            w[_HELD + j],
            w[_HELD + LANES + j],
        )
        p8, f8 = p_reset if resets else p_held, f_reset if resets else f_held
        p4, f4 = _gated(w, j, MC4, p, dd - w[V + LANES + j], u_t)
        v = w[V + j]
        pulled = _left(w, j, MC4, p4, f4, (dd - v) / u_t) - _left(w, j, MK8, p8, f8, v / u_t)
        _put(w, j, 0, RATE, given + pulled)
        v = v + NUDGE
        pulled = _left(w, j, MC4, p4, f4, (dd - v) / u_t) - _left(w, j, MK8, p8, f8, v / u_t)
        _put(w, j, 0, NUDGED, given + pulled)
    for j in range(min(count, LANES)):
        p2, f2 = w[_BUF + j], w[_BUF + LANES + j]
        p1, f1 = _gated(w, j, MC1, n, w[V + j], u_t)
        v = w[V + LANES + j]
        _put(w, j, 1, RATE, _left(w, j, MC2, p2, f2, (dd - v) / u_t) - _left(w, j, MC1, p1, f1, v / u_t))
        v = v + NUDGE
        _put(w, j, 1, NUDGED, _left(w, j, MC2, p2, f2, (dd - v) / u_t) - _left(w, j, MC1, p1, f1, v / u_t))
    for j in range(min(count, LANES)):
        spikes = w[V + LANES + j] < w[_FIRED + j]
        p5, f5, p4, f4 = w[_RFR2 + j], w[_RFR2 + LANES + j], w[_CHARGING + j], w[_CHARGING + LANES + j]
        v = w[V + 2 * LANES + j]
        drawn, filled = -_left(w, j, MK5, p5, f5, v / u_t), _left(w, j, MK4, p4, f4, (dd - v) / u_t)
        _put(w, j, 2, RATE, drawn + filled if spikes else drawn)
        v = v + NUDGE
        drawn, filled = -_left(w, j, MK5, p5, f5, v / u_t), _left(w, j, MK4, p4, f4, (dd - v) / u_t)
        _put(w, j, 2, NUDGED, drawn + filled if spikes else drawn)
    for j in range(min(count, LANES)):
        p6, f6 = _gated(w, j, MK6P, p, dd - w[V + 2 * LANES + j], u_t)
        p7, f7 = _gated(w, j, MK6N, n, w[V + 2 * LANES + j], u_t)
        v = w[V + 3 * LANES + j]
        _put(w, j, 3, RATE, _left(w, j, MK6P, p6, f6, (dd - v) / u_t) - _left(w, j, MK6N, p7, f7, v / u_t))
        v = v + NUDGE
        _put(w, j, 3, NUDGED, _left(w, j, MK6P, p6, f6, (dd - v) / u_t) - _left(w, j, MK6N, p7, f7, v / u_t))


@compiled(_nrt=True)
def adaptation(c: SpikeCircuit, first: int, v_o1: F64, out: F64) -> None:
    """Fill what ma1 and ma2 give with v_o1 (V) on ma1's gate, A, float64[times, neurons from `first` on]."""
    count = v_o1.shape[1]
    i1, p1, i2, p2 = np.empty((4, v_o1.size))
    for i in range(v_o1.shape[0]):
        for j in range(count):
            k, at = first + j, i * count + j
            i1[at], i2[at] = c.devices[MA1, 0, k], c.devices[MA2, 0, k]
            p1[at] = c.kappa_p * (c.v_dd - v_o1[i, j] - c.devices[MA1, 1, k]) / c.u_t
            p2[at] = c.kappa_p * (c.ahw[k] - c.devices[MA2, 1, k]) / c.u_t
    stack(i1, p1, i2, p2, np.full(v_o1.size, 0.6 * c.v_dd / c.u_t), out.reshape(-1))
