"""Compiled steps of a ROLLS chip's plastic array; nothing is done to a weight between its events.

At an event of a synapse, at the beginning of a step, its weight w (V) first drifts for the time since its
last one, up to the rail or, where leaks are above the drift, to its threshold:

    w > w_threshold:  w += rate_up t,    else  w -= rate_down t

with the rates that hold at the event: while a neuron lets its weights move, their shut stacks leak more.
If it is high, `z` of the neuron's slow filter grows by the charge that the synapse draws. Then w moves up or
down by a constant where the neuron's two lines say so:

    up   = (v_mem > v_memthr) and over[LEAST] and not over[MOST_UP]
    down = (v_mem < v_memthr) and over[LEAST] and not over[MOST_DOWN]

over[k] is a node that the k-th copy of the calcium's current charges and its threshold's empties, and that
counts as high above the threshold of the inverter behind it: picoamperes take milliseconds. The slow filter
and the calcium's are filters like the others (`chips.rolls.synapse.step`); what the slow one puts out passes
the NMDA gate, by a table over the membrane.
"""

from __future__ import annotations

import numpy as np

from chips.rolls.layout import (
    BASE,
    LAST,
    NEVER,
    ONE,
    SHIFT,
    SHUT,
    WAIT,
    ZERO,
    ZETA,
    Traffic,
    step_compiled,
    step_inlined,
)
from chips.rolls.plastic.layout import (
    CALCIUM,
    LEAST,
    MOST_DOWN,
    MOST_UP,
    NODES,
    OVER,
    SLOW,
    Plastic,
    PlasticTables,
)
from chips.rolls.synapse.step import step_filters
from circuits.arrays import F32, F64, I64


@step_inlined
def _allowed(p: Plastic, state: F64) -> None:
    """Which neurons let their weights go up, and down, as 1 or 0, from the state of a chip."""
    c, over, s = p.tables, p.arrays.filters, p.scratch
    for k in range(s.up.size):
        # from a sure spike until it comes v_mem is above, then it is held at ground
        released = state[WAIT, k] <= 0.0
        above = state[ZETA, k] > c.membrane[k] if released else state[SHUT, k] < NEVER
        enough = over[OVER + LEAST, k] > c.passed[LEAST, k]
        up = enough & above & (over[OVER + MOST_UP, k] < c.passed[MOST_UP, k])
        down = enough & (not above) & (over[OVER + MOST_DOWN, k] < c.passed[MOST_DOWN, k])
        s.up[k] = ONE if up else ZERO
        s.down[k] = ONE if down else ZERO
        s.lift[k] = s.up[k] * c.active[0] - s.down[k] * c.active[1]


@step_inlined
def _drifted(
    w: np.float32, rise: np.float32, fall: np.float32, middle: np.float32, supply: np.float32
) -> np.float32:
    """A weight after drifts `rise` and `fall`, V, whichever holds."""
    high = min(max(w + rise, middle), supply)
    low = max(min(w - fall, middle), ZERO)
    return high if w > middle else low


@step_inlined
def _moved(effect: F32 | None, w: np.float32, up: np.float32, down: np.float32) -> np.float32:
    """By how much a weight at w moves, V; up, down: at the voltage of `effect`."""
    if effect is None:
        return up - down
    over = w - effect[2]
    return np.float32(up * (ONE - effect[0] * over) - down * (ONE + effect[1] * over))


@step_inlined
def _charged(
    soft: F32 | None, brought: np.float32, threshold: np.float32, charging: np.float32, over: np.float32
) -> np.float32:
    """By how much a node moves in a step, V; over: where it is above its inverter's threshold, V.

    Under the full law the copy brings less, and the threshold takes more, the higher the node is; the step is
    implicit in that.
    """
    if soft is None:
        return np.float32((brought - threshold) * charging)
    net = brought * (ONE - soft[0] * over) - threshold * (ONE + soft[1] * over)
    return np.float32(net * charging / (ONE + charging * (brought * soft[0] + threshold * soft[1])))


@step_inlined
def _column(p: Plastic, pre: int) -> None:
    """An event of every synapse of a column."""
    c, a, s = p.tables, p.arrays, p.scratch
    now, supply = np.int32(a.clock[0]), c.supply[0]
    brought = s.filters.charge[SLOW]
    w, seen = a.weights[pre], a.seen[pre]
    up, down, middle, charge = c.up[pre], c.down[pre], c.middle[pre], c.charge[pre]
    rise, fall = c.rise[pre], c.fall[pre]
    for k in range(w.size):
        gone = np.float32(now - seen[k])
        lift = s.lift[k]
        x = _drifted(w[k], gone * (rise[k] + lift), gone * (fall[k] - lift), middle[k], supply)
        brought[k] += charge[k] if x > middle[k] else ZERO
        x += _moved(c.effect, x, s.up[k] * up[k], s.down[k] * down[k])
        w[k] = min(max(x, ZERO), supply)
        seen[k] = now


@step_inlined
def _synapse(p: Plastic, pre: int, k: int) -> None:
    """An event of one synapse."""
    c, a, s = p.tables, p.arrays, p.scratch
    gone, supply, middle = np.float32(a.clock[0] - a.seen[pre, k]), c.supply[0], c.middle[pre, k]
    rise, fall = c.rise[pre, k] + s.lift[k], c.fall[pre, k] - s.lift[k]
    x = _drifted(a.weights[pre, k], gone * rise, gone * fall, middle, supply)
    s.filters.charge[SLOW, k] += c.charge[pre, k] if x > middle else ZERO
    x += _moved(c.effect, x, s.up[k] * c.up[pre, k], s.down[k] * c.down[pre, k])
    a.weights[pre, k] = min(max(x, ZERO), supply)
    a.seen[pre, k] = np.int32(a.clock[0])


@step_compiled
def deliver_plastic(p: Plastic, state: F64, t: Traffic, until: float) -> None:
    """Deliver the last step's spikes, and the events before `until` s, to the plastic array and the calcium.

    state: of the chip, float64[STATE_ROWS, n].
    """
    e, read, calcium = p.events, p.arrays.read, p.scratch.filters.charge[CALCIUM]
    _allowed(p, state)
    for j in range(t.counts[LAST]):
        _column(p, t.last[j])
        calcium[t.last[j]] += p.tables.spike[t.last[j]]
    while read[0] < e.times.size and e.times[read[0]] < until:
        _synapse(p, e.columns[read[0]], e.neurons[read[0]])
        read[0] += 1


@step_compiled
def step_plastic(p: Plastic, state: F64, bits: I64, step: float, excite: F32) -> None:
    """Step the slow filters, whose currents are added to `excite` (A), the calcium and its nodes.

    state: of the chip; bits: its row of zeta, as int64. A membrane that is held is at ground.
    """
    c, a, s = p.tables, p.arrays, p.scratch
    output, calcium = s.output, s.calcium
    for k in range(output.size):
        output[k] = -c.silent[k]
        calcium[k] = ZERO
    a.held[0] += step_filters(a.filters, np.int64(SLOW), c.omega[SLOW], c.banks[0], step, output, s.filters)
    a.held[0] += step_filters(
        a.filters, np.int64(CALCIUM), c.omega[CALCIUM], c.banks[1], step, calcium, s.filters
    )
    for k in range(output.size):
        released = state[WAIT, k] <= 0.0
        row = c.share[k, np.uint64((bits[k] >> SHIFT) - BASE if released else 0)]
        zeta = np.float32(state[ZETA, k]) if released else ONE
        excite[k] += output[k] * (row[0] + zeta * row[1])
    for j in range(NODES):
        for k in range(calcium.size):
            moved = _charged(
                c.soft, calcium[k] * c.ratio[j, k], c.threshold[j, k], c.charging[j, k],
                np.float32(a.filters[OVER + j, k]) - c.passed[j, k],
            )  # fmt: skip
            a.filters[OVER + j, k] = min(max(a.filters[OVER + j, k] + moved, ZERO), c.supply[0])
    a.clock[0] += 1


@step_compiled
def settle_weights(c: PlasticTables, weights: F32, steps: F32, lift: F32) -> None:
    """Let all weights drift for `steps`, float32[pre, post]; lift: as in `PlasticScratch`, float32[n]."""
    for j in range(weights.shape[0]):
        for k in range(weights.shape[1]):
            n, more = steps[j, k], lift[k]
            weights[j, k] = _drifted(
                weights[j, k],
                n * (c.rise[j, k] + more),
                n * (c.fall[j, k] - more),
                c.middle[j, k],
                c.supply[0],
            )
