"""Compiled equations of the hearing: whether, and when, a neuron spikes for a sound.

A sound of peak A at the microphone, onset t, makes one spike at `t + latency(A)` where A is above the
threshold and `t - t_i >= recovery(A_i, A)` for every earlier sound above it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.measured.interpolation import table_at
from circuits.arrays import F64
from circuits.compiled import compiled

SOUND_DURATION = 1e-3  # s, of the sounds that were measured
MEMORY = 20e-3  # s, longer than any recovery: what is kept of the past; ours
UNSURE = 0.05  # share of a threshold or a recovery within which hearing does not decide; ours


class Hearing(NamedTuple):
    """The hearing of one neuron on a die.

    threshold: least peak at the microphone that makes it spike, V; knots, latency: ln(peak / threshold), and
    from onset to spike there, s, float64[k]; recovery_knots: ln(peak / 1 V), float64[m]; recovery: the
    shortest gap between two sounds that both make a spike, s, float64[m, m] over the peaks of the first and
    the second.
    """

    threshold: float
    knots: F64
    latency: F64
    recovery_knots: F64
    recovery: F64  # float64[first sound, second sound]


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
def hears(m: Hearing, sounds: F64, count: int) -> tuple[float, bool]:
    """Return the spike of the last of `count` sounds, s, inf for none, and whether that was too near to call.

    sounds: onset (s) and peak at the microphone (V), float64[room, 2], in the order of their onsets.
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
    """Return the spikes of both neurons for the last of `count` sounds, s, inf for none.

    Returned with them is whether one was too near to call, or the sound overlaps another, whose phase is not
    known. onset, high: both neurons; sounds: as in `hears`.
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
