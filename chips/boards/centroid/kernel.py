"""Compiled equations of the centroid board: the hold node, the follower and the low-pass behind it.

While the gates of a set S of neurons are on, the hold node and the low-pass behind it obey

    dv/dt = sum_S s_k (V_k - v) + (v_far - v) / t_leak,      dp/dt = (u - p) / t_filter

u follows v, but its amplifier slews: du/dt = (V_rail - u) / t_slew until it has caught up, V_rail the
supply or ground. All is linear with constant coefficients between the edges of the gates and the ends of
slewing, and each stretch is solved exactly.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from circuits.arrays import F64
from circuits.compiled import compiled

# Straight pieces of the proximity, s; ours: within 1 mV of the exponentials.
LONGEST = 2e-3
LONGEST_SLEWING = 0.2e-3


class Centroid(NamedTuple):
    """Numbers of a centroid board on a die.

    share: how strongly a neuron's gate pulls the hold node, 1/s, float64[neurons]; entry: look-up voltage of
    each neuron, V, float64[neurons]; far: voltage that the node leaks to, V; offset: of the output from the
    low-pass, V; leak, filter, slew: time constants of the leak, the low-pass and the slewing follower, s;
    v_dd: supply, V.
    """

    share: F64
    entry: F64
    far: float
    offset: float
    leak: float
    filter: float
    slew: float
    v_dd: float


@compiled()
def centroid_step(m: Centroid, ends: F64, y: F64, until: float) -> None:
    """Advance y exactly by one stretch, at most to `until` (s).

    y: time (s), hold node, follower and low-pass (V), overwritten; ends: when each neuron's gate goes off, s,
    float64[neurons].
    """
    now, hold, follower = y[0], y[1], y[2]
    stop = min(until, now + LONGEST)
    rate = 1.0 / m.leak
    drive = m.far / m.leak
    for k in range(ends.size):
        if ends[k] > now:
            rate += m.share[k]
            drive += m.share[k] * m.entry[k]
            stop = min(stop, ends[k])
    target = drive / rate
    after = target + (hold - target) * math.exp(-(stop - now) * rate)
    if follower == hold and _slewing(m, follower, after) <= stop - now:
        y[0], y[1], y[2] = stop, after, after
        y[3] = _filtered(m, y[3], hold, target, rate, stop - now)
        return
    stop = min(stop, now + LONGEST_SLEWING)
    after = target + (hold - target) * math.exp(-(stop - now) * rate)
    rail = m.v_dd if after > follower else 0.0
    caught = _slewing(m, follower, after)
    if caught <= stop - now:
        stop = now + caught
        after = target + (hold - target) * math.exp(-caught * rate)
        y[2] = after
    else:
        y[2] = rail + (follower - rail) * math.exp(-(stop - now) / m.slew)
    y[0], y[1] = stop, after
    y[3] = _filtered(m, y[3], follower, rail, 1.0 / m.slew, stop - now)


@compiled()
def _slewing(m: Centroid, start: float, end: float) -> float:
    """Time that the follower takes from `start` to `end` V, s."""
    rail = m.v_dd if end > start else 0.0
    return m.slew * math.log((rail - start) / (rail - end))


@compiled()
def _filtered(m: Centroid, before: float, start: float, target: float, rate: float, span: float) -> float:
    """Low-pass, V, `span` s after it was at `before` and its input at `start`, on the way to `target` V."""
    slow = math.exp(-span / m.filter)
    gain = 1.0 / (1.0 - m.filter * rate)
    return target + (before - target) * slow + (start - target) * gain * (math.exp(-span * rate) - slow)


@compiled()
def centroid_run(m: Centroid, ends: F64, y: F64, until: float, out: F64) -> int:
    """Advance y to `until` (s), or until `out` is full, and return how many vertices were written.

    out: time (s) and output voltage (V) at every vertex, float64[room, 2]; the other arguments are those of
    `centroid_step`.
    """
    n = 0
    while y[0] < until and n < out.shape[0]:
        centroid_step(m, ends, y, until)
        out[n, 0] = y[0]
        out[n, 1] = y[3] + m.offset
        n += 1
    return n
