"""Compiled events of the latency chip from the ping to the winners, exact between events.

All currents are constant between events, so that a membrane moves in straight lines, and stops at ground. The
order within a ping follows causality: the integrating neurons need only what comes in, the units only taps
and integrating neurons, the first layer only the memories, the second only the first.

The tonic neuron INH of a unit is kept as two times: `last`, its last spike, and `release`, from when on it
charges; it spikes at release + k T_tonic until something holds it. So it costs nothing between pings.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from chips.latency.design import REACH
from chips.latency.model import Lumped
from circuits.arrays import F64, I64
from circuits.compiled import compiled
from circuits.event import WIDTH, sort_events

OVERFLOW, UNDECIDED = range(2)  # of `Memory.counts`
MARGIN = 0.02  # |ln| of a detector's currents over what is taken, within which it does not decide; ours
STEPS = 64  # of the events of one membrane, at most

_compiled = compiled()


class Memory(NamedTuple):
    """What a chip keeps from ping to ping; all of it is overwritten in place.

    last, release: last spike of each unit's tonic neuron, and from when on it charges, s since the run's
    begin, float64[n, u]; counts: inputs without a synapse, and units that the model could not decide,
    int64[2]; time, change: working space, float64[STEPS].
    """

    last: F64
    release: F64
    counts: I64
    time: F64
    change: F64


class Charge(NamedTuple):
    """Charges of a race: the goal neuron and the ping's direction, -1 for none, and when each begins, s."""

    goal: int
    goal_at: float
    direction: int
    direction_at: float


class Race(NamedTuple):
    """Latencies of both layers, s, float64[n], inf for cells that did not win.

    free: of the first layer as if nothing had stopped it.
    """

    free: F64
    first: F64
    second: F64


@_compiled
def crossing(time: F64, change: F64, count: int, charge: float) -> float:
    """Return when a membrane that starts at ground has taken up `charge` (C), s, inf for never.

    time (s), change (A): of its current at each of `count` events, which are sorted in place. The membrane
    does not go below ground.
    """
    sort_events(time, change, count)
    level, current = 0.0, 0.0
    for i in range(count):
        current += change[i]
        following = time[i + 1] if i + 1 < count else math.inf
        if current > 0.0:
            reached = time[i] + (charge - level) / current
            if reached <= following:
                return float(reached)
        if following < math.inf:
            level = max(level + current * (following - time[i]), 0.0)
    return math.inf


@_compiled
def integrate(c: Lumped, m: Memory, arrive: F64, memory: I64, spike: F64) -> None:
    """Fill `spike` with the latency of each integrating neuron, s after the ping, float64[n], inf for none.

    Equation (9) of Wen and Horiuchi (2022) holds where its conditions do. arrive: of the events, s after the
    ping, rising; memory: which memory each goes to, int64[events]. Each event takes the next of a neuron's
    synapses; those that come when all are taken are counted and lost.
    """
    synapses = c.synapse.shape[1]
    for p in range(spike.size):
        used, count = 0, 0
        if c.leak[p] > 0.0:
            m.time[0], m.change[0], count = 0.0, -c.leak[p], 1
        for k in range(arrive.size):
            if memory[k] != p:
                continue
            if used == synapses:
                m.counts[OVERFLOW] += 1
                continue
            current = c.synapse[p, used]
            m.time[count], m.change[count] = arrive[k], current
            m.time[count + 1], m.change[count + 1] = arrive[k] + c.step[p, used], -current
            used += 1
            count += 2
        spike[p] = crossing(m.time, m.change, count, c.integrating[p])


@_compiled
def last_spike(m: Memory, p: int, u: int, tonic: float, now: float) -> float:
    """Return the last spike of a unit's tonic neuron before `now`, s."""
    since = now - m.release[p, u]
    if since < tonic:
        return float(m.last[p, u])
    return float(m.release[p, u] + math.floor(since / tonic) * tonic)


@_compiled
def recall(c: Lumped, m: Memory, start: float, spike: F64, given: F64, detected: F64, out: F64) -> None:
    """Fill the latencies of each unit's detector and of each memory's first output, s after the ping.

    start: of the ping, s; spike: of the integrating neurons, float64[n]; given: latencies that stand in for
    the model's (inf: no spike), nan where the model decides, float64[n, u]; detected: float64[n, u], out:
    float64[n], both filled.
    """
    units = c.hold.shape[1]
    for p in range(spike.size):
        out[p] = math.inf
        tap = c.tap[0]
        for u in range(units):
            tap += c.tap[u + 1]
            before = last_spike(m, p, u, c.tonic[p, u], start + tap)
            passed = tap if start + tap >= before + c.block[p, u] else math.inf
            found, lasts = _detect(c, m, p, u, tap, passed, spike[p])
            if not math.isnan(given[p, u]):
                found, lasts = given[p, u], c.window[p, u, 0]
            detected[p, u] = found
            if found < math.inf:
                at = start + found
                m.last[p, u] = last_spike(m, p, u, c.tonic[p, u], at)
                m.release[p, u] = at + lasts + c.hold[p, u]
                out[p] = min(out[p], found)


@_compiled
def _detect(
    c: Lumped, m: Memory, p: int, u: int, tap: float, passed: float, spoken: float
) -> tuple[float, float]:
    """Latency of a detector's spike and how long it lasts, s; inf where nothing coincides.

    tap, passed, spoken: its inputs' (A, B, the integrating neuron's), s, inf where there is none.
    """
    seen, window, taken = c.seen[p, u], c.window[p, u], c.taken[p, u]
    at = min(tap, spoken)
    for _ in range(2):
        total = _sum_at(seen, window, tap, passed, spoken, at)
        m.counts[UNDECIDED] += abs(math.log(total / taken)) < MARGIN
        if total > taken:
            late = at + c.sum / (total - taken)
            lasts = _ends(seen, window, tap, passed, spoken, at, taken) - late
            if lasts > 0.0:
                return late, lasts
        at = max(tap, spoken)
        if at == math.inf:
            break
    return math.inf, 0.0


@_compiled
def _sum_at(seen: F64, window: F64, tap: float, passed: float, spoken: float, at: float) -> float:
    """Current into a detector's node at a time, A."""
    total = 0.0
    if tap <= at < tap + window[0]:
        total += seen[0]
    if passed <= at < passed + window[1]:
        total += seen[1]
    if spoken <= at < spoken + window[2]:
        total += seen[2]
    return float(total)


@_compiled
def _ends(
    seen: F64, window: F64, tap: float, passed: float, spoken: float, at: float, taken: float
) -> float:  # fmt: skip
    """When the current, more than is taken from `at` on, no longer is, s."""
    ends = at
    for _ in range(6):  # as many as there are beginnings and ends
        following = math.inf
        for k in range(3):
            begin = (tap, passed, spoken)[k]
            if ends < begin:
                following = min(following, begin)
            elif ends < begin + window[k]:
                following = min(following, begin + window[k])
        if following == math.inf:
            break
        ends = following
        if _sum_at(seen, window, tap, passed, spoken, ends) <= taken:
            break
    return ends


@_compiled
def reset(m: Memory, tonic: F64, at: float) -> None:
    """End all inhibition by tonic neurons at a time (s): each charges from there on."""
    for p in range(tonic.shape[0]):
        for u in range(tonic.shape[1]):
            m.last[p, u] = last_spike(m, p, u, tonic[p, u], at)
            m.release[p, u] = at + WIDTH


@_compiled
def move(m: Memory, before: Lumped, after: Lumped, now: float) -> None:
    """Go on at other currents from `now` (s): what is left of each hold or period is scaled with it."""
    for p in range(before.tonic.shape[0]):
        for u in range(before.tonic.shape[1]):
            tonic = before.tonic[p, u]
            left = m.release[p, u] - now
            if left > 0.0:
                m.release[p, u] = now + left * after.hold[p, u] / before.hold[p, u]
                continue
            m.last[p, u] = last_spike(m, p, u, tonic, now)
            passed = -left - math.floor(-left / tonic) * tonic
            m.release[p, u] = now - passed * after.tonic[p, u] / tonic


@_compiled
def race(c: Lumped, m: Memory, out: F64, given: Charge, r: Race) -> float:
    """Fill both layers' latencies, and return when the emergency neuron spiked, s, inf for never.

    out: of the memories' first outputs, s, float64[n].
    """
    n = out.size
    soonest = math.inf
    for p in range(n):
        r.free[p] = _first(c, m, p, out, given)
        soonest = min(soonest, r.free[p])
    stop = soonest + c.recurrent[0]
    emergency = math.inf
    if WIDTH + c.emergency < stop:
        emergency = WIDTH + c.emergency
        stop = min(stop, emergency + c.recurrent[0])
    soonest = math.inf
    for p in range(n):
        r.first[p] = r.free[p] if r.free[p] < stop else math.inf
        r.second[p] = r.first[p] + c.second_charge[p] / c.second[p]
        soonest = min(soonest, r.second[p])
    for p in range(n):
        if not r.second[p] < soonest + c.recurrent[1]:
            r.second[p] = math.inf
    return emergency


@_compiled
def _first(c: Lumped, m: Memory, p: int, out: F64, given: Charge) -> float:
    """Latency of a cell of the first layer; equation (10) where it holds."""
    m.time[0], m.change[0], count = WIDTH, c.passive[p], 1
    if given.goal >= 0:
        current, begin = c.goal[p, given.goal], given.goal_at
        m.time[count], m.change[count] = begin, current
        m.time[count + 1], m.change[count + 1] = begin + c.goal_pulse[p], -current
        count += 2
    if given.direction == c.group[p]:
        current, begin = c.direction[p], given.direction_at
        m.time[count], m.change[count] = begin, current
        m.time[count + 1], m.change[count + 1] = begin + c.direction_pulse[p], -current
        count += 2
    for k in range(c.inhibit.shape[1]):
        q = p + k - REACH
        if 0 <= q < out.size and out[q] < math.inf:
            m.time[count], m.change[count] = out[q], -c.inhibit[p, k]
            m.time[count + 1], m.change[count + 1] = out[q] + c.inhibition[p, k], c.inhibit[p, k]
            count += 2
    return crossing(m.time, m.change, count, c.race[p])
