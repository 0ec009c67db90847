"""The run of a ROLLS neuron's spike, under either law, by linearly implicit Euler on each node by itself.

Neurons are run side by side in lanes, each with its own step; what adaptation gets is summed afterwards, over
v_o1 in the middle of all steps.
"""

from __future__ import annotations

import numpy as np

from chips.rolls.neuron.spike_lanes import (
    FIRED,
    GOING,
    LANES,
    LET_GO,
    NOW,
    NUDGE,
    NUDGED,
    RATE,
    ROOM,
    SPIKED,
    V,
)
from chips.rolls.neuron.spike_nodes import SpikeCircuit, adaptation, fill_rates, take_lanes
from chips.rolls.neuron.whole_spike_nodes import (
    WholeSpike,
    fill_whole_rates,
    take_whole_lanes,
    whole_adaptation,
)
from circuits.arrays import F64
from circuits.compiled import compiled

STEP = 2e-2  # V; ours
APPROACH = 50e-6  # V, of v_mem before the spike
_LONGEST = 20_000  # steps of one spike
_FIRST = 1e-5  # s, longest step

# by which the run is compiled for either law
_Ideal = SpikeCircuit | None
_Whole = WholeSpike | None
_inlined = compiled(forceinline=True)
_allocating = compiled(_nrt=True)


@compiled()
def _fill(c: _Ideal, w: _Whole, count: int, s: F64) -> None:
    """Fill how fast the nodes move, by either law."""
    if c is not None:
        fill_rates(c, count, s)
    if w is not None:
        fill_whole_rates(w.v_dd, s)


@_allocating
def _adaptation(c: _Ideal, w: _Whole, first: int, v_o1: F64, out: F64) -> None:
    if c is not None:
        adaptation(c, first, v_o1, out)
    if w is not None:
        whole_adaptation(w, first, v_o1, out)


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
    rest, C, 0 for one part.
    """
    s, between, spent = np.zeros(ROOM), np.empty((_LONGEST + 1, LANES)), np.empty((_LONGEST + 1, LANES))
    for first in range(0, out.shape[1], LANES):
        count = min(LANES, out.shape[1] - first)
        v_dd = _begin(c, w, first, count, s)
        between[0], steps, going = v_dd, 0, count
        while going > 0 and steps < _LONGEST:
            steps += 1
            going = _moved(s, count, v_dd, parts, between[steps], spent[steps])
            _fill(c, w, count, s)
        charge = np.zeros(count)
        if parts > 1:
            given = np.empty((steps + 1, count))
            _adaptation(c, w, first, between[: steps + 1, :count].copy(), given)
            for i in range(1, steps + 1):
                for j in range(count):
                    charge[j] += spent[i, j] * (given[i, j] - given[0, j])
        for j in range(count):
            spiked = max(s[SPIKED + j], 0.0)
            out[0, first + j], out[1, first + j] = spiked, s[NOW + j] - spiked
            out[2, first + j], out[3, first + j] = s[V + 2 * LANES + j], charge[j]


@compiled()
def _begin(c: _Ideal, w: _Whole, first: int, count: int, s: F64) -> float:
    """Put neurons from `first` on where their spike begins; the supply, V."""
    if c is not None:
        take_lanes(c, first, count, s)
    if w is not None:
        take_whole_lanes(w, first, count, s)
    v_dd = 0.0
    for j in range(count):
        s[V + j], s[V + LANES + j], v_dd = _begun(c, w, first + j)
        s[V + 2 * LANES + j], s[V + 3 * LANES + j] = 0.0, v_dd
        s[FIRED + j], s[LET_GO + j] = _thresholds(c, w, first + j)
        s[NOW + j], s[SPIKED + j], s[GOING + j] = 0.0, -1.0, 1.0
    _fill(c, w, count, s)
    return v_dd


@_inlined
def _slope(s: F64, j: int, node: int) -> float:
    return float(min((s[NUDGED + node * LANES + j] - s[RATE + node * LANES + j]) / NUDGE, 0.0))


@_inlined
def _shorter(s: F64, j: int, node: int, most: float, h: float) -> float:
    """Step (s) in which a node moves by `most` (V) at most: |h rate / (1 - h slope)| <= most."""
    room = abs(s[RATE + node * LANES + j]) + most * _slope(s, j, node)
    return min(h, most / room) if room > 0.0 else h


@_inlined
def _next(s: F64, j: int, node: int, h: float) -> float:
    """A node's voltage after a step of h s."""
    moved = h * s[RATE + node * LANES + j] / (1.0 - h * _slope(s, j, node))
    return float(s[V + node * LANES + j] + moved)


@compiled()
def _moved(s: F64, count: int, v_dd: float, parts: int, between: F64, spent: F64) -> int:
    """Take a step in all lanes that go on; how many go on still.

    between, spent: v_o1 in the middle of it, V, and its length, s, 0 where a lane has ended.
    """
    going = 0
    for j in range(min(count, LANES)):
        goes = s[GOING + j] > 0.0
        h = _shorter(s, j, 0, APPROACH if s[SPIKED + j] < 0.0 else STEP, _FIRST)
        h = _shorter(s, j, 3, STEP, _shorter(s, j, 2, STEP, _shorter(s, j, 1, STEP, h)))
        h = h if goes else 0.0
        before, after = s[V + LANES + j], _next(s, j, 1, h)
        end, now = _next(s, j, 3, h), s[NOW + j] + h
        between[j], spent[j] = 0.5 * (before + after), h
        s[V + j], s[V + LANES + j] = _next(s, j, 0, h), after
        s[V + 2 * LANES + j], s[V + 3 * LANES + j] = _next(s, j, 2, h), end
        spiked = now if (s[SPIKED + j] < 0.0) & (after < s[FIRED + j]) else s[SPIKED + j]
        done = (spiked >= 0.0) & ((parts == 1) | ((end < s[LET_GO + j]) & (after > 0.99 * v_dd)))
        s[NOW + j], s[SPIKED + j], s[GOING + j] = now, spiked, 1.0 if goes & (not done) else 0.0
        going += 1 if goes & (not done) else 0
    return going
