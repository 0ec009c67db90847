"""The spike of a ROLLS neuron under the law with all its effects, as `chips.rolls.neuron.spike` has it.

Each of the four nodes that move is driven by the currents of its devices at their drains, junctions included.
I_rfr1 is what mk1 and the devices that draw from it settle to; the current that empties C_ref depends on its
voltage, so that the time is an integral over it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.rolls.lumped.whole import (
    amplifier,
    coupling,
    diode,
    points_of,
    rows_of,
    series,
    series_current,
    terms_at,
)
from chips.rolls.neuron.spike import APPROACH, FASTER, START, STEP, Spikes
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.channel import Terms, channel, leaked
from circuits.lowering.on_die import DieDevices

POINTS = 65  # of v_ref, over which the time of its fall is summed
BEFORE = 10e-3  # V, ours: below the start of a spike, from where the slope of its drive is taken
STEEPEST = 4.0  # e-folds, ours: of a drive in a spike, beyond which mc4 and the reset are all that counts
_LONGEST = 20_000  # steps of one spike
_NUDGE = 1e-6  # V, of the numerical slopes
_ROUNDS = 12  # of mk1 and what draws from it; each leaves less than a tenth of the error
_NAMES = (
    "reset.mc1", "reset.mc2", "reset.mc4", "reset.mk4", "reset.mk5", "reset.mk6p", "reset.mk6n", "reset.mk8",
    "adaptation.ma1", "adaptation.ma2",
)  # fmt: skip
MC1, MC2, MC4, MK4, MK5, MK6P, MK6N, MK8, MA1, MA2 = range(10)


class WholeSpike(NamedTuple):
    """The nodes that move in a spike, of n neurons, float64[n] unless said.

    rows: of the devices in the order above, float64[10, TERMS, n]; gates: V, of mc2, mk4, mk5 and ma2, each
    from its bulk, float64[4, n]; thresholds: of the inverters behind v_o1 and k1, V, float64[2, n].
    """

    v_dd: float
    capacitance: tuple[float, float, float, float]  # of v_mem, v_o1, v_ref, k1, F
    rows: F64
    gates: F64
    thresholds: F64
    start: F64  # V, of v_mem
    start_drop: F64  # V, of v_o1 below the supply
    drive: F64  # A, into v_mem at the start
    steep: F64  # 1/V, of the drive's logarithm over v_mem
    parts: int  # 1: up to the spike; 2: to its end


_compiled = compiled()
_allocating = compiled(_nrt=True)


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
    return float(into / c.capacitance[node])


@_compiled
def _adaptation(c: WholeSpike, k: int, v_o1: float) -> float:
    """What ma1 and ma2 give with v_o1 on ma1's gate, A."""
    lower, upper = terms_at(c.rows[MA1], k), terms_at(c.rows[MA2], k)
    return float(series_current(lower, upper, c.v_dd - v_o1, c.gates[3, k], 0.6 * c.v_dd))


@_allocating
def spikes_of(c: WholeSpike, out: F64) -> None:
    """Run the spike of every neuron, and fill what it comes to, float64[4, n].

    Delay from `start` to the spike, s; from there to its end, s; v_ref then, V; charge that the adaptation's
    pair gets above its rest, C.
    """
    v, rate, slope = np.empty(4), np.empty(4), np.empty(4)
    for k in range(c.start.size):
        v[0], v[1], v[2], v[3] = c.start[k], c.v_dd - c.start_drop[k], 0.0, c.v_dd
        quiet = _adaptation(c, k, c.v_dd)
        now, spiked, charge = 0.0, -1.0, 0.0
        for _ in range(_LONGEST):
            h = 1e-5
            for i in range(4):
                rate[i] = _rate(c, k, i, v)
                kept = v[i]
                v[i] = kept + _NUDGE
                slope[i] = min((_rate(c, k, i, v) - rate[i]) / _NUDGE, 0.0)
                v[i] = kept
                most = APPROACH if i == 0 and spiked < 0.0 else STEP
                room = abs(rate[i]) + most * slope[i]
                if room > 0.0:
                    h = min(h, most / room)
            before = v[1]
            for i in range(4):
                v[i] += h * rate[i] / (1.0 - h * slope[i])
            charge += h * (_adaptation(c, k, 0.5 * (before + v[1])) - quiet)
            now += h
            if spiked < 0.0 and v[1] < c.thresholds[0, k]:
                spiked = now
            if spiked >= 0.0 and c.parts == 1:
                break
            if spiked >= 0.0 and v[3] < c.thresholds[1, k] and v[1] > 0.99 * c.v_dd:
                break
        out[0, k], out[1, k] = max(spiked, 0.0), now - max(spiked, 0.0)
        out[2, k], out[3, k] = v[2], charge


def run_whole_spikes(d: DieDevices, c: F64, fixed: float, drives: F64, top: F64) -> Spikes:
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
    circuit = WholeSpike(
        d.v_dd, (fixed, float(c[5, 5]), float(c[3, 3]), float(c[6, 6])),
        np.array([rows_of(d.fet[name]) for name in _NAMES]),
        np.array([flat[0], charging, flat[1], flat[2]]), inverters, start, drop[:, 0].copy(), drive, steep, 2,
    )  # fmt: skip
    sooner, found = np.empty((4, n)), np.empty((4, n))
    spikes_of(circuit._replace(drive=FASTER * drive, parts=1), sooner)
    spikes_of(circuit, found)
    delay, held, peak, charge = found
    threshold = d.inverter_threshold("reset.mk6")
    emptied = _emptied(d, float(c[3, 3]), (peak, threshold), let_go)
    high = 0.5 * (peak + threshold)
    off = d.current("reset.mk4", let_go, d.v_dd - high)
    drawn = np.maximum(d.current("reset.mk5", d.gate["v_rfr2"], high) - off, 1e-30)
    emptied += _tail(d, float(c[7, 7]) * rfr1, off, drawn, emptied)
    swing = d.inverter_threshold("reset.mk7") - d.u_t * d.pinch("reset.mk6n", threshold)
    low = d.current("reset.mk5", d.gate["v_rfr2"], threshold) - d.current(
        "reset.mk4", let_go, d.v_dd - threshold
    )
    emptied += d.inverter_lag("reset.mk6", swing, float(c[6, 6]), np.maximum(low, 1e-30) / c[3, 3])
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


def _emptied(d: DieDevices, c: float, between: tuple[F64, F64], let_go: F64) -> F64:
    """Time in which I_rfr2 brings v_ref from the first voltage down to the second, s."""
    peak, threshold = between
    high = np.maximum(peak, threshold)
    v = threshold[:, None] + (high - threshold)[:, None] * np.linspace(0.0, 1.0, POINTS)
    over = d.columns()
    drawn = over.current("reset.mk5", over.gate["v_rfr2"], v)
    drawn = drawn - over.current("reset.mk4", let_go[:, None], d.v_dd - v)
    return np.asarray(np.trapezoid(c / np.maximum(drawn, 1e-30), v, axis=1))


def _tail(d: DieDevices, c: float, off: F64, drawn: F64, emptied: F64) -> F64:
    """Time for which mk1's gate, let go, still fills C_ref, s; as in `chips.rolls.neuron.spike`."""
    gate = d.gate_for("reset.mk1", drawn)
    held = c * d.u_t / coupling(d, "reset.mk1", gate) / drawn
    later = np.minimum(-np.log(-np.expm1(-off / drawn)), np.log1p(emptied / held))
    return np.asarray(held * (1.0 + later))
