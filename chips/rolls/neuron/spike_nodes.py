"""Nodes of a ROLLS neuron that move in a spike, with constant kappa: `chips.rolls.neuron.spike`."""

from __future__ import annotations

from typing import NamedTuple

from chips.rolls.lumped.network import stack_current
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.ekv import law

# Rows of `devices`: specific current (A) and threshold (V).
MC1, MC2, MC4, MK4, MK5, MK6P, MK6N, MK8, MA1, MA2 = range(10)


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


_compiled = compiled()


@_compiled
def _channel(c: SpikeCircuit, k: int, row: int, kappa: float, gate: float, drain: float) -> float:
    """Current of a device whose source is at its bulk, A; gate, drain: V above the bulk (below, pFET)."""
    p = kappa * (gate - c.devices[row, 1, k]) / c.u_t
    return float(c.devices[row, 0, k] * (law(p)[0] - law(p - drain / c.u_t)[0]))


@_compiled
def rate(c: SpikeCircuit, k: int, node: int, v: F64) -> float:
    """dv/dt of one node, V/s; v: the four voltages."""
    n, p, dd = c.kappa_n, c.kappa_p, c.v_dd
    if node == 0:
        reset = dd if v[3] < c.reset_threshold[k] else 0.0
        into = c.drive[k] if reset == 0.0 else 0.0
        into += _channel(c, k, MC4, p, dd - v[1], dd - v[0]) - _channel(c, k, MK8, n, reset, v[0])
    elif node == 1:
        into = _channel(c, k, MC2, p, c.buf[k], dd - v[1]) - _channel(c, k, MC1, n, v[0], v[1])
    elif node == 2:
        into = -_channel(c, k, MK5, n, c.rfr2[k], v[2])
        if v[1] < c.spike_threshold[k]:
            up = c.charging[k]
            into += c.devices[MK4, 0, k] * (law(up)[0] - law(up - (dd - v[2]) / c.u_t)[0])
    else:
        into = _channel(c, k, MK6P, p, dd - v[2], dd - v[3]) - _channel(c, k, MK6N, n, v[2], v[3])
    return float(into / c.capacitance[node, k])


@_compiled
def adaptation(c: SpikeCircuit, k: int, v_o1: float) -> float:
    """What ma1 and ma2 give with v_o1 on ma1's gate, A."""
    p1 = c.kappa_p * (c.v_dd - v_o1 - c.devices[MA1, 1, k]) / c.u_t
    p2 = c.kappa_p * (c.ahw[k] - c.devices[MA2, 1, k]) / c.u_t
    return float(stack_current(c.devices[MA1, 0, k], p1, c.devices[MA2, 0, k], p2, 0.6 * c.v_dd / c.u_t))
