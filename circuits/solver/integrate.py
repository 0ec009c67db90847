"""The compiled loop of a transient: variable-step BDF2, restarted where a stimulus bends.

The derivative at a new point, with the step h and `w = h / h_n`, h_n being the step before, is

    v'_n+1 = [ (1+2w)/(1+w) v_n+1 - (1+w) v_n + w^2/(1+w) v_n-1 ] / h

The predictor is the parabola through the last three points. After a bend of a stimulus there are no such
points: the derivative of the solution, from `C v' = -(G v + i)`, stands in for them, and the first step is
backward Euler.

Local error: with the corrector's constant `K_c = h^2 (h+h_n)(1+w) / (6 (1+2w))` and the predictor's `K_p = h
(h+h_n)(h+h_n+h_n-1) / 6`, the error of a step is `|v - v_pred| K_c / (K_c + K_p)`. It is kept below `rtol
(max(|v|, 1 V) + 1 us |v'|)` at every node with capacitance: an edge may be off by a share of a microsecond
instead of a share of a volt.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, III.5 (variable-step BDF2).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled
from circuits.lowering.factor import factor_and_solve
from circuits.lowering.kernel import Kernel, Sources
from circuits.solver.newton import Work, allocate, evaluate, fill_jacobian, newton, set_base

DONE, EVENT, STEP_TOO_SMALL, TOO_MANY_STEPS, BUFFER_FULL = range(5)
SMALLEST_STEP = 1e-15  # s
SAME_TIME = 1e-13  # s, vertices closer than this are one breakpoint
_EVENT_WIDTH = 1e-9  # s, how close behind the crossing a run stops at an event
_INSTANT = 1e-12  # s, of the implicit step that tells rates where capacitances alone do not; ours
TIMING = 1e-6  # s, ours: rtol times this is the error of a fast edge's timing that is let pass


class History(NamedTuple):
    """What a run carries on: its last three points (newest first), the step, and armed spike detectors."""

    time: F64  # [3], s
    voltage: F64  # [3, columns], V
    rate: F64  # [columns], V/s, derivative at the last restart
    step: F64  # [1], next step, s; 0 asks for a restart
    points: I64  # [1], valid points since the last restart
    armed: Bools  # [watched]
    counts: I64  # [3]: steps accepted, rejected, iterations


class Recorder(NamedTuple):
    """What is recorded of a run: the nodes and thresholds, and preallocated room for points and spikes."""

    columns: I64  # [recorded] positions in the voltage vector
    watch: I64  # [watched] positions in the voltage vector; rising through the level is a spike
    levels: F64  # [2, watched], V, of the crossing, and below which a detector is armed again
    time: F64  # [capacity], s
    voltage: F64  # [capacity, recorded]
    spike_time: F64  # [capacity], s
    spike_index: I64  # [capacity] position in the watch list
    filled: I64  # [2]: points, spikes


class Goal(NamedTuple):
    """How far one call of the loop advances a run, and how exactly."""

    until: float  # s
    rtol: float  # local error a step, relative to 1 V or more
    max_steps: int  # of this call, rejected ones included
    stop_at_event: bool  # whether the last step ends on the first event


class Scratch(NamedTuple):
    """Working memory of one thread for one set of sources; nothing in it outlives a call."""

    work: Work
    v: F64  # [columns], V
    guess: F64  # [columns], V
    history: F64  # [columns], V/s
    cursor: I64  # [sources]


def new_recorder(columns: I64, watch: I64, levels: F64, points: int, spikes: int) -> Recorder:
    """An empty recorder with room for a number of points and of spikes; arrays as of `Recorder`."""
    return Recorder(
        columns, watch, levels, np.zeros(points), np.zeros((points, columns.size)), np.zeros(spikes),
        np.zeros(spikes, dtype=np.int64), np.zeros(2, dtype=np.int64),
    )  # fmt: skip


def new_scratch(k: Kernel, s: Sources) -> Scratch:
    """Working memory for a kernel and its sources."""
    v, guess, history = (np.zeros(k.columns) for _ in range(3))
    return Scratch(allocate(k), v, guess, history, s.start[:-1].copy())


@compiled()
def source_values(s: Sources, cursor: I64, t: float, v: F64, unknowns: int) -> None:
    """Write the values of all sources at time t (s) behind the unknowns of v; cursor: where each stands."""
    for k in range(cursor.size):
        lo, hi = s.start[k], s.start[k + 1]
        c = cursor[k]
        while c + 1 < hi and s.time[c + 1] <= t:
            c += 1
        while c > lo and s.time[c] > t:
            c -= 1
        cursor[k] = c
        if t <= s.time[c] or c + 1 == hi:
            v[unknowns + k] = s.value[c]
        else:
            f = (t - s.time[c]) / (s.time[c + 1] - s.time[c])
            v[unknowns + k] = s.value[c] + f * (s.value[c + 1] - s.value[c])


@compiled()
def _source_slopes(s: Sources, cursor: I64, t: float, rate: F64, unknowns: int) -> None:
    """Write the slopes (V/s) of all sources just after time t (s) behind the unknowns of `rate`."""
    for k in range(cursor.size):
        c, hi = cursor[k], s.start[k + 1]
        # a vertex reached within rounding counts as passed
        if c + 1 < hi and s.time[c + 1] - t <= SAME_TIME:
            c += 1
        if c + 1 == hi or s.time[c] > t + SAME_TIME:
            rate[unknowns + k] = 0.0
        else:
            rate[unknowns + k] = (s.value[c + 1] - s.value[c]) / (s.time[c + 1] - s.time[c])


@compiled()
def next_breakpoint(s: Sources, cursor: I64, t: float, stop: float) -> float:
    """Earliest point after t of the sources that are not sampled, s, but no later than `stop`."""
    nearest = stop
    for k in range(cursor.size):
        if not s.sampled[k]:
            c, hi = cursor[k], s.start[k + 1]
            while c < hi and s.time[c] <= t + SAME_TIME:
                c += 1
            if c < hi:
                nearest = min(nearest, s.time[c])
    return nearest


@compiled()
def _sampled_step(s: Sources, cursor: I64, t: float) -> float:
    """Largest step that sampled sources allow at t, s: to the next sample, or the spacing behind it."""
    largest = np.inf
    for k in range(cursor.size):
        if s.sampled[k]:
            c, hi = cursor[k], s.start[k + 1]
            while c < hi and s.time[c] <= t + SAME_TIME:
                c += 1
            if c < hi:
                behind = s.time[c + 1] - s.time[c] if c + 1 < hi else 0.0
                largest = min(largest, max(s.time[c] - t, behind))
    return largest


@compiled()
def _vertex_at(s: Sources, t: float) -> bool:
    """Whether a breakpoint lies at t: the run is resumed where a stimulus bends."""
    for k in range(s.sampled.size):
        if not s.sampled[k] and s.start[k + 1] - s.start[k] > 1:
            c, end = s.start[k], s.start[k + 1]
            while c < end:  # a search by halves: numpy's takes numba half a second to compile
                middle = (c + end) >> 1
                if s.time[middle] < t - SAME_TIME:
                    c = middle + 1
                else:
                    end = middle
            if c < s.start[k + 1] and s.time[c] <= t + SAME_TIME:
                return True
    return False


@compiled()
def _restart(k: Kernel, s: Sources, cursor: I64, h: History, w: Work) -> None:
    """Find the derivative just after a breakpoint: `C v' = -(G v + i)` with the sources' slopes."""
    n = k.unknowns
    v = h.voltage[0]
    rate = h.rate
    for i in range(n):
        rate[i] = 0.0
    rate[k.columns - 1] = 0.0
    _source_slopes(s, cursor, h.time[0], rate, n)
    evaluate(k, v, w)
    for i in range(n):
        total = w.residual[i]
        for p in range(k.charge.start[i], k.charge.start[i + 1]):
            if k.charge.column[p] >= n:
                total += k.charge.value[p] * rate[k.charge.column[p]]
        w.residual[i] = -total
    w.jacobian[:] = 0.0
    for p in range(k.charge.entry.size):
        if k.charge.entry[p] >= 0:
            w.jacobian[k.charge.entry[p]] += k.charge.value[p]
    for i in range(n):
        if not k.dynamic[i]:
            w.jacobian[k.factor.diagonal[i]] += 1.0
            w.residual[i] = 0.0
    factor_and_solve(k.factor, w.jacobian, w.residual)
    _take_rates(k, v, rate, w)
    h.points[0] = 1


@compiled()
def _take_rates(k: Kernel, v: F64, rate: F64, w: Work) -> None:
    """Take the rates that are in the residual, or those of an implicit step where they are none."""
    if k.charges > 0 or not _all_finite(w.residual):
        _implicit_rates(k, v, rate, w)
    for i in range(k.unknowns):
        rate[i] = w.residual[i]


@compiled()
def _implicit_rates(k: Kernel, v: F64, rate: F64, w: Work) -> None:
    """Find the rates of the unknowns, into the residual, from `(C / h + G) v' = -(G v + i) / h`.

    With h = `_INSTANT` that has an answer where C alone has none, as between two nodes that one capacitor
    alone is at, and where diodes store charge. Rates are a guess at what follows: 0 where there is none.
    """
    n, d = k.unknowns, k.diodes
    set_base(k, 1.0 / _INSTANT, w)
    evaluate(k, v, w)
    fill_jacobian(k, w)
    for i in range(n):
        total = w.residual[i] / _INSTANT
        for p in range(k.charge.start[i], k.charge.start[i + 1]):
            if k.charge.column[p] >= n:
                total += k.charge.value[p] * rate[k.charge.column[p]] / _INSTANT
        for p in range(k.conductance.start[i], k.conductance.start[i + 1]):
            if k.conductance.column[p] >= n:
                total += k.conductance.value[p] * rate[k.conductance.column[p]]
        w.residual[i] = -total
    for i in range(d.charge.size if k.charges > 0 else 0):
        for end, sign in ((d.terminal[0, i], 1.0), (d.terminal[1, i], -1.0)):
            if d.charge[i] >= 0 and end >= n:
                w.residual[d.charge[i]] += sign * w.diode_slope[1, i] * rate[end]
    factor_and_solve(k.factor, w.jacobian, w.residual)
    if not _all_finite(w.residual):
        w.residual[:] = 0.0


@compiled()
def _all_finite(values: F64) -> bool:
    for i in range(values.size):  # noqa: SIM110 - a loop, which numba compiles
        if not np.isfinite(values[i]):
            return False
    return True


@compiled()
def _first_step(k: Kernel, h: History, rtol: float) -> float:
    """A first step in which no node moves by more than 0.5 sqrt(rtol) V (ours), for the control to adapt."""
    fastest = 1.0
    for i in range(k.unknowns):
        fastest = max(fastest, abs(h.rate[i]))
    return 0.5 * math.sqrt(rtol) / float(fastest)


@compiled()
def _predict(k: Kernel, h: History, step: float, v: F64) -> None:
    """Extrapolate the unknowns to t + step."""
    points, n = h.points[0], k.unknowns
    v0, v1, v2 = h.voltage[0], h.voltage[1], h.voltage[2]
    if points == 1:
        for i in range(n):
            v[i] = v0[i] + step * h.rate[i]
        return
    h1 = h.time[0] - h.time[1]
    if points == 2:
        s = h1 + step
        for i in range(n):
            bend = (v0[i] - v1[i] - h.rate[i] * h1) / (h1 * h1)
            v[i] = v1[i] + s * (h.rate[i] + s * bend)
        return
    h2 = h.time[1] - h.time[2]
    for i in range(n):
        d1 = (v0[i] - v1[i]) / h1
        d2 = (v1[i] - v2[i]) / h2
        bend = (d1 - d2) / (h1 + h2)
        v[i] = v0[i] + step * (d1 + (h1 + step) * bend)


@compiled()
def _discretise(k: Kernel, h: History, step: float, history: F64) -> tuple[float, float]:
    """Coefficients of the time derivative and the error's share of |v - v_pred|."""
    v0, v1 = h.voltage[0], h.voltage[1]
    if h.points[0] == 1:
        a = 1.0 / step
        for i in range(k.columns):
            history[i] = -a * v0[i]
        return a, 0.5
    h1 = h.time[0] - h.time[1]
    h2 = h.time[1] - h.time[2] if h.points[0] > 2 else 0.0
    w = step / h1
    a = (1.0 + 2.0 * w) / ((1.0 + w) * step)
    b0, b1 = (1.0 + w) / step, w * w / ((1.0 + w) * step)
    for i in range(k.columns):
        history[i] = b1 * v1[i] - b0 * v0[i]
    corrector = step * (1.0 + w) / (1.0 + 2.0 * w)
    return a, corrector / (corrector + step + h1 + h2)


@compiled()
def crossing_of(begin: float, step: float, low: float, slope: float, bend: float) -> float:
    """Time (s) within a step at which a parabola rises through 0, in Newton's form.

    low: its value at the step's beginning. slope: of the line to its value at the step's end. bend: of the
    parabola beyond that line.
    """
    lo, hi = 0.0, step
    for _ in range(60):
        s = 0.5 * (lo + hi)
        if low + s * (slope + (s - step) * bend) < 0.0:
            lo = s
        else:
            hi = s
    return float(begin + hi)


@compiled()
def _crossing(h: History, t_new: float, v_new: F64, column: int, threshold: float) -> float:
    """Time at which the parabola through the last points rises through the threshold, s."""
    t0, y0, y1 = h.time[0], h.voltage[0, column] - threshold, v_new[column] - threshold
    step = t_new - t0
    slope = (y1 - y0) / step
    bend = 0.0
    if h.points[0] > 1:
        h1 = t0 - h.time[1]
        bend = (slope - (h.voltage[0, column] - h.voltage[1, column]) / h1) / (step + h1)
    return crossing_of(t0, step, y0, slope, bend)


@compiled()
def _accept(k: Kernel, h: History, t_new: float, v: F64) -> None:
    for i in range(k.columns):
        h.voltage[2, i] = h.voltage[1, i]
        h.voltage[1, i] = h.voltage[0, i]
        h.voltage[0, i] = v[i]
    h.time[2], h.time[1], h.time[0] = h.time[1], h.time[0], t_new
    h.points[0] = min(h.points[0] + 1, 3)
    h.counts[0] += 1


@compiled()
def _record(h: History, r: Recorder) -> None:
    p = r.filled[0]
    r.time[p] = h.time[0]
    for j in range(r.columns.size):
        r.voltage[p, j] = h.voltage[0, r.columns[j]]
    r.filled[0] = p + 1


@compiled()
def widen(r: Recorder, first: int, extent: F64) -> None:
    """Widen the extent, float64[2, watched], V, by the recorded columns from `first` on."""
    for j in range(extent.shape[1]):
        for p in range(r.filled[0]):
            value = r.voltage[p, first + j]
            extent[0, j] = min(extent[0, j], value)
            extent[1, j] = max(extent[1, j], value)


@compiled()
def _rearm(h: History, r: Recorder) -> None:
    for j in range(r.watch.size):
        if h.voltage[0, r.watch[j]] < r.levels[1, j]:
            h.armed[j] = True


@compiled()
def integrate(  # noqa: C901, PLR0912, PLR0915 - one compiled loop; a call a step costs more
    k: Kernel, s: Sources, h: History, goal: Goal, r: Recorder, scratch: Scratch
) -> int:
    """Advance the history to the goal's time, or to the first event; returns how it ended (`DONE`, ...)."""
    stop, rtol, stop_at_event = goal.until, goal.rtol, goal.stop_at_event
    w, v, guess, history, cursor = scratch.work, scratch.v, scratch.guess, scratch.history, scratch.cursor
    watch, levels = r.watch, r.levels
    n = k.unknowns
    for j in range(n, k.columns):
        guess[j] = h.voltage[0, j]
    source_values(s, cursor, h.time[0], h.voltage[0], n)
    jump = 0.0
    for j in range(n, k.columns):
        jump = max(jump, abs(h.voltage[0, j] - guess[j]))
    if h.step[0] == 0.0 or jump > rtol or _vertex_at(s, h.time[0]):
        _restart(k, s, cursor, h, w)
        h.step[0] = _first_step(k, h, rtol)
    bend = next_breakpoint(s, cursor, h.time[0], stop)
    any_sampled = False
    for j in range(s.sampled.size):
        any_sampled = any_sampled or s.sampled[j]
    landing, resume = -1, 0.0
    for _ in range(goal.max_steps):
        t = h.time[0]
        if stop - t <= SAME_TIME:
            return DONE
        if r.filled[0] == r.time.size or r.filled[1] + watch.size > r.spike_time.size:
            return BUFFER_FULL
        step = min(h.step[0], _sampled_step(s, cursor, t)) if any_sampled else h.step[0]
        room = bend - t
        at_breakpoint = step >= room - SAME_TIME
        if landing < 0 and not at_breakpoint:
            at_breakpoint = step >= 0.999 * room
            if not at_breakpoint and 2.0 * step > room:
                step = 0.5 * room
        if at_breakpoint:
            step = room
        t_new = bend if at_breakpoint else t + step
        source_values(s, cursor, t_new, v, n)
        v[k.columns - 1] = 0.0
        _predict(k, h, step, v)
        a, share = _discretise(k, h, step, history)
        for i in range(n):
            guess[i] = v[i]
        iterations = newton(k, a, history, v, rtol, w)
        h.counts[2] += abs(iterations)
        error = 0.0
        if iterations > 0:
            for i in range(n):
                if k.dynamic[i]:
                    moved = abs(v[i] - h.voltage[0, i]) / step
                    e = abs(v[i] - guess[i]) / (max(abs(v[i]), 1.0) + TIMING * moved)
                    error = max(error, e)
            error *= share / rtol
        if iterations < 0 or error > 1.0:
            h.counts[1] += 1
            landing = -1
            order = 2.0 if h.points[0] == 1 else 3.0
            h.step[0] = step * (0.25 if iterations < 0 else max(0.2, 0.8 * error ** (-1.0 / order)))
            if h.step[0] < SMALLEST_STEP:
                return STEP_TOO_SMALL
            continue
        first, first_time = -1, np.inf
        for j in range(watch.size):
            if h.armed[j] and v[watch[j]] >= levels[0, j]:
                time = _crossing(h, t_new, v, watch[j], levels[0, j])
                if time < first_time:
                    first, first_time = j, time
        if first >= 0 and stop_at_event and t_new - first_time > _EVENT_WIDTH:
            # step again, to the crossing; where that falls short the next step finds it
            resume = step if landing < 0 else resume
            landing = first
            h.step[0] = max(first_time - t, _EVENT_WIDTH)
            continue
        for j in range(watch.size):
            if h.armed[j] and v[watch[j]] >= levels[0, j]:
                p = r.filled[1]
                r.spike_time[p] = t_new if stop_at_event else _crossing(h, t_new, v, watch[j], levels[0, j])
                r.spike_index[p] = j
                r.filled[1] = p + 1
                h.armed[j] = False
        _accept(k, h, t_new, v)
        _rearm(h, r)
        _record(h, r)
        order = 2.0 if h.points[0] == 2 else 3.0
        grow = 2.0 if error == 0.0 else min(2.0, max(0.3, 0.85 * error ** (-1.0 / order)))
        h.step[0] = (
            resume if landing >= 0 and first >= 0 else max(h.step[0], step) if at_breakpoint else step * grow
        )
        if at_breakpoint and stop - t_new > SAME_TIME:
            _restart(k, s, cursor, h, w)
            h.step[0] = _first_step(k, h, rtol)
            bend = next_breakpoint(s, cursor, h.time[0], stop)
        if first >= 0 and stop_at_event:
            return EVENT
        landing = -1
    return TOO_MANY_STEPS
