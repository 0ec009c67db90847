"""Nodes of a ROLLS neuron that move in a spike, with constant kappa: `chips.rolls.neuron.spike`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.network import stack
from chips.rolls.neuron.spike_lanes import (
    CAPACITANCE,
    DRAIN,
    DRAIN_NUDGED,
    DRIVE,
    FIRED,
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
    OWN,
    TAKES,
    TAKES_NUDGED,
    V,
    put_drains,
    put_rates,
)
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.packable import even_interpolation

# where a lane's own numbers stand: of the devices that move nodes, one after the other, their currents,
# thresholds and pinch-off voltages
_CURRENT, _THRESHOLD, _PINCH = OWN, OWN + MOVING * LANES, OWN + 2 * MOVING * LANES


class SpikeCircuit(NamedTuple):
    """The nodes that move in a spike, of n neurons, float64[n] unless said.

    devices: specific current (A) and threshold (V) in the order of MC1 to MA2, float64[10, 2, n].
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
        for row in range(MOVING):
            w[_CURRENT + row * LANES + j] = c.devices[row, 0, k]
            w[_THRESHOLD + row * LANES + j] = c.devices[row, 1, k]
        for node in range(NODES):
            w[CAPACITANCE + node * LANES + j] = c.capacitance[node, k]
        w[DRIVE + j], w[FIRED + j], w[LET_GO + j] = c.drive[k], c.spike_threshold[k], c.reset_threshold[k]
        w[_PINCH + MC2 * LANES + j] = c.kappa_p * (c.buf[k] - c.devices[MC2, 1, k]) / c.u_t
        w[_PINCH + MK5 * LANES + j] = c.kappa_n * (c.rfr2[k] - c.devices[MK5, 1, k]) / c.u_t
        w[_PINCH + MK4 * LANES + j] = c.charging[k]


@compiled(forceinline=True)
def _gated(w: F64, j: int, device: int, kappa: float, gate: float, u_t: float) -> None:
    """Put the pinch-off voltage (U_T) of a device with its gate at `gate`, V."""
    at = device * LANES + j
    w[_PINCH + at] = kappa * (gate - w[_THRESHOLD + at]) / u_t


@compiled()
def fill_rates(c: SpikeCircuit, count: int, w: F64) -> None:
    """Fill how fast all nodes of the lanes move, and how fast where the node itself is NUDGE higher."""
    u_t, dd, n, p = c.u_t, c.v_dd, c.kappa_n, c.kappa_p
    put_drains(w, dd)
    for j in range(LANES):
        reset = dd if w[V + 3 * LANES + j] < w[LET_GO + j] else 0.0
        w[INTO + j] = w[DRIVE + j] if reset == 0.0 else 0.0
        w[INTO + LANES + j] = w[INTO + j]
        _gated(w, j, MC4, p, dd - w[V + LANES + j], u_t)
        _gated(w, j, MK8, n, reset, u_t)
        _gated(w, j, MC1, n, w[V + j], u_t)
        _gated(w, j, MK6P, p, dd - w[V + 2 * LANES + j], u_t)
        _gated(w, j, MK6N, n, w[V + 2 * LANES + j], u_t)
    for j in range(min(MOVING * LANES, MOVING * count * LANES)):
        pinch, current = w[_PINCH + j], w[_CURRENT + j]
        full = even_interpolation(pinch)
        w[TAKES + j] = current * (full - even_interpolation(pinch - w[DRAIN + j] / u_t))
        w[TAKES_NUDGED + j] = current * (full - even_interpolation(pinch - w[DRAIN_NUDGED + j] / u_t))
    put_rates(w)


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
