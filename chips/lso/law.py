"""Closed forms of the sonar head: when a level unit spikes, and when an LSO neuron does.

A level unit's comparator charges its axon's input Q with I tanh(kappa x / 2 U_T), where x is by how much its
input is above the threshold. On a ramp x = S t that takes

    t = (2 U_T / (kappa S)) arcosh(exp(kappa S Q / (2 U_T I)))

At rest its comparator must know that the input is below: a copy of what the input's side of the pair carries
must exceed a share of the tail's current, else no refractory ends and the unit is deaf. With i_1 the current
that it takes, i_2 what is left of the tail's, and u(i) = 2 ln(e^sqrt(i / I_S) - 1), the input must be

    x = (U_T / kappa) (u(i_1) - u(i_2))        below the pair's own threshold.

An LSO neuron's currents are constant between the beginnings and ends of its steps. What the mirror takes
falls with the membrane, for the sink leaves saturation near ground:

    C dV/dt = I_exc - I_inh (1 - e^(-V / U_T))

With a = I_exc - I_inh, b = I_inh and y = e^(V / U_T) this is U_T C dy/dt = a y + b, so that

    y(t) = (y_0 + b / a) e^(a t / (U_T C)) - b / a,    t = (U_T C / a) ln((y + b / a) / (y_0 + b / a))

I_inh is what a mirror makes of the sum of the inhibitory currents, by the law of its two transistors. A
membrane from which more is taken than it is given rests at y = b / (b - I_exc). It reaches V_ref = Q / C,
spikes when its comparator has turned, as a level unit's on the ramp C dV/dt that goes on, is emptied for a
dead time, and begins anew from what is left. The mirror takes nothing before its own gate is charged.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from circuits.arrays import F64
from circuits.devices.ekv import argument
from circuits.lowering.on_die import Mirror

BALANCED = 1e-9  # of |a| over I_exc: below it the linear law of a = 0 is exact to rounding
LEAST = 1e-18  # A: what sums of switched currents leave by rounding is less


class Steps(NamedTuple):
    """Step currents, float64[n] each: when they begin (s, inf for never), how long they last (s), A."""

    start: F64
    last: F64
    current: F64


class Comparator(NamedTuple):
    """What ends a membrane's charge: charge of its output, C, current of its tail, A, kappa of its pair.

    lag: of what follows the pair, s.
    """

    charge: float
    current: float
    kappa: float
    lag: float


AT_ONCE = Comparator(0.0, 1.0, 1.0, 0.0)


class Membrane(NamedTuple):
    """A membrane with its comparator: capacitance (F), reference voltage (V), dead time after a spike (s).

    left: voltage after a spike, V; leak: what switches that are off take from it, A; u_t: thermal voltage, V;
    turn: charge of the inhibitory mirror's gate, C, before which it takes nothing; comparator: what delays a
    spike.
    """

    capacitance: float
    reference: float
    dead: float
    u_t: float
    turn: float
    comparator: Comparator = AT_ONCE
    leak: float = 0.0
    left: float = 0.0


def ramp_delay(slope: ArrayLike, charge: float, current: ArrayLike, kappa: float, u_t: float) -> F64:
    """Return the time from a ramp's crossing of the threshold to the spike, s.

    slope: of the ramp, V/s, above 0; charge: that the comparator's output needs, C; current: of its tail, A;
    kappa, u_t (V): of its pair. The result has the shape of slope and current.
    """
    scale = 2.0 * u_t / (kappa * np.asarray(slope, dtype=np.float64))
    x = charge / (scale * np.asarray(current, dtype=np.float64))
    # arcosh(e^x) without the overflow of e^x
    return np.asarray(scale * (x + np.log1p(np.sqrt(-np.expm1(-2.0 * x)))))


def rest_depth(tail: F64, least: F64, mirror: Mirror, pair: float, kappa: float, u_t: float) -> F64:
    """Return how far below the pair's threshold a resting input must be, V, inf where none is enough.

    tail: current of the pair, A; least: what the copy must exceed, A; mirror: arrays of one shape; pair:
    specific current of its devices, A.
    """
    own = mirror.needed(least)
    found = np.full(np.shape(own), np.inf)
    enough = own < tail
    i_1, i_2 = own[enough], (tail - own)[enough]
    found[enough] = u_t / kappa * (argument(i_1 / pair) - argument(i_2 / pair))
    return found


def mirrored(mirror: Mirror, current: float) -> float:
    """Return what a saturated mirror takes, A, where it is given a current (A)."""
    return float(mirror.copied(np.array(current))) if current > 0.0 else 0.0


def rise_time(membrane: Membrane, volts: float, given: float, taken: float) -> float:
    """Return the time from `volts` to the membrane's reference, s, inf for never.

    given, taken: currents onto the membrane and from it, A.
    """
    net, scale = given - taken, membrane.u_t * membrane.capacitance
    x, end = math.exp(volts / membrane.u_t), math.exp(membrane.reference / membrane.u_t)
    if abs(net) <= BALANCED * max(given, taken):
        return scale * (end - x) / taken if taken > 0.0 else math.inf
    if net < 0.0 and taken / -net <= end:
        return math.inf
    return scale / net * math.log((end + taken / net) / (x + taken / net))


def spike_delay(membrane: Membrane, given: float, taken: float) -> float:
    """Return the time from when a membrane passes its reference to its spike, s.

    It is that of a membrane that goes on as it rises there; arguments as of `rise_time`.
    """
    end = math.exp(-membrane.reference / membrane.u_t)
    slope = (given - taken * (1.0 - end)) / membrane.capacitance
    if slope <= 0.0:
        return math.inf
    c = membrane.comparator
    return c.lag + float(ramp_delay(slope, c.charge, c.current, c.kappa, membrane.u_t))


def moved(membrane: Membrane, volts: float, given: float, taken: float, time: float) -> float:
    """Return the membrane's voltage, V, after a time (s) in which it does not spike."""
    net, scale = given - taken, membrane.u_t * membrane.capacitance
    x = math.exp(volts / membrane.u_t)
    if abs(net) <= BALANCED * max(given, taken):
        return membrane.u_t * math.log(x + taken * time / scale)
    y = (x + taken / net) * math.exp(net * time / scale) - taken / net
    return membrane.u_t * math.log(max(y, 1.0))


def lso_spikes(excitation: Steps, inhibition: Steps, membrane: Membrane, mirror: Mirror) -> F64:
    """Return the spikes (s) of an LSO neuron whose membrane is at ground before any of its steps."""
    edges, given, sums = segments(excitation, inhibition, membrane)
    taken = [mirrored(mirror, current) for current in sums]
    spikes: list[float] = []
    volts, free = 0.0, -math.inf  # V, and from when the membrane is let go, s
    for begin, end, exc, inh in zip(edges[:-1], edges[1:], given, taken, strict=True):
        now = max(begin, free)
        while now < end:
            reached = now + rise_time(membrane, volts, exc, inh)
            if reached > end:
                volts = moved(membrane, volts, exc, inh, end - now)
                break
            spike = reached + spike_delay(membrane, exc, inh)
            spikes.append(spike)
            volts, free = membrane.left, spike + membrane.dead
            now = free
    return np.array(spikes)


def turned(inhibition: Steps, charge: float) -> Steps:
    """Return the steps, each from when all of them have charged the mirror's gate (C); their ends stay."""
    gathered, before, amperes = 0.0, -math.inf, 0.0
    for k in np.argsort(inhibition.start):
        start = float(inhibition.start[k])
        if not math.isfinite(start):
            break
        more = amperes * (start - before) if amperes else 0.0
        if gathered + more >= charge:
            break
        gathered, before, amperes = gathered + more, start, amperes + float(inhibition.current[k])
    if not amperes:
        return inhibition
    on = before + (charge - gathered) / amperes
    kept = np.isfinite(inhibition.start)
    begin, last = inhibition.start.copy(), inhibition.last.copy()
    begin[kept] = np.maximum(begin[kept], on)
    last[kept] = np.maximum(last[kept] - begin[kept] + inhibition.start[kept], 0.0)
    return Steps(begin, last, inhibition.current)


def segments(
    excitation: Steps, inhibition: Steps, membrane: Membrane
) -> tuple[list[float], list[float], list[float]]:
    """Return the edges (s) between which all currents are constant, and both sides' currents (A) there.

    What leaks from the membrane is taken from what excites it.
    """
    marks: list[tuple[float, float, float]] = []
    for k, steps in enumerate((excitation, turned(inhibition, membrane.turn))):
        on = np.isfinite(steps.start)
        for start, last, amperes in zip(steps.start[on], steps.last[on], steps.current[on], strict=True):
            change = (float(amperes), 0.0) if k == 0 else (0.0, float(amperes))
            marks += [(float(start), *change), (float(start + last), -change[0], -change[1])]
    marks.sort()
    edges, given, taken = [], [], []
    exc = inh = 0.0
    for at, more, less in marks:
        edges.append(at)
        exc, inh = exc + more, inh + less
        given.append(max(exc - membrane.leak, 0.0) if exc > LEAST else 0.0)
        taken.append(inh if inh > LEAST else 0.0)
    return edges, given[:-1], taken[:-1]
