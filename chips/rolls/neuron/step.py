"""Compiled steps of a ROLLS chip's membranes: easy ones side by side, hard ones by themselves.

A membrane's own current and what its input and its inhibition are multiplied with are lines over zeta
(`chips.rolls.lumped.lines`). A line is taken as far as its reach, where a step's error by the next ones'
other slopes begins to count. A step that ends within the reach is the exact solution on one line; else the
neuron walks from line to line, each time being the exact one for currents that stand still: from `r` to
`r_end`, dzeta / dt at its ends, it takes `dzeta ln(r_end / r) / (r_end - r)`.

Where a alone is far above all input the neuron will spike, after the time T that is left, with T_0 = int Q_0
/ a dzeta and T_1 = int Q_0 / a^2 dzeta to the top, T = T_0 / (1 + J T_1 / T_0): exact for a constant a, and
what comes in meanwhile no longer counts.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from chips.rolls.layout import (
    BASE,
    BENT,
    C24,
    DELAY,
    DRAWN,
    HALF,
    INVERSE,
    KICK,
    LAST,
    NEVER,
    ONE,
    REACH,
    REFRACTORY,
    SHIFT,
    SHUT,
    SIXTH,
    STATIC,
    STEEP,
    STRONGEST,
    SURE,
    TOP,
    TWO,
    V_AHP,
    WAIT,
    WRITTEN,
    ZETA,
    Membranes,
    Scratch,
    Traffic,
    step_compiled,
    step_inlined,
)
from circuits.arrays import F32, F64, I64


@step_inlined
def strong(current: np.float32, over: np.float32) -> np.float32:
    """G(J): by how much more of J the pair lets into a membrane far above v_thr, for strong inversion."""
    t = math.sqrt(current * over)
    r = t * (HALF + t * (SIXTH + t * C24))
    return r * (TWO + r)


@step_inlined
def rates(m: Membranes, zeta: F64, bits: I64, s: Scratch) -> None:
    """dzeta/dt and its slope, 1/s, the membrane's own part, A, and its line's reach, at the beginning."""
    more = s.own
    for k in range(zeta.size):
        more[k] = s.excite[k] * strong(s.excite[k], m.strong[k])
    for k in range(zeta.size):
        row = m.lines[k, np.uint64((bits[k] >> SHIFT) - BASE)]
        x, extra, drawn, inverse = np.float32(zeta[k]), more[k], s.inhibit[k], m.inverse[k]
        own = row[STATIC] + x * row[STATIC + 1]
        into = own + s.excite[k] + extra * (row[BENT] + x * row[BENT + 1])
        s.own[k] = own
        s.rate[k] = (into - drawn * (row[DRAWN] + x * row[DRAWN + 1])) * inverse
        s.slope[k] = (row[STATIC + 1] + extra * row[BENT + 1] - drawn * row[DRAWN + 1]) * inverse
        s.low[k], s.high[k] = row[REACH], row[REACH + 1]


@step_inlined
def _growth(x: np.float32) -> np.float32:
    """(e^x - 1) / x, e^x being taken as one over the first five terms of e^-x; for x of about 1 at most."""
    part = ONE - x * (HALF - x * (SIXTH - x * C24))
    return part / (ONE - x * part)


@step_inlined
def _linear(row: F64, x: float) -> float:
    i = min(max(int(x), 0), row.size - 2)
    return float(row[i] + (x - i) * (row[i + 1] - row[i]))


@step_inlined
def adapt(m: Membranes, state: F64, step: float, inhibit: F32) -> None:
    """v_ahp over a step, and what it draws."""
    for k in range(inhibit.size):
        x = state[V_AHP, k] / m.ahp_step
        inhibit[k] += np.float32(_linear(m.drawn[k], x))
        rate = _linear(m.quiet[k], x)
        slope = (_linear(m.quiet[k], x + 0.01) - rate) / (0.01 * m.ahp_step)
        moved = step * rate * float(_growth(np.float32(min(slope * step, 0.0))))
        state[V_AHP, k] = max(state[V_AHP, k] + moved, 0.0)


@step_inlined
def move(m: Membranes, state: F64, step: float, s: Scratch) -> bool:
    """Easy steps; s.hard tells the others, but those of s.fast. Returns whether there are any."""
    zeta = state[ZETA]
    some = False
    span, steep, sure = np.float32(step), np.float32(STEEP), np.float32(SURE)
    for k in range(zeta.size):
        x = s.slope[k] * span
        new = max(zeta[k] + s.rate[k] * span * _growth(max(x, -STRONGEST)), 1.0)
        held, fast = state[WAIT, k] > 0.0, s.fast[k] != 0
        # what drives it is less than its own current
        own = s.own[k] * m.inverse[k]
        rising = (x > steep) & (own > sure * abs(s.rate[k] - own))
        due = (state[SHUT, k] < step) | (held & (state[WAIT, k] <= step))
        leaps = (rising | (x > ONE) | (new > s.high[k]) | (new < s.low[k])) & (not held)
        hard = (due | leaps) & (not fast)
        zeta[k] = zeta[k] if held | hard | fast else new
        s.hard[k] = 1 if hard else 0
        some |= hard
    return some


@step_inlined
def sorted_out(words: I64, marks: NDArray[np.uint8], found: I64, places: I64) -> tuple[int, int]:
    """Neurons that are marked into `found`, and words of eight that have any into `places`; their numbers.

    Without a branch that depends on a neuron: what cannot be guessed costs more than all the rest.
    """
    some = count = 0
    for word in range(words.size):
        places[some] = word
        some += 1 if words[word] != 0 else 0
    for j in range(some):
        first = 8 * places[j]
        for k in range(first, first + 8):
            found[count] = k
            count += marks[k]
    return count, some


@step_inlined
def _fire(m: Membranes, state: F64, k: int, now: float, t: Traffic) -> None:
    """The spike of neuron k whose time has come."""
    t.sent[t.counts[WRITTEN]], t.senders[t.counts[WRITTEN]] = now + state[SHUT, k], k
    t.counts[WRITTEN] += 1
    t.last[t.counts[LAST]] = k
    t.counts[LAST] += 1
    state[SHUT, k] = NEVER
    if m.adapting:
        state[V_AHP, k] += m.spiking[k, KICK] * _linear(m.share[k], state[V_AHP, k] / m.ahp_step)


@step_inlined
def _time(way: float, rate: float, last: float) -> float:
    """Time in which `way` is gone at a rate that goes from `rate` to `last`, in proportion to the way; s."""
    both = rate + last
    s = (last - rate) / both
    x = s * s
    if x > 0.1:
        return way * math.log(last / rate) / (last - rate)
    # the logarithm as an inverse hyperbolic tangent
    return 2.0 * way / both * (1.0 + x * (1.0 / 3.0 + x * (0.2 + x * (1.0 / 7.0 + x / 9.0))))


@step_inlined
def _walked(
    m: Membranes,
    state: F64,
    bits: I64,
    k: int,
    given: tuple[float, float, float, float],
    left: float,
    step: float,
) -> float:
    """Walk a free neuron for `left` s; the time until it is at its top, s, NEVER where that is not known.

    given: what flows into i_in and is drawn from v_mem, what noise brings, and that after a spike, A.
    """
    excite, inhibit, noise, _ = given
    extra = excite * float(strong(np.float32(excite), m.strong[k]))
    inverse, top = m.spiking[k, INVERSE], m.spiking[k, TOP]
    gone, steep = 0.0, STEEP / (step * inverse)
    while True:
        zeta, i = state[ZETA, k], np.uint64((bits[k] >> SHIFT) - BASE)
        row = m.lines[k, i]
        own = row[STATIC] + zeta * row[STATIC + 1]
        drive = excite + noise + extra * (row[BENT] + zeta * row[BENT + 1])
        drive -= inhibit * (row[DRAWN] + zeta * row[DRAWN + 1])
        slope = row[STATIC + 1] + extra * row[BENT + 1] - inhibit * row[DRAWN + 1]
        if slope > steep and own > SURE * abs(drive):
            rise = m.rise[k, i]
            # T_0 / (1 + drive T_1 / T_0)
            to_top = (rise[0] + zeta * rise[1]) / (1.0 + drive * (rise[2] + zeta * rise[3]))
            return gone + max(float(to_top), 0.0)
        rate, slope = (own + drive) * inverse, slope * inverse
        end = min(float(row[REACH + 1]), top) if rate > 0.0 else max(float(row[REACH]), 1.0)
        way = end - zeta
        last = rate + slope * way
        time = _time(way, rate, last) if last * rate > 0.0 else NEVER
        if gone + time >= left:
            x = slope * (left - gone)
            far = (
                rate * (left - gone) * (float(_growth(np.float32(x))) if abs(x) < 0.5 else math.expm1(x) / x)
            )
            state[ZETA, k] = max(zeta + far, 1.0)
            return NEVER
        gone += time
        state[ZETA, k] = end
        if end >= top:
            return gone
        if end <= 1.0:
            return NEVER


@step_inlined
def live(
    m: Membranes, state: F64, bits: I64, k: int, given: tuple[float, float, float, float],
    span: tuple[float, float, float], now: float, t: Traffic,
) -> bool:  # fmt: skip
    """All that a neuron does in a part of a step, which begins at `now`: spikes, pauses and ways to the top.

    Returns whether it was let go. given: as of `_walked`; span: beginning and end of the part, and how long
    the step is, s.
    """
    at, end, step = span
    released = False
    while True:
        if state[SHUT, k] < end:
            _fire(m, state, k, now, t)
        if state[WAIT, k] > end:
            return released
        if state[WAIT, k] > 0.0:
            at = state[WAIT, k]
            # at 0 V the whole input enters and nothing is drawn
            state[WAIT, k], state[ZETA, k] = 0.0, 1.0
            given, released = (given[0], given[1], given[3], given[3]), True
        to_top = _walked(m, state, bits, k, given, end - at, step)
        if to_top >= NEVER:
            return released
        state[SHUT, k] = at + to_top + m.spiking[k, DELAY]
        state[WAIT, k] = state[SHUT, k] + m.spiking[k, REFRACTORY]


@step_compiled
def live_hard(m: Membranes, state: F64, bits: I64, step: float, now: float, t: Traffic, s: Scratch) -> None:
    """Hard steps: spikes whose time has come, neurons that are let go, that go far, or will spike soon."""
    count, _ = sorted_out(s.hard_words, s.hard, s.found[0], s.found[1])
    for j in range(count):
        k = s.found[0, j]
        given = float(s.excite[k]), float(s.inhibit[k]), s.push[k] / m.spiking[k, INVERSE], float(s.calm[k])
        live(m, state, bits, k, given, (0.0, step, step), now, t)
