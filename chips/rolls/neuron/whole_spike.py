"""The spike of a ROLLS neuron under the law with all its effects, as `chips.rolls.neuron.spike` has it.

Each of the four nodes that move is driven by the currents of its devices at their drains, junctions included.
I_rfr1 is what mk1 and the devices that draw from it settle to; the current that empties C_ref depends on its
voltage, so that the time is an integral over it.
"""

from __future__ import annotations

import numpy as np

from chips.rolls.lumped.whole import amplifier, coupling, diode, points_of, rows_of, series
from chips.rolls.neuron.spike import FASTER, START, Spikes, let_go, moving
from chips.rolls.neuron.spike_loop import spikes_of
from chips.rolls.neuron.whole_spike_nodes import WholeSpike
from circuits.arrays import F64
from circuits.lowering.on_die import DieDevices

POINTS = 65  # of v_ref, over which the time of its fall is summed
BEFORE = 10e-3  # V, ours: below the start of a spike, from where the slope of its drive is taken
_ROUNDS = 12  # of mk1 and what draws from it; each leaves less than a tenth of the error
_NAMES = (
    "reset.mc1", "reset.mc2", "reset.mc4", "reset.mk4", "reset.mk5", "reset.mk6p", "reset.mk6n", "reset.mk8",
    "adaptation.ma1", "adaptation.ma2",
)  # fmt: skip


def run_whole_spikes(d: DieDevices, c: F64, fixed: F64, drives: F64, top: F64) -> Spikes:
    """Run every neuron's spike to the end of its reset; as `chips.rolls.neuron.spike.run_spikes`.

    drives: current into v_mem at `BEFORE` below the start and at it, A, float64[2, n].
    """
    drive, steep = drives[1], np.log(drives[1] / drives[0]) / BEFORE
    n = d.copies
    flat = [np.broadcast_to(x, n) for x in (d.below("v_buf"), d.gate["v_rfr2"], d.below("v_ahw"))]
    charging, let_go, rfr1 = _mirrors(d)
    start, drop = top - START, np.empty((n, 1))
    amplifier(
        rows_of(d.fet["reset.mc1"]), rows_of(d.fet["reset.mc2"]), points_of(start, n, 1),
        points_of(flat[0], n, 1), d.v_dd, drop,
    )  # fmt: skip
    inverters = np.array([d.inverter_threshold(name) for name in ("reset.mc3", "reset.mk7")])
    node = moving(d, c, fixed)
    circuit = WholeSpike(
        d.v_dd, node,
        np.array([rows_of(d.fet[name]) for name in _NAMES]),
        np.array([flat[0], charging, flat[1], flat[2]]), inverters, start, drop[:, 0].copy(), drive, steep,
    )  # fmt: skip
    sooner, found = np.empty((4, n)), np.empty((4, n))
    spikes_of(None, circuit._replace(drive=FASTER * drive), 1, sooner)
    spikes_of(None, circuit, 2, found)
    delay, held, peak, charge = found
    threshold = d.inverter_threshold("reset.mk6")
    emptied = _emptied(d, node[2], (peak, threshold), let_go)
    high = 0.5 * (peak + threshold)
    off = d.current("reset.mk4", let_go, d.v_dd - high)
    drawn = np.maximum(d.current("reset.mk5", d.gate["v_rfr2"], high) - off, 1e-30)
    emptied += _tail(d, float(c[7, 7]) * rfr1, off, drawn, emptied)
    swing = inverters[1] - d.u_t * d.pinch("reset.mk6n", threshold)
    low = d.current("reset.mk5", d.gate["v_rfr2"], threshold) - d.current(
        "reset.mk4", let_go, d.v_dd - threshold
    )
    emptied += d.inverter_lag("reset.mk6", swing, node[3], np.maximum(low, 1e-30) / node[2], threshold)
    return Spikes(delay, np.log(delay / sooner[0]) / np.log(FASTER), held + emptied, charge)


def _mirrors(d: DieDevices) -> tuple[F64, F64, float]:
    """Gate of mk4 below the supply, V, while spike is high and afterwards; mk4's current over mk1's."""
    n = d.copies
    rows = [rows_of(d.fet[f"reset.{name}"]) for name in ("mk3", "mk2", "mk1")]
    found = []
    for spike in (d.v_dd, 0.0):
        gate, given = np.full((n, 1), 0.3 * d.v_dd), np.empty((n, 1))
        for _ in range(_ROUNDS):
            low, high = (points_of(x, n, 1) for x in (d.gate["v_rfr1"], spike))
            series(rows[0], rows[1], low, high, d.v_dd - gate, given)
            diode(rows[2], given, d.v_dd, gate)
        found.append(gate[:, 0].copy())
    ratio = d.fet["reset.mk4"].current / d.fet["reset.mk1"].current
    return found[0], found[1], float(ratio.mean())


def _emptied(d: DieDevices, c: F64, between: tuple[F64, F64], let_go: F64) -> F64:
    """Time in which I_rfr2 brings v_ref from the first voltage down to the second, s."""
    peak, threshold = between
    high = np.maximum(peak, threshold)
    v = threshold[:, None] + (high - threshold)[:, None] * np.linspace(0.0, 1.0, POINTS)
    over = d.columns()
    drawn = over.current("reset.mk5", over.gate["v_rfr2"], v)
    drawn = drawn - over.current("reset.mk4", let_go[:, None], d.v_dd - v)
    return np.asarray(np.trapezoid(c[:, None] / np.maximum(drawn, 1e-30), v, axis=1))


def _tail(d: DieDevices, c: float, off: F64, drawn: F64, emptied: F64) -> F64:
    """Time for which mk1's gate, let go, still fills C_ref, s; as in `chips.rolls.neuron.spike`."""
    gate = d.gate_for("reset.mk1", drawn)
    return let_go(c * d.u_t / coupling(d, "reset.mk1", gate) / drawn, off, drawn, emptied)
