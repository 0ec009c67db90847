"""Compiled rebound neuron: its states, its inputs, and the way to its next spike (`chips.ranging.law`).

While the call inhibits and while a spike resets, v_mem is held at v_held; for 10 us of an echo v_ex is held
at v_ex_max. The axon fires when w reaches `axon_charge`, w' = v_mem - v_threshold, w >= 0. The same w for the
threshold moved by the margin either way tells what is too near to call.

Where the error of a step outgrows the last one's, the next is shortened in advance (Gustafsson 1994).

Neurons of a live chip are looked at ahead (`Looked`), up to their next spike or for a while. A step's length
follows from the neuron alone: it is cut by its own inputs and by the end of a look, which is `WATCHED` after
its begin. So how a run is cut into spans moves no bit of it, and a neuron is integrated once, however short
the spans are, unless an input comes before its look ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.ranging.law import Neurons, Three, currents, excited, matrix_of, numbers_of, rates, stepped
from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled
from circuits.devices.softplus import softplus_at
from circuits.vectors.vector import bits_of, of_bits

TOLERANCE = 1e-4  # V, local error of a step; ours: moves a peak by up to 0.35 mV, inside the measured margin
ECHO_HELD = (0.05e-6, 10.15e-6)  # s, half-supply crossings of an event's pulse
# First steps, s, after v_mem is pulled low, after it is let go, and after an echo's pulse ends; the pulse
# itself, which holds v_ex, is tried in one. The last is short: v_ex keeps its errors, and 0.1 mV of it is
# some millivolts of a later peak of v_mem.
PULLED_STEP, _RELEASED_STEP, _EXCITED_STEP = 5e-8, 4e-9, 1e-6
_SAFETY = 0.9  # of the step that the error allows
_LEEWAY = 100.0  # largest ratio of the tolerance to an error that the next step is judged by
_NO_STEP = 1e-30  # s, before the first one
_PARTS = 8  # of a step, over which w is summed
_LOOKAHEAD = 2e-3  # s, for which a spike's certainty is looked for beyond it
SETTLED = 0.1  # V/s, of every node: nothing happens any more
_CUBE_ROOT = 0x553EF0FF289DD796  # less a third of a number's bits are nearly those of its inverse cube root
_FALLEN = 0.1  # V below the threshold, from which v_mem falls on to rest while v_r and v_ex only rise
_RECOVERED = 20e-3  # V, of v_ex below the supply: less excitation than the coupling of v_mem makes

# Columns of a state.
V_MEM, V_R, V_EX, NOW, STEP, CHARGE, CHARGE_LOW, NEAR, RELEASE, RESET_END, ECHO_START, ECHO_END, ECHO_LEVEL, \
    UNDECIDED, PEAK, EARLY_STOP = range(16)  # fmt: skip
COLUMNS = 16
WATCHED = 5e-3  # s, looked ahead of a neuron of a live chip; ours
RUN_ON, MAY_STOP, STOPPED = 0.0, 1.0, 2.0  # one that may stop early does where it only falls back to rest

_compiled = compiled(fastmath={"contract"})


@_compiled
def excitation(m: Neurons, k: int, s: F64) -> float:
    """Return the rate at which me5 raises a free v_mem, V/s."""
    return float(_excitation(m, m.effects, k, s) * m.inverse_capacitance[k, 0, 0, 0])


@_compiled
def _excitation(m: Neurons, effects: F64 | None, k: int, s: F64) -> float:
    """Return the current of me5, A; the law's branch is taken when this is compiled."""
    if effects is not None:
        numbers = numbers_of(m, k)
        return float(excited(numbers, numbers.effects, s[V_MEM], s[V_EX]))  # type: ignore[arg-type]
    e = softplus_at(m.kappa_p[k] * (m.v_dd[k] - s[V_EX] - m.me5_threshold[k]) * m.inverse_2ut[k])
    return float(m.me5_current[k] * e * e)


@_compiled
def copy_state(source: F64, target: F64) -> None:
    """Copy the columns of a neuron's state."""
    for i in range(source.size):
        target[i] = source[i]


@_compiled
def _hold(m: Neurons, k: int, s: F64, column: int, level: float) -> None:
    """Move a node to a level; the free ones follow through the coupling capacitances."""
    move = level - s[column]
    s[column] = level
    for row in range(3):
        if row != column:
            s[row] += m.follow[k, row, column] * move


@_compiled
def begin(m: Neurons, k: int, s: F64, time: float) -> float:
    """Write the rest state at `time` s.

    Return v_mem less the threshold, V, above 0 where there is no rest.
    """
    v, r = m.v_rest[k], m.v_rest[k] + 1.0
    x = m.v_dd[k]
    numbers = numbers_of(m, k)
    for _ in range(200):
        i = currents(numbers, v, r, x)
        determinant = i[3] * i[7] - i[4] * i[6]
        dv = (i[0] * i[7] - i[4] * i[1]) / determinant
        dr = (i[3] * i[1] - i[6] * i[0]) / determinant
        v -= min(max(dv, -0.05), 0.05)
        r -= min(max(dr, -0.05), 0.05)
        if abs(dv) + abs(dr) < 1e-9:
            break
    s[:] = 0.0
    s[V_MEM], s[V_R], s[V_EX], s[NOW], s[STEP] = v, r, x, time, _EXCITED_STEP
    s[RELEASE], s[RESET_END] = -np.inf, -np.inf
    s[ECHO_START], s[ECHO_END] = np.inf, -np.inf
    s[PEAK] = -np.inf
    above: float = v - m.v_threshold[k]
    return above


@_compiled
def call(m: Neurons, k: int, s: F64) -> None:
    """Take a call now: v_mem is held low for t_inh."""
    s[RELEASE] = s[NOW] + m.t_inh[k]
    s[CHARGE], s[CHARGE_LOW] = 0.0, 0.0
    _hold(m, k, s, V_MEM, m.v_held[k])
    s[STEP] = PULLED_STEP


@_compiled
def echo(m: Neurons, k: int, s: F64, level: float) -> None:
    """Take an echo now: v_ex is held at `level` (V) while its pulse lasts."""
    s[ECHO_START], s[ECHO_END] = s[NOW] + ECHO_HELD[0], s[NOW] + ECHO_HELD[1]
    s[ECHO_LEVEL] = level


@_compiled
def advance(m: Neurons, k: int, s: F64, until: float) -> float:
    """Advance a neuron to `until` (s) or to its first spike, and return the time of the spike, else inf."""
    return advance_within(m, k, s, until, TOLERANCE)


@_compiled
def advance_within(m: Neurons, k: int, s: F64, until: float, tolerance: float) -> float:
    """Advance a neuron as `advance` does, by steps of another tolerance, V."""
    while s[NOW] < until:
        t = s[NOW]
        stop = until
        for column in (RELEASE, RESET_END, ECHO_START, ECHO_END):
            if t < s[column] < stop:
                stop = s[column]
        held = t < s[RELEASE] or t < s[RESET_END]
        mode = (1 if held else 0) + (2 if s[ECHO_START] <= t < s[ECHO_END] else 0)
        spike = _integrate(m, k, mode, s, stop, tolerance)
        if spike < np.inf:
            _hold(m, k, s, V_MEM, m.v_held[k])
            s[RESET_END] = spike + m.pulse_width[k]
            s[CHARGE], s[CHARGE_LOW], s[NEAR], s[STEP] = 0.0, 0.0, 0.0, PULLED_STEP
            return spike
        if s[EARLY_STOP] == STOPPED:
            return np.inf
        s[NOW] = stop
        if stop == s[RELEASE] or stop == s[RESET_END]:
            s[STEP] = _RELEASED_STEP
        if stop == s[ECHO_START]:
            _hold(m, k, s, V_EX, s[ECHO_LEVEL])
            if held:
                s[V_MEM] = m.v_held[k]
            s[STEP] = ECHO_HELD[1] - ECHO_HELD[0]
        if stop == s[ECHO_END]:
            s[V_EX] += m.echo_step[k]
            s[STEP] = _EXCITED_STEP
    return np.inf


@_compiled
def _integrate(  # noqa: C901, PLR0912, PLR0915 - one loop with its scalars
    m: Neurons, k: int, mode: int, s: F64, stop: float, tolerance: float
) -> float:
    """Integrate in one mode to `stop` or to a spike (its time, else inf)."""
    y = (s[V_MEM], s[V_R], s[V_EX])
    t, h = s[NOW], s[STEP]
    numbers, matrix = numbers_of(m, k), matrix_of(m, k, mode)
    i = currents(numbers, y[0], y[1], y[2])
    d = rates(matrix, i)
    threshold, enough, margin = m.v_threshold[k], m.axon_charge[k], m.margin[k]
    charge, low, high, near = s[CHARGE], s[CHARGE_LOW], 0.0, s[NEAR]
    spike, end = np.inf, stop
    kept = y
    earlier_step, earlier_room = _NO_STEP, 1.0
    while t < end:
        if spike == np.inf and max(abs(d[0]), abs(d[1]), abs(d[2])) < SETTLED and y[0] < threshold - 0.05:
            break
        last = h >= end - t
        step = min(h, end - t)
        n, error = stepped(numbers, matrix, step, y, i)
        room = tolerance / max(error, 1e-12)
        if not error <= tolerance:
            h = step * (max(_SAFETY * _cube_root(room), 0.1) if error > tolerance else 0.1)  # else a NaN
            continue
        i = currents(numbers, n[0], n[1], n[2])
        e = rates(matrix, i)
        if mode & 1 == 0:
            s[PEAK] = max(s[PEAK], n[0])
            top = max(y[0], n[0]) + 0.15 * step * max(d[0] - e[0], 0.0)
            if top > threshold - margin or low > 0.0:
                part, before = step / _PARTS, y[0]
                for j in range(1, _PARTS + 1):
                    z = j / _PARTS
                    after = _hermite(z, step, y[0], n[0], d[0], e[0])
                    s[PEAK] = max(s[PEAK], after)
                    mean = 0.5 * (before + after) - threshold
                    if spike == np.inf:
                        grown = max(charge + part * mean, 0.0)
                        low = max(low + part * (mean + margin), 0.0)
                        if low >= enough:
                            near = 1.0
                        elif low == 0.0 and near > 0.0:
                            s[UNDECIDED] += 1.0
                            near = 0.0
                        high = max(high + part * (mean - margin), 0.0)
                        if grown >= enough:
                            share = (enough - charge) / (grown - charge)
                            z -= (1.0 - share) / _PARTS
                            spike = t + step * z
                            kept = (
                                before + share * (after - before),
                                _hermite(z, step, y[1], n[1], d[1], e[1]),
                                _hermite(z, step, y[2], n[2], d[2], e[2]),
                            )
                            end = spike + _LOOKAHEAD
                        charge = grown
                    else:
                        high = max(high + part * (mean - margin), 0.0)
                    before = after
                if spike < np.inf and (high >= enough or n[0] < threshold - margin):
                    break
            else:
                charge, low, high = 0.0, 0.0, 0.0
                if near > 0.0:
                    s[UNDECIDED] += 1.0
                    near = 0.0
        t += step
        y, d = n, e
        if s[EARLY_STOP] == MAY_STOP and spike == np.inf and _falls_back(m, k, mode, s, t, y, e):
            s[EARLY_STOP] = STOPPED
            end = t
        # an error that grows from step to step goes on growing (Gustafsson 1994)
        trend = (step / earlier_step) ** 3 * room / earlier_room
        earlier_step, earlier_room = step, min(room, _LEEWAY)
        factor = _SAFETY * _cube_root(room * min(trend, 1.0))
        h = step * min(max(factor, 0.2), 5.0) if not last else max(h, step * min(factor, 5.0))
    if spike < np.inf:
        if high < enough:
            s[UNDECIDED] += 1.0
        s[V_MEM], s[V_R], s[V_EX] = kept
        s[NOW] = spike
        return spike
    s[V_MEM], s[V_R], s[V_EX] = y
    s[NOW], s[STEP], s[CHARGE], s[CHARGE_LOW], s[NEAR] = end, h, charge, low, near
    return np.inf


@_compiled
def _cube_root(x: float) -> float:
    """Cube root of a positive normal number, to 1e-6 (tested): a guess by the exponent, three of Newton's."""
    y: float = of_bits(_CUBE_ROOT - bits_of(x) // 3)
    for _ in range(3):
        y = y * (1.0 / 3.0) * (4.0 - x * y * y * y)
    return x * y * y


@_compiled
def _falls_back(m: Neurons, k: int, mode: int, s: F64, t: float, y: Three, d: Three) -> bool:
    """Whether nothing but the way back to rest lies ahead until the next input.

    Free of pulses, v_mem falling well below the threshold, v_r and v_ex rising: the current into v_mem falls
    with all three, so that it never turns again.
    """
    if mode != 0 or s[ECHO_END] > t or s[RELEASE] > t or s[RESET_END] > t or s[NEAR] > 0.0:
        return False
    falling = d[0] < 0.0 and y[0] < m.v_threshold[k] - _FALLEN and d[1] >= 0.0
    return falling and (d[2] >= 0.0 or y[2] > m.v_dd[k] - _RECOVERED)


@_compiled
def _hermite(z: float, h: float, a: float, b: float, da: float, db: float) -> float:
    """Cubic through both ends of a step with their slopes, at share z."""
    c = 1.0 - z
    return a * c * c * (1.0 + 2.0 * z) + b * z * z * (3.0 - 2.0 * z) + h * z * c * (c * da - z * db)


@_compiled
def respond_all(
    m: Neurons, times: F64, is_call: Bools, until: float, s: F64, spikes: F64, counts: I64
) -> None:
    """Fill the spikes of every neuron, at rest at first, to calls and echoes at sorted times.

    times: s, float64[events]; is_call: bool[events], else an echo; until: end, s; s: working space,
    float64[COLUMNS]; spikes: s, float64[n, room]; counts: spikes and undecided moments, int64[n, 2]. Spikes
    beyond the room are counted only.
    """
    for k in range(counts.shape[0]):
        first = times[0] if times.size else 0.0
        above = begin(m, k, s, min(first, 0.0))
        counts[k, 0] = 0
        for j in range(times.size + 1):
            stop = times[j] if j < times.size else until
            while s[NOW] < stop:
                spike = advance(m, k, s, stop)
                if spike < np.inf:
                    if counts[k, 0] < spikes.shape[1]:
                        spikes[k, counts[k, 0]] = spike
                    counts[k, 0] += 1
            if j < times.size:
                if is_call[j]:
                    call(m, k, s)
                else:
                    echo(m, k, s, m.v_ex_max[k])
        counts[k, 1] = int(s[UNDECIDED]) + int(s[NEAR]) + int(abs(above) < m.margin[k])


class Looked(NamedTuple):
    """Neurons, each as it was looked at last, and what lies ahead of it.

    base: after the last input, spike or look, float64[n, COLUMNS]; ahead: when it is due, likewise; due: of
    the next spike or the next look, s, float64[n]; fires: whether that is a spike, bool[n].
    """

    base: F64
    ahead: F64
    due: F64
    fires: Bools

    def copied(self) -> Looked:
        """Return neurons that may be written to."""
        return Looked(self.base.copy(), self.ahead.copy(), self.due.copy(), self.fires.copy())

    @property
    def undecided(self) -> int:
        """At how many moments a spike was too near to call, up to where each was looked at."""
        return int(self.base[:, UNDECIDED].sum() + self.base[:, NEAR].sum())


def resting(m: Neurons, time: float) -> Looked:
    """Return neurons at rest at `time` s."""
    n = m.t_inh.size
    made = Looked(np.zeros((n, COLUMNS)), np.zeros((n, COLUMNS)), np.zeros(n), np.zeros(n, np.bool_))
    for k in range(n):
        begin(m, k, made.base[k], time)
    look_all(m, made)
    return made


@_compiled
def _look(m: Neurons, w: Looked, k: int) -> None:
    """Integrate a neuron to its next spike, or as far as it is looked ahead: to its release at the most."""
    s = w.ahead[k]
    copy_state(w.base[k], s)
    until = s[NOW] + WATCHED
    if s[NOW] < s[RELEASE]:
        until = min(until, s[RELEASE])
    spike = advance(m, k, s, until)
    w.fires[k] = spike < np.inf
    w.due[k] = min(spike, until)


@_compiled
def look_all(m: Neurons, w: Looked) -> None:
    """Look at all neurons as they are."""
    for k in range(w.due.size):
        _look(m, w, k)


@_compiled
def go_on(m: Neurons, w: Looked, until: float, fired: Bools) -> float:
    """Go on to `until` (s) or to the first spike, and return the time reached; fired: who spikes then."""
    while True:
        first = np.inf
        for k in range(w.due.size):
            first = min(first, w.due[k])
        if first > until:
            return until
        found = False
        for k in range(w.due.size):
            if w.due[k] == first:
                fired[k] = w.fires[k]
                found = found or w.fires[k]
                copy_state(w.ahead[k], w.base[k])
                _look(m, w, k)
        if found:
            return float(first)


@_compiled
def bring(m: Neurons, w: Looked, time: float, fired: Bools) -> None:
    """Bring what all neurons are to `time` s, not beyond what is due; what lies ahead is not looked at.

    fired: who spikes then: whoever does by a step that ends there, and not by the longer one that was looked.
    """
    for k in range(w.due.size):
        while w.base[k, NOW] < time:
            if advance(m, k, w.base[k], time) < np.inf:
                fired[k] = True
