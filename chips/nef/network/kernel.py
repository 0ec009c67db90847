"""Compiled run of a network of ideal spiking neurons, whose weights are factored in decoders and encoders.

A time step of `DT`: lanes low-pass what spikes and nodes have put on them, y += (raw - y)(1 - e^(-DT / tau)),
and add up in slots; encoders make currents of slots; neurons take a step; each spike puts its decoders, over
DT, on lanes. So a spike acts one step later, as in nengo.

`update` is all that is known about the neurons: leaky integrate-and-fire (Stöckel 2017, II.B), solved exactly
over what the refractory period leaves of a step at constant current, the spike placed where u reaches 1.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled

DT = 1e-3  # s; nengo's
_compiled = compiled()


class Net(NamedTuple):
    """A network: population p has neurons begin[p]:begin[p + 1] and slots slot[p]:slot[p + 1].

    bias: float64[neurons]; row: where a slot's encoders begin in `encoder`, a number a neuron of its
    population, int64[slots]; lane: where a population's lanes begin in `reaches`, which has lanes,
    int64[populations + 1]; decoder: neuron after neuron, a number a lane, over DT, float64; block: where a
    population's decoders begin, int64[populations]; keep: e^(-DT / tau), float64[lanes]; goes: slot of a
    lane, or -1, int64[lanes]; tau_rc, tau_ref: s.
    """

    begin: I64
    slot: I64
    bias: F64
    row: I64
    encoder: F64
    lane: I64
    reaches: I64
    decoder: F64
    block: I64
    keep: F64
    goes: I64
    tau_rc: float
    tau_ref: float


class State(NamedTuple):
    """State of a network, overwritten in place.

    u, rest: membrane, and what is left of the refractory period at the beginning of the step, s,
    float64[neurons]; current: float64[neurons]; fired: working space, spikes: since the start,
    int64[neurons]; held, raw, y: what nodes add, what spikes have added, and both low-passed, float64[lanes];
    x: float64[slots].
    """

    u: F64
    rest: F64
    current: F64
    fired: I64
    spikes: I64
    held: F64
    raw: F64
    y: F64
    x: F64


def new_state(net: Net) -> State:
    """Return a network at rest."""
    neurons, lanes = len(net.bias), len(net.keep)
    return State(
        np.zeros(neurons), np.zeros(neurons), np.zeros(neurons), np.zeros(neurons, dtype=np.int64),
        np.zeros(neurons, dtype=np.int64), np.zeros(lanes), np.zeros(lanes), np.zeros(lanes),
        np.zeros(len(net.row)),
    )  # fmt: skip


@_compiled
def advance(n: Net, s: State, steps: int) -> None:
    """Take time steps of `DT`."""
    for _ in range(steps):
        collect(n, s)
        for p in range(n.begin.size - 1):
            encode(n, s, p)
            fired = update(s.u, s.rest, s.current, s.fired, n.begin[p], n.begin[p + 1], n.tau_rc, n.tau_ref)
            decode(n, s, p, fired)


@_compiled
def collect(n: Net, s: State) -> None:
    """Low-pass the lanes and add them up in slots."""
    for k in range(s.x.size):
        s.x[k] = 0.0
    for k in range(s.y.size):
        now = s.raw[k] + s.held[k]
        s.y[k] = now + n.keep[k] * (s.y[k] - now)
        s.raw[k] = 0.0
        if n.goes[k] >= 0:
            s.x[n.goes[k]] += s.y[k]


@_compiled
def encode(n: Net, s: State, p: int) -> None:
    """Fill the currents of population p: its slots' encoders times their values, and the bias."""
    first, count = n.begin[p], n.begin[p + 1] - n.begin[p]
    current = s.current[first : first + count]
    bias = n.bias[first : first + count]
    for i in range(count):
        current[i] = bias[i]
    for k in range(n.slot[p], n.slot[p + 1]):
        row = n.encoder[n.row[k] : n.row[k] + count]
        x = s.x[k]
        for i in range(count):
            current[i] += x * row[i]


@_compiled
def update(
    u: F64, rest: F64, current: F64, fired: I64, begin: int, end: int, tau_rc: float, tau_ref: float
) -> int:
    """Step neurons begin:end; fill `fired` with the numbers of those that fire, and return how many."""
    count = end - begin
    v, r, j = u[begin:end], rest[begin:end], current[begin:end]
    scale = 1.0 / tau_rc
    quick = DT * scale > 0.05  # beyond which the sum below is not 1 - e^-a within 3e-9
    for i in range(count):
        a = scale * min(max(DT - r[i], 0.0), DT)
        rise = -math.expm1(-a) if quick else a * (1.0 - a * (0.5 - a * (1.0 / 6.0 - a * (1.0 / 24.0))))
        v[i] = max(v[i] + (j[i] - v[i]) * rise, 0.0)
        r[i] -= DT
    found = 0
    for i in range(count):
        if v[i] > 1.0:
            fired[found] = i
            found += 1
    for k in range(found):
        i = fired[k]
        r[i] = tau_ref + tau_rc * math.log1p((1.0 - v[i]) / (j[i] - 1.0))
        v[i] = 0.0
    return found


@_compiled
def decode(n: Net, s: State, p: int, fired: int) -> None:
    """Put the decoders of spikes of population p on its lanes."""
    first, lane, count = n.begin[p], n.lane[p], n.lane[p + 1] - n.lane[p]
    for k in range(fired):
        i = s.fired[k]
        s.spikes[first + i] += 1
        begin = n.block[p] + i * count
        for q in range(count):
            s.raw[n.reaches[lane + q]] += n.decoder[begin + q]
