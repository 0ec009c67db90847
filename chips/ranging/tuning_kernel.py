"""Compiled search for a rebound neuron's class and the edges of its facilitating interval."""

from __future__ import annotations

import numpy as np

from chips.ranging.law import Neurons
from chips.ranging.neuron_kernel import (
    NEAR,
    NOW,
    PEAK,
    RESET_END,
    UNDECIDED,
    advance,
    begin,
    call,
    copy_state,
    echo,
)
from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled

_compiled = compiled(fastmath={"contract"})

CLASSES = ("works", "call-alone", "echo-alone", "never", "rest-fires")
WORKS, CALL_ALONE, ECHO_ALONE, NEVER, REST_FIRES = range(5)
NO, NEARLY, BARELY, YES = range(4)  # whether it fires; the middle two are within the margin

_REST_WATCHED = 20e-3  # s, as the transistor level's tuning does
_FIRST_DELAY = 30e-6  # s
_SCAN = 24
_RESOLUTION = 10e-6  # s


@_compiled
def _fires(m: Neurons, k: int, s: F64, until: float) -> int:
    """Advance `s` and say whether a spike comes before `until`."""
    s[UNDECIDED], s[NEAR] = 0.0, 0.0
    if advance(m, k, s, until) < np.inf:
        return YES if s[UNDECIDED] == 0.0 else BARELY
    return NO if s[UNDECIDED] == 0.0 and s[NEAR] == 0.0 else NEARLY


@_compiled
def _after_echo(m: Neurons, k: int, kept: F64, delay: float, until: float, s: F64) -> int:
    """Whether an echo `delay` after the call fires, from the last state kept before it."""
    j = 0
    while j + 1 < kept.shape[0] and kept[j + 1, NOW] <= delay:
        j += 1
    copy_state(kept[j], s)
    if s[NOW] < delay:
        advance(m, k, s, delay)
    echo(m, k, s, m.v_ex_max[k])
    return _fires(m, k, s, until)


@_compiled
def _edge(m: Neurons, k: int, kept: F64, outside: float, inside: float, until: float, s: F64) -> float:
    while abs(outside - inside) > _RESOLUTION:
        middle = 0.5 * (outside + inside)
        if _after_echo(m, k, kept, middle, until, s) >= BARELY:
            inside = middle
        else:
            outside = middle
    return 0.5 * (outside + inside)


@_compiled
def _interval(m: Neurons, k: int, kept: F64, s: F64, out: F64) -> int:
    """Edges of the facilitating interval into out[0:2]; returns the surest answer of the scan."""
    bound = m.rebound_bound[k]
    latest = m.t_inh[k] + bound
    until = latest + bound
    low = max(m.t_inh[k] - bound, _FIRST_DELAY)
    surest = NO
    for points in (_SCAN, 4 * _SCAN):
        gap = (latest - low) / (points - 1)
        first, last = -1, -1
        for j in range(points):
            answer = _after_echo(m, k, kept, low + j * gap, until, s)
            surest = max(surest, answer)
            if answer >= BARELY:
                first = j if first < 0 else first
                last = j
            elif last >= 0:
                break
        if first >= 0:
            left = low + max(first - 1, 0) * gap
            right = low + min(last + 1, points - 1) * gap
            out[0] = _edge(m, k, kept, left, low + first * gap, until, s)
            out[1] = _edge(m, k, kept, right, low + last * gap, until, s)
            return surest
    return surest


@_compiled
def _tune(m: Neurons, k: int, kept: F64, s: F64, out: F64) -> tuple[int, bool]:
    """Class, and whether it is undecided. out: first, last, peak of v_mem after the call alone."""
    out[:] = np.nan
    above = begin(m, k, kept[0], 0.0)
    if above > 0.0:
        return REST_FIRES, above < m.margin[k]
    unsure = above > -m.margin[k]
    # a call alone, states kept on the way
    call(m, k, kept[0])
    latest = m.t_inh[k] + m.rebound_bound[k]
    for j in range(1, kept.shape[0]):
        copy_state(kept[j - 1], kept[j])
        advance(m, k, kept[j], latest * j / (kept.shape[0] - 1))
        out[2] = kept[j, PEAK]
        if kept[j, RESET_END] > 0.0:
            return CALL_ALONE, unsure or kept[j, UNDECIDED] > 0.0
    unsure = unsure or kept[-1, UNDECIDED] > 0.0 or kept[-1, NEAR] > 0.0
    begin(m, k, s, 0.0)
    echo(m, k, s, m.v_ex_max[k])
    answer = _fires(m, k, s, m.rebound_bound[k] + _REST_WATCHED)
    unsure = unsure or answer in (NEARLY, BARELY)
    if answer >= BARELY:
        return ECHO_ALONE, unsure
    answer = _interval(m, k, kept, s, out)
    return (WORKS if answer >= BARELY else NEVER), unsure or answer in (NEARLY, BARELY)


@_compiled
def tune_all(m: Neurons, kept: F64, s: F64, outcome: I64, undecided: Bools, out: F64) -> None:
    """Fill class, certainty and edges of the facilitating interval of every neuron.

    kept: float64[states, COLUMNS], s: float64[COLUMNS], working space; outcome: int64[n]; undecided: bool[n];
    out: first and last facilitating delay (s, NaN where none) and peak of v_mem after a call alone (V),
    float64[n, 3].
    """
    for k in range(outcome.size):
        outcome[k], undecided[k] = _tune(m, k, kept, s, out[k])
