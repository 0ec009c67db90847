"""The run of a ROLLS neuron's spike, under either law, by linearly implicit Euler on each node by itself."""

from __future__ import annotations

import numpy as np

from chips.rolls.neuron.spike_nodes import SpikeCircuit, adaptation, rate
from chips.rolls.neuron.whole_spike_nodes import WholeSpike, whole_adaptation, whole_rate
from circuits.arrays import F64
from circuits.compiled import compiled

STEP = 2e-2  # V; ours
APPROACH = 50e-6  # V, of v_mem before the spike
_LONGEST = 20_000  # steps of one spike
_NUDGE = 1e-6  # V, of the numerical slopes

# by which the run is compiled for either law
_Ideal = SpikeCircuit | None
_Whole = WholeSpike | None
_inlined = compiled(forceinline=True)
_allocating = compiled(_nrt=True)


@_inlined
def _rate(c: _Ideal, w: _Whole, k: int, node: int, v: F64) -> float:
    if c is not None:
        return rate(c, k, node, v)
    if w is not None:
        return whole_rate(w, k, node, v)
    return 0.0


@_inlined
def _adaptation(c: _Ideal, w: _Whole, k: int, v_o1: float) -> float:
    if c is not None:
        return adaptation(c, k, v_o1)
    if w is not None:
        return whole_adaptation(w, k, v_o1)
    return 0.0


@_inlined
def _begun(c: _Ideal, w: _Whole, k: int) -> tuple[float, float, float]:
    """v_mem and v_o1 where the spike begins, and the supply, V."""
    if c is not None:
        return c.start[k], c.v_dd - c.start_drop[k], c.v_dd
    if w is not None:
        return w.start[k], w.v_dd - w.start_drop[k], w.v_dd
    return 0.0, 0.0, 0.0


@_inlined
def _thresholds(c: _Ideal, w: _Whole, k: int) -> tuple[float, float]:
    """Thresholds of the inverters behind v_o1 and k1, V."""
    if c is not None:
        return c.spike_threshold[k], c.reset_threshold[k]
    if w is not None:
        return w.thresholds[0, k], w.thresholds[1, k]
    return 0.0, 0.0


@_allocating
def spikes_of(c: _Ideal, w: _Whole, parts: int, out: F64) -> None:
    """Run the spike of every neuron, and fill what it comes to, float64[4, n].

    c, w: the neurons, of which one is None; parts: 1 up to the spike, 2 to its end; out: delay from `start`
    to the spike, s; from there to its end, s; v_ref then, V; charge that the adaptation's pair gets above its
    rest, C.
    """
    v, rates, slope = np.empty(4), np.empty(4), np.empty(4)
    for k in range(out.shape[1]):
        begin, low, v_dd = _begun(c, w, k)
        fired, let_go = _thresholds(c, w, k)
        v[0], v[1], v[2], v[3] = begin, low, 0.0, v_dd
        quiet = _adaptation(c, w, k, v_dd)
        now, spiked, charge = 0.0, -1.0, 0.0
        for _ in range(_LONGEST):
            h = 1e-5
            for i in range(4):
                rates[i] = _rate(c, w, k, i, v)
                kept = v[i]
                v[i] = kept + _NUDGE
                slope[i] = min((_rate(c, w, k, i, v) - rates[i]) / _NUDGE, 0.0)
                v[i] = kept
                # so that |h rate / (1 - h slope)| <= STEP
                most = APPROACH if i == 0 and spiked < 0.0 else STEP
                room = abs(rates[i]) + most * slope[i]
                if room > 0.0:
                    h = min(h, most / room)
            before = v[1]
            for i in range(4):
                v[i] += h * rates[i] / (1.0 - h * slope[i])
            charge += h * (_adaptation(c, w, k, 0.5 * (before + v[1])) - quiet)
            now += h
            if spiked < 0.0 and v[1] < fired:
                spiked = now
            if spiked >= 0.0 and parts == 1:
                break
            if spiked >= 0.0 and v[3] < let_go and v[1] > 0.99 * v_dd:
                break
        out[0, k], out[1, k] = max(spiked, 0.0), now - max(spiked, 0.0)
        out[2, k], out[3, k] = v[2], charge
