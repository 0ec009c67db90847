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

from chips.rolls.lumped.network import amplifier, diode, stack
from chips.rolls.neuron.spike_loop import spikes_of
from chips.rolls.neuron.spike_nodes import SpikeCircuit
from circuits.arrays import F64
from circuits.lowering.on_die import DieDevices

START = 0.5e-3  # V, ours: below the balance of the comparator, where a spike begins
FASTER = 8.0  # drive of the second spike that is run, by the first one's; ours


class Spikes(NamedTuple):
    """Spike of each neuron: how late it comes (s), how long the reset lasts (s), what adaptation gets (C)."""

    delay: F64
    exponent: F64  # of the delay, over the speed of v_mem
    refractory: F64
    charge: F64


def run_spikes(d: DieDevices, c: F64, fixed: F64, drive: F64, top: F64) -> Spikes:
    """Run every neuron's spike to the end of its reset.

    d: devices; c: capacitances of the nodes as drawn, F; fixed: of the membrane, F, float64[n]; drive:
    current into v_mem, A; top: v_mem where the spike begins, V.
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
    node = moving(d, c, fixed)
    circuit = SpikeCircuit(
        u_t, fets[0].kappa, fets[1].kappa, d.v_dd, node,
        np.array([[f.current, f.threshold] for f in fets]), flat[0], d.pinch("reset.mk4", gates[0] * u_t),
        flat[1], flat[2], d.inverter_threshold("reset.mc3"), d.inverter_threshold("reset.mk7"), start,
        drop * u_t, drive,
    )  # fmt: skip
    first, found = np.empty((4, n)), np.empty((4, n))
    spikes_of(circuit._replace(drive=FASTER * drive), None, 1, first)
    spikes_of(circuit, None, 2, found)
    sooner, (delay, held, peak, charge) = first[0], found
    off = d.saturated("reset.mk4", gates[1] * u_t)
    drawn = d.saturated("reset.mk5", d.gate["v_rfr2"]) - off
    threshold = d.inverter_threshold("reset.mk6")
    fall = np.maximum(peak - threshold, 0.0)
    drawn = np.maximum(drawn, 1e-30)
    emptied = node[2] * fall / drawn
    emptied += _tail(d, c[7, 7] * d.fet["reset.mk4"].current / mk1.current, off, drawn, emptied)
    swing = d.inverter_threshold("reset.mk7") - u_t * d.pinch("reset.mk6n", threshold)
    emptied += d.inverter_lag("reset.mk6", swing, node[3], drawn / node[2])
    return Spikes(delay, np.log(delay / sooner) / np.log(FASTER), held + emptied, charge)


def moving(d: DieDevices, c: F64, membrane: F64) -> F64:
    """Return the capacitances of v_mem, v_o1, v_ref and k1, F, float64[4, n].

    c: of all nodes as drawn, F; membrane: of v_mem, F, float64[n].
    """
    rest = (c[5, 5], c[3, 3] + d.added("reset.c_ref"), c[6, 6] + d.added("reset.c_k"))
    return np.array([membrane, *(np.broadcast_to(x, d.copies) for x in rest)])


def _tail(d: DieDevices, c: F64, off: F64, drawn: F64, emptied: F64) -> F64:
    """Time for which mk1's gate, let go, still fills C_ref: its current falls as `Q / t`, s.

    Until it is I_rfr2 v_ref stays at the supply, and what comes later is drawn too. c: of the gate, F, times
    the mirror's ratio.
    """
    return let_go(c * d.u_t / d.fet["reset.mk1"].kappa / drawn, off, drawn, emptied)


def let_go(held: F64, off: F64, drawn: F64, emptied: F64) -> F64:
    """Return for how long what a gate holds still fills C_ref after it was let go, s.

    held: its charge an e-fold of the current, over what is drawn, s; off: the current that stays, A; drawn:
    what empties C_ref, A; emptied: the time that this takes, s; float64[n] each.
    """
    later = np.minimum(-np.log(-np.expm1(-off / drawn)), np.log1p(emptied / held))
    return np.asarray(held * (1.0 + later))
