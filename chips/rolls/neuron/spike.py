"""The spike of a ROLLS neuron: how late it comes, how long the reset lasts, what adaptation gets of it.

From where mc1 nearly carries what mc2 can give until the reset ends, four nodes move: v_mem, v_o1, v_ref and
k1; the inverters behind v_o1 and k1 switch at their thresholds. With a die's own devices and the circuit's
capacitances,

    C_mem dv_mem/dt = I_drive + I_mc4(v_o1) - I_mk8(k2, v_mem)
    C_o1 dv_o1/dt = I_mc2(v_o1) - I_mc1(v_mem, v_o1)
    C_ref dv_ref/dt = [spike] I_mk4(v_ref) - I_mk5(v_ref)
    C_k dk_1/dt = I_mk6p(v_ref, k_1) - I_mk6n(v_ref, k_1)

stepped by linearly implicit Euler on each node by itself, no node moving further than `STEP` in one step.
When the spike is over, v_ref falls on by I_rfr2 alone, in closed form.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.network import amplifier, diode, stack, stack_current
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.ekv import law
from circuits.lowering.on_die import DieDevices

START = 0.5e-3  # V, ours: below the balance of the comparator, where a spike begins
FASTER = 8.0  # drive of the second spike that is run, by the first one's; ours
STEP = 2e-2  # V; ours
APPROACH = 50e-6  # V, of v_mem before the spike
_LONGEST = 20_000  # steps of one spike
_NUDGE = 1e-6  # V, of the numerical slopes

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
    capacitance: tuple[float, float, float, float]  # of v_mem, v_o1, v_ref, k1, F
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
    parts: int  # 1: up to the spike; 2: to its end


_compiled = compiled()
_allocating = compiled(_nrt=True)


@_compiled
def _channel(c: SpikeCircuit, k: int, row: int, kappa: float, gate: float, drain: float) -> float:
    """Current of a device whose source is at its bulk, A; gate, drain: V above the bulk (below, pFET)."""
    p = kappa * (gate - c.devices[row, 1, k]) / c.u_t
    return float(c.devices[row, 0, k] * (law(p)[0] - law(p - drain / c.u_t)[0]))


@_compiled
def _rate(c: SpikeCircuit, k: int, node: int, v: F64) -> float:
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
    return float(into / c.capacitance[node])


@_compiled
def _adaptation(c: SpikeCircuit, k: int, v_o1: float) -> float:
    """What ma1 and ma2 give with v_o1 on ma1's gate, A."""
    p1 = c.kappa_p * (c.v_dd - v_o1 - c.devices[MA1, 1, k]) / c.u_t
    p2 = c.kappa_p * (c.ahw[k] - c.devices[MA2, 1, k]) / c.u_t
    return float(stack_current(c.devices[MA1, 0, k], p1, c.devices[MA2, 0, k], p2, 0.6 * c.v_dd / c.u_t))


@_allocating
def spikes_of(c: SpikeCircuit, delay: F64, held: F64, peak: F64, charge: F64) -> None:
    """Run the spike of every neuron, and fill what it comes to, float64[n] each.

    delay: from `start` to the spike, s; held: from there to its end, s; peak: v_ref then, V; charge: what the
    adaptation's pair gets above its rest, C.
    """
    v, rate, slope = np.empty(4), np.empty(4), np.empty(4)
    for k in range(c.start.size):
        v[0], v[1], v[2], v[3] = c.start[k], c.v_dd - c.start_drop[k], 0.0, c.v_dd
        quiet = _adaptation(c, k, c.v_dd)
        now, spiked = 0.0, -1.0
        charge[k] = 0.0
        for _ in range(_LONGEST):
            h = 1e-5
            for i in range(4):
                rate[i] = _rate(c, k, i, v)
                kept = v[i]
                v[i] = kept + _NUDGE
                slope[i] = min((_rate(c, k, i, v) - rate[i]) / _NUDGE, 0.0)
                v[i] = kept
                # so that |h rate / (1 - h slope)| <= STEP
                most = APPROACH if i == 0 and spiked < 0.0 else STEP
                room = abs(rate[i]) + most * slope[i]
                if room > 0.0:
                    h = min(h, most / room)
            before = v[1]
            for i in range(4):
                v[i] += h * rate[i] / (1.0 - h * slope[i])
            charge[k] += h * (_adaptation(c, k, 0.5 * (before + v[1])) - quiet)
            now += h
            if spiked < 0.0 and v[1] < c.spike_threshold[k]:
                spiked = now
            if spiked >= 0.0 and c.parts == 1:
                break
            if spiked >= 0.0 and v[3] < c.reset_threshold[k] and v[1] > 0.99 * c.v_dd:
                break
        delay[k], held[k], peak[k] = max(spiked, 0.0), now - max(spiked, 0.0), v[2]


class Spikes(NamedTuple):
    """Spike of each neuron: how late it comes (s), how long the reset lasts (s), what adaptation gets (C)."""

    delay: F64
    exponent: F64  # of the delay, over the speed of v_mem
    refractory: F64
    charge: F64


def run_spikes(d: DieDevices, c: F64, fixed: float, drive: F64, top: F64) -> Spikes:
    """Run every neuron's spike to the end of its reset.

    d: devices; c: capacitances of the nodes, F; fixed: of the membrane, F; drive: current into v_mem, A; top:
    v_mem where the spike begins, V.
    """
    n, u_t = d.copies, d.u_t
    names = ("mc1", "mc2", "mc4", "mk4", "mk5", "mk6p", "mk6n", "mk8")
    fets = [*(d.fet[f"reset.{name}"] for name in names), d.fet["adaptation.ma1"], d.fet["adaptation.ma2"]]
    flat = [np.broadcast_to(x, n).copy() for x in (d.below("v_buf"), d.gate["v_rfr2"], d.below("v_ahw"))]
    mk1, mk3 = d.fet["reset.mk1"], np.broadcast_to(d.pinch("reset.mk3", d.gate["v_rfr1"]), n).copy()
    full = np.full(n, 0.5 * d.v_dd / u_t)
    given = [np.empty(n), np.empty(n)]
    gates = [np.empty(n), np.empty(n)]
    # what mk1 has to copy while spike is high, and mk2's off current afterwards
    for k, spike in enumerate((d.v_dd, 0.0)):
        stack(
            d.fet["reset.mk3"].current,
            mk3,
            d.fet["reset.mk2"].current,
            d.pinch("reset.mk2", spike),
            full,
            given[k],
        )
        diode(mk1.current, mk1.threshold / u_t, mk1.kappa, given[k], d.v_dd / u_t, gates[k])
    drop = np.empty(n)
    start = top - START
    amplifier(
        fets[0].current, d.pinch("reset.mc1", start), fets[1].current,
        np.broadcast_to(d.pinch("reset.mc2", d.below("v_buf")), n).copy(), d.v_dd / u_t, drop,
    )  # fmt: skip
    circuit = SpikeCircuit(
        u_t, fets[0].kappa, fets[1].kappa, d.v_dd, (fixed, c[5, 5], c[3, 3], c[6, 6]),
        np.array([[f.current, f.threshold] for f in fets]), flat[0], d.pinch("reset.mk4", gates[0] * u_t),
        flat[1], flat[2], d.inverter_threshold("reset.mc3"), d.inverter_threshold("reset.mk7"), start,
        drop * u_t, drive, 2,
    )  # fmt: skip
    delay, held, peak, charge, sooner, other = (np.empty(n) for _ in range(6))
    spikes_of(circuit._replace(drive=FASTER * drive, parts=1), sooner, held, peak, other)
    spikes_of(circuit, delay, held, peak, charge)
    off = d.saturated("reset.mk4", gates[1] * u_t)
    drawn = d.saturated("reset.mk5", d.gate["v_rfr2"]) - off
    threshold = d.inverter_threshold("reset.mk6")
    fall = np.maximum(peak - threshold, 0.0)
    drawn = np.maximum(drawn, 1e-30)
    emptied = c[3, 3] * fall / drawn
    emptied += _tail(d, c[7, 7] * d.fet["reset.mk4"].current / mk1.current, off, drawn, emptied)
    swing = d.inverter_threshold("reset.mk7") - u_t * d.pinch("reset.mk6n", threshold)
    emptied += d.inverter_lag("reset.mk6", swing, c[6, 6], drawn / c[3, 3])
    return Spikes(delay, np.log(delay / sooner) / np.log(FASTER), held + emptied, charge)


def _tail(d: DieDevices, c: F64, off: F64, drawn: F64, emptied: F64) -> F64:
    """Time for which mk1's gate, let go, still fills C_ref: its current falls as `Q / t`, s.

    Until it is I_rfr2 v_ref stays at the supply, and what comes later is drawn too. c: of the gate, F, times
    the mirror's ratio.
    """
    held = c * d.u_t / d.fet["reset.mk1"].kappa / drawn
    later = np.minimum(-np.log(-np.expm1(-off / drawn)), np.log1p(emptied / held))
    return np.asarray(held * (1.0 + later))
