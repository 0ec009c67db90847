"""Compiled equations of the boards' and the hearing's behavioural models.

Centroid: while the gates of a set S of neurons are on, the hold node and the low-pass behind it obey

    dv/dt = sum_S s_k (V_k - v) + (v_far - v) / t_leak,      dp/dt = (u - p) / t_filter

u follows v, but its amplifier slews: du/dt = (V_rail - u) / t_slew until it has caught up, V_rail the
supply or ground. All is linear with constant coefficients between the edges of the gates and the ends of
slewing, and each stretch is solved exactly.

Vocalization: from the end of a call's dead time the phase grows as `a + b p` with the proximity voltage p;
the next call comes when it reaches one, solved exactly where p is a straight line.

Hearing: a sound of peak A at the microphone, onset t, makes one spike at `t + latency(A)` where A is above
the threshold and `t - t_i >= recovery(A_i, A)` for every earlier sound above it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled

# Straight pieces of the proximity, s; ours: within 1 mV of the exponentials.
LONGEST = 2e-3
LONGEST_SLEWING = 0.2e-3
EVENT_WIDTH = 10.1e-6  # s, an event's pulse at half the supply
SOUND_DURATION = 1e-3  # s, of the sounds that were measured
MEMORY = 20e-3  # s, longer than any recovery: what is kept of the past; ours
UNSURE = 0.05  # share of a threshold or a recovery within which hearing does not decide; ours


class Centroid(NamedTuple):
    """A centroid board: share, entry: float64[neurons], 1/s and V; far, offset: V; leak, filter, slew: s."""

    share: F64
    entry: F64
    far: float
    offset: float
    leak: float
    filter: float
    slew: float
    v_dd: float


class Vocalization(NamedTuple):
    """base: 1/s; slope: 1/(V s); dead: s; first: phase lacking before the first call; amplitude: V, V/V."""

    base: float
    slope: float
    dead: float
    first: float
    amplitude_base: float
    amplitude_slope: float
    v_dd: float


class Hearing(NamedTuple):
    """One neuron's hearing: threshold V; knots ln(A / threshold) of latency (s); ln A of recovery (s)."""

    threshold: float
    knots: F64
    latency: F64
    recovery_knots: F64
    recovery: F64  # float64[first sound, second sound]


@compiled()
def centroid_step(m: Centroid, ends: F64, y: F64, until: float) -> None:
    """Advance y = (time, hold, follower, filtered) exactly by one stretch, at most to `until` (s).

    ends: float64[neurons], s, when each gate goes off.
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
    """Advance to `until` (s); out: float64[room, 2], time and proximity at every vertex. Returns how many.

    It stops early where there is no more room.
    """
    n = 0
    while y[0] < until and n < out.shape[0]:
        centroid_step(m, ends, y, until)
        out[n, 0] = y[0]
        out[n, 1] = y[3] + m.offset
        n += 1
    return n


@compiled()
def crossing(rate: float, bend: float, missing: float) -> float:
    """Smallest t >= 0 at which `rate t + bend t^2 / 2` reaches `missing`; inf where it never does."""
    under = rate * rate + 2.0 * bend * missing
    if under < 0.0:
        return np.inf
    below = rate + math.sqrt(under)
    time: float = 2.0 * missing / below if below > 0.0 else np.inf
    return time


@compiled()
def vocalization_line(m: Vocalization, y: F64, start: float, stop: float, first: float, last: float) -> float:
    """Advance y = (phase, free from s) along a straight proximity, V, from start to stop (s).

    Returns the time of the call that it meets, and has then begun the next interval; else inf.
    """
    slope = (last - first) / (stop - start)
    begin = max(start, y[1])
    if begin >= stop:
        return np.inf
    rate = m.base + m.slope * (first + slope * (begin - start))
    bend = m.slope * slope
    wait = crossing(rate, bend, 1.0 - y[0])
    if begin + wait <= stop:
        y[0], y[1] = 0.0, begin + wait + m.dead
        call: float = begin + wait
        return call
    span = stop - begin
    y[0] += rate * span + 0.5 * bend * span * span
    return np.inf


@compiled()
def vocalization_run(m: Vocalization, y: F64, time: F64, value: F64, start: float, until: float) -> float:
    """Advance along a polyline, held beyond its ends, to `until` (s) or to a call: its time, or inf."""
    now = start
    k = 0
    while now < until:
        while k < time.size and time[k] <= now:
            k += 1
        stop = min(until, time[k]) if k < time.size else until
        call = vocalization_line(m, y, now, stop, _value(time, value, k, now), _value(time, value, k, stop))
        if call < np.inf:
            return call
        now = stop
    return np.inf


@compiled()
def _value(time: F64, value: F64, k: int, t: float) -> float:
    if k == 0:
        return float(value[0])
    if k == time.size:
        return float(value[k - 1])
    return float(value[k - 1] + (value[k] - value[k - 1]) * (t - time[k - 1]) / (time[k] - time[k - 1]))


@compiled()
def amplitude_at(m: Vocalization, control: float) -> float:
    """Call amplitude, V, at a control voltage (V)."""
    return min(max(m.amplitude_base + m.amplitude_slope * control, 0.0), m.v_dd)


@compiled()
def table_at(knots: F64, table: F64, x: float) -> float:
    """Straight lines through a table, held beyond its ends."""
    n = knots.size
    if x <= knots[0]:
        return float(table[0])
    for k in range(1, n):
        if x < knots[k]:
            share = (x - knots[k - 1]) / (knots[k] - knots[k - 1])
            return float(table[k - 1] + share * (table[k] - table[k - 1]))
    return float(table[n - 1])


@compiled()
def _recovery(m: Hearing, first: float, second: float) -> float:
    x = math.log(first)
    knots = m.recovery_knots
    k = 1
    while k < knots.size - 1 and x > knots[k]:
        k += 1
    share = min(max((x - knots[k - 1]) / (knots[k] - knots[k - 1]), 0.0), 1.0)
    y = math.log(second)
    low, high = table_at(knots, m.recovery[k - 1], y), table_at(knots, m.recovery[k], y)
    between: float = (1.0 - share) * low + share * high
    return between


@compiled()
def monotone_cubic(knots: F64, table: F64, x: float, out: F64) -> None:
    """Monotone cubics (Fritsch & Butland 1984) through the columns of a table, at x, beyond the ends too.

    knots: float64[points], rising, at least three; table: float64[points, columns]; out: float64[columns].
    """
    last = knots.size - 1
    k = 0
    while k < last - 1 and x >= knots[k + 1]:
        k += 1
    h = knots[k + 1] - knots[k]
    z = (x - knots[k]) / h
    w = 1.0 - z
    for j in range(out.size):
        a, b = table[k, j], table[k + 1, j]
        slopes = h * (w * _slope(knots, table, k, j) - z * _slope(knots, table, k + 1, j))
        out[j] = a * w * w * (1.0 + 2.0 * z) + b * z * z * (3.0 - 2.0 * z) + z * w * slopes


@compiled()
def _slope(knots: F64, table: F64, k: int, j: int) -> float:
    """Slope at knot k: weighted harmonic mean of both neighbours', 0 at an extremum."""
    last = knots.size - 1
    if k == 0:
        return _end_slope(knots, table, 0, 1, 2, j)
    if k == last:
        return _end_slope(knots, table, last, last - 1, last - 2, j)
    before, after = knots[k] - knots[k - 1], knots[k + 1] - knots[k]
    left, right = (table[k, j] - table[k - 1, j]) / before, (table[k + 1, j] - table[k, j]) / after
    if left * right <= 0.0:
        return 0.0
    one, other = 2.0 * after + before, after + 2.0 * before
    return float((one + other) / (one / left + other / right))


@compiled()
def _end_slope(knots: F64, table: F64, end: int, next_: int, third: int, j: int) -> float:
    """One-sided slope of the parabola through the last three points, kept from overshooting."""
    near, far = knots[next_] - knots[end], knots[third] - knots[next_]
    first, second = (table[next_, j] - table[end, j]) / near, (table[third, j] - table[next_, j]) / far
    slope = ((2.0 * near + far) * first - near * second) / (near + far)
    if slope * first <= 0.0:
        return 0.0
    if first * second <= 0.0 and abs(slope) > 3.0 * abs(first):
        return float(3.0 * first)
    return float(slope)


@compiled()
def hears(m: Hearing, sounds: F64, count: int) -> tuple[float, bool]:
    """Spike time (s, inf for none) of the last of `count` sounds, and whether that was too near to call.

    sounds: float64[room, 2], onset (s) and peak at the microphone (V), in order of their onsets.
    """
    onset, peak = sounds[count - 1, 0], sounds[count - 1, 1]
    unsure = abs(peak - m.threshold) < UNSURE * m.threshold
    if peak < m.threshold:
        return np.inf, unsure
    fires = True
    for i in range(count - 1):
        if sounds[i, 1] < m.threshold:
            continue
        gap = onset - sounds[i, 0]
        needed = _recovery(m, sounds[i, 1], peak)
        unsure = unsure or abs(gap - needed) < UNSURE * needed
        fires = fires and gap >= needed
    if not fires:
        return np.inf, unsure
    return onset + table_at(m.knots, m.latency, math.log(peak / m.threshold)), unsure


@compiled()
def hear_sound(onset: Hearing, high: Hearing, sounds: F64, count: int) -> tuple[float, float, bool]:
    """What both neurons make of the last of `count` sounds, as `hears` has it.

    Returns the spike times of the onset and of the high-threshold neuron (s, inf for none), and whether one
    was too near to call or the sound overlaps another one, whose phase is not known.
    """
    first = count - 1
    while first > 0 and sounds[first - 1, 0] > sounds[count - 1, 0] - MEMORY:
        first -= 1
    known = sounds[first:count]
    last = known.shape[0] - 1
    unsure = False
    for i in range(last):
        overlaps = known[last, 0] - known[i, 0] < SOUND_DURATION
        unsure = unsure or (overlaps and min(known[i, 1], known[last, 1]) >= onset.threshold)
    one, near_one = hears(onset, known, last + 1)
    other, near_other = hears(high, known, last + 1)
    return one, other, unsure or near_one or near_other
