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
spikes when its comparator has turned, as a level unit's on the ramp C dV/dt that goes on, and is emptied
for a dead time. What a mirror carries follows the sum S as its gate is charged, each factor e by Q_e:

    dI/dt = I (S - I) / Q_e,    int I dt = Q_e ln(1 + (I_0 / S) (e^(S t / Q_e) - 1))

which is Q_e ln(1 + I_0 t / Q_e) for S = 0. It is taken in pieces of constant current, each of which has the
charge of that law.
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


class Gate(NamedTuple):
    """The gate of a mirror.

    charge: what it takes from rest until its diode carries `current` (A), C; fold: what it takes then for
    each factor e of the current, C.
    """

    charge: float
    current: float
    fold: float


class Membrane(NamedTuple):
    """A membrane with its comparator: capacitance (F), reference voltage (V), dead time after a spike (s).

    leak: what switches that are off take from it, A; u_t: thermal voltage, V; comparator: what delays a
    spike; gate: of the inhibitory mirror, None for one that follows at once.
    """

    capacitance: float
    reference: float
    dead: float
    u_t: float
    comparator: Comparator = AT_ONCE
    leak: float = 0.0
    gate: Gate | None = None


def ramp_delay(slope: ArrayLike, charge: ArrayLike, current: ArrayLike, kappa: ArrayLike, u_t: float) -> F64:
    """Return the time from a ramp's crossing of the threshold to the spike, s.

    slope: of the ramp, V/s, above 0; charge: that the comparator's output needs, C; current: of its tail, A;
    kappa, u_t (V): of its pair. The result has the shape of all.
    """
    scale = 2.0 * u_t / (np.asarray(kappa) * np.asarray(slope, dtype=np.float64))
    x = np.asarray(charge) / (scale * np.asarray(current, dtype=np.float64))
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


def mirrored(mirror: Mirror, currents: ArrayLike) -> F64:
    """Return what a saturated mirror takes, A, where it is given currents (A), in their shape."""
    given = np.asarray(currents, dtype=np.float64)
    taken = np.zeros(given.shape)
    taken[given > 0.0] = mirror.copied(given[given > 0.0])
    return taken


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
    taken = mirrored(mirror, sums).tolist()
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
            volts, free = 0.0, spike + membrane.dead
            now = free
    return np.array(spikes)


def carried(edges: list[float], sums: list[float], gate: Gate) -> tuple[list[float], list[float]]:
    """Return edges (s) between which what a mirror carries is taken as constant, and that current (A).

    edges, sums: between which the current into its diode is constant, one more than that, and it, A.
    """
    rest = gate.current * math.exp(-gate.charge / gate.fold)
    now, marks, found = rest, [edges[0]], []
    for begin, end, given in zip(edges[:-1], edges[1:], sums, strict=True):
        first, before, past = now, begin, 0.0
        for at in [*_cuts(begin, end, given, first, gate.fold), end]:
            gone, now = _carried(at - begin, given, first, gate.fold)
            marks.append(at)
            found.append((gone - past) / (at - before))
            before, past = at, gone
        now = max(now, rest)
    return marks, found


def _carried(time: float, given: float, first: float, fold: float) -> tuple[float, float]:
    """The charge (C) that a mirror has carried after a time (s), and its current (A) then.

    given: into its diode, A; first: what it carries at first, A; fold: charge of a factor e, C.
    """
    if given <= LEAST:
        grown = 1.0 + first * time / fold
        return fold * math.log(grown), first / grown
    x, part = given * time / fold, first / given
    left = part + (1.0 - part) * math.exp(-x)
    return fold * (x + math.log(left)), first / left


def _cuts(begin: float, end: float, given: float, first: float, fold: float) -> list[float]:
    """Where what a mirror carries is cut into pieces between two times, s; arguments as of `_carried`."""
    last = end - begin
    if given <= LEAST:
        scale, n = fold / first, 0
        found = []
        while scale * 3.0**n < last:
            found.append(begin + scale * 3.0**n)
            n += 1
        return found
    scale = fold / given
    middle = scale * math.log(given / first) if given > first else 0.0
    return [begin + t for k in (-3.0, -1.0, 1.0, 3.0) if 0.0 < (t := middle + k * scale) < last]


def segments(
    excitation: Steps, inhibition: Steps, membrane: Membrane
) -> tuple[list[float], list[float], list[float]]:
    """Return the edges (s) between which all currents are constant, and both sides' currents (A) there.

    What leaks from the membrane is taken from what excites it, and what inhibits it is what the mirror
    carries.
    """
    excited, given = _sums(excitation)
    inhibited, taken = _sums(inhibition)
    if inhibited and membrane.gate is not None:
        late = max(inhibited[-1], excited[-1] if excited else -math.inf)
        more = [late] if late > inhibited[-1] else []
        inhibited, taken = carried([*inhibited, *more], [*taken[:-1], *(0.0 for _ in more)], membrane.gate)
        taken.append(0.0)
    edges = sorted({*excited, *inhibited})
    exc, inh = (_held(edges, *each) for each in ((excited, given), (inhibited, taken)))
    return edges, [max(i - membrane.leak, 0.0) if i > LEAST else 0.0 for i in exc[:-1]], inh[:-1]


def _sums(steps: Steps) -> tuple[list[float], list[float]]:
    """The edges (s) of steps, and the sum of their currents (A) from each on."""
    on = np.isfinite(steps.start)
    marks = sorted(
        mark
        for start, last, amperes in zip(steps.start[on], steps.last[on], steps.current[on], strict=True)
        for mark in ((float(start), float(amperes)), (float(start + last), -float(amperes)))
    )
    edges: list[float] = []
    sums: list[float] = []
    total = 0.0
    for at, change in marks:
        total += change
        if not edges or at > edges[-1]:
            edges.append(at)
            sums.append(0.0)
        sums[-1] = total if total > LEAST else 0.0
    return edges, sums


def _held(edges: list[float], at: list[float], values: list[float]) -> list[float]:
    """The value that holds from each edge on, 0 before the first: `values` from `at` on, both in order."""
    place = np.searchsorted(at, edges, side="right") - 1
    return [values[k] if k >= 0 else 0.0 for k in place]
