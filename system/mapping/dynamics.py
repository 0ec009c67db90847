"""The equations of a network, run: of the one that was asked for, and of the one that a chip makes of it.

    filter k of a neuron:  tau_k ds/dt = -s,  s + weight at each event
                           i_k = pivot_k (s / pivot_k)^power_k,  as s where power_k is 1
    neuron, i = sum of sign_k i_k / unit:
        membrane leak      tau dv/dt = i - v
        constant leak      tau dv/dt = i - 1,  v >= 0
        with an upstroke   tau dv/dt = i - 1 + e^((v - 1) / slope),  v >= 0
    spike where v comes to 1, with an upstroke to infinity; then v = 0 for the refractory period

A network that was asked for has unit 1 and powers 1; a chip's has currents in A and upstrokes
(`system.mapping.rolls`). Steps are of `STEP`, in which currents stay; a spike's time within its step is that
of the equation, with an upstroke exactly, else of a straight line. It is heard in the next step. With
y = e^((1 - v) / slope) an upstroke is linear: slope tau dy/dt = -(i - 1) y - 1, and a spike at y = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from chips.aer import Events
from circuits.arrays import F64, I64, Bools
from system.mapping.network import Network, matrix_of, spans

STEP = 1e-4  # s; ours
_STILL, _FAR = 1e-9, 500.0  # drives, or y, that count as none; exponents that no number holds beyond


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Neurons, float64[n] each unless said.

    tau : s; unit : current that just makes it fire; refractory : s; constant : whether its leak is constant,
    bool[n]; slope : of their upstrokes, None where they have none.
    """

    tau: F64
    unit: F64
    refractory: F64
    constant: Bools
    slope: F64 | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Filter:
    """Synapses whose current decays alike; sign, tau (s), power and pivot as the module says.

    neurons : weights from neurons, float64[n, n], of targets and sources; channels : those from channels of
    inputs, float64[n, channels].
    """

    sign: float
    tau: float
    neurons: F64
    channels: F64
    power: float = 1.0
    pivot: float = 1.0

    def current(self, s: F64) -> F64:
        """Current of its state, in the unit of its weights."""
        if self.power == 1.0:
            return self.sign * s
        return np.asarray(self.sign * self.pivot * (s / self.pivot) ** self.power)


@dataclass(frozen=True, slots=True, eq=False)
class Dynamics:
    """Neurons and their filters."""

    cells: Cells
    filters: tuple[Filter, ...]


class Usual(NamedTuple):
    """Rates that are usual in a network: of its neurons and of the channels of its inputs, Hz, float64[n]."""

    neurons: F64
    channels: F64


@dataclass(frozen=True, slots=True)
class Trains:
    """Spikes: times (s, float64[m]) in order, and the neuron of each, int64[m]."""

    times: F64
    neurons: I64


def asked(network: Network) -> Dynamics:
    """Return the equations of a network as it was asked for."""
    populations = network.populations
    sizes = [p.size for p in populations]
    cells = Cells(
        np.repeat([p.tau for p in populations], sizes),
        np.ones(network.neurons),
        np.repeat([p.refractory for p in populations], sizes),
        np.repeat([p.leak == "constant" for p in populations], sizes),
    )
    found = weights_by(network)
    return Dynamics(cells, tuple(Filter(1.0, tau, *found[tau]) for tau in sorted(found)))


def weights_by(network: Network) -> dict[float, tuple[F64, F64]]:
    """Return the weights from neurons and from channels of all connections, by time constant (s)."""
    at, channels = spans(network.populations), spans(network.inputs)
    found: dict[float, tuple[F64, F64]] = {}
    for one in network.connections:
        empty = np.zeros((network.neurons, network.neurons)), np.zeros((network.neurons, network.channels))
        neurons, outside = found.setdefault(one.tau, empty)
        rows = at[one.target]
        if one.source in at:
            neurons[np.ix_(rows, at[one.source])] += matrix_of(network, one)
        else:
            outside[np.ix_(rows, channels[one.source])] += matrix_of(network, one)
    return found


def run(dynamics: Dynamics, events: Events, duration: float) -> Trains:
    """Run equations from rest for `duration` s; addresses of the events are channels."""
    cells, filters = dynamics.cells, dynamics.filters
    n, steps = cells.tau.size, round(duration / STEP)
    v, wait = np.zeros(n), np.zeros(n)
    state = np.zeros((len(filters), n))
    fall = np.exp(-STEP / np.array([f.tau for f in filters]))[:, None] if filters else np.zeros((0, 1))
    inner = [np.ascontiguousarray(f.neurons.T) for f in filters]
    outer = [np.ascontiguousarray(f.channels.T) for f in filters]
    bounds = np.searchsorted(events.times, np.arange(steps + 1) * STEP - 1e-9)
    fired = np.empty(0, dtype=np.int64)
    times: list[F64] = []
    who: list[I64] = []
    for k in range(steps):
        state *= fall
        come = events.addresses[bounds[k] : bounds[k + 1]]
        for f in range(len(filters)):
            if fired.size:
                state[f] += inner[f][fired].sum(axis=0)
            if come.size:
                state[f] += outer[f][come].sum(axis=0)
        drive = sum((f.current(s) for f, s in zip(filters, state, strict=True)), np.zeros(n)) / cells.unit
        fired, share = _step(cells, v, wait, drive)
        if fired.size:
            times.append((k + share) * STEP)
            who.append(fired)
    if not times:
        return Trains(np.empty(0), np.empty(0, dtype=np.int64))
    found, neurons = np.concatenate(times), np.concatenate(who)
    order = np.argsort(found, kind="stable")
    return Trains(found[order], neurons[order])


def _step(cells: Cells, v: F64, wait: F64, drive: F64) -> tuple[I64, F64]:
    """Move v and wait by a step; the neurons that spiked, and when, in shares of the step."""
    free = np.clip(1.0 - wait / STEP, 0.0, 1.0)  # share of the step in which a neuron listens
    after, part = _plain(cells, v, free, drive) if cells.slope is None else _rising(cells, v, free, drive)
    wait[:] = np.maximum(wait - STEP, 0.0)
    fired = np.flatnonzero(part <= free)
    share = 1.0 - free[fired] + part[fired]
    wait[fired] = np.maximum(cells.refractory[fired] - (1.0 - share) * STEP, 0.0)
    after[fired] = 0.0
    v[:] = after
    return fired, share


def _plain(cells: Cells, v: F64, free: F64, drive: F64) -> tuple[F64, F64]:
    """Voltage after a step, and the share of a step until it comes to 1, infinite where it does not."""
    straight = np.maximum(v + (drive - 1.0) * free * STEP / cells.tau, 0.0)
    after = np.where(cells.constant, straight, drive + (v - drive) * np.exp(-free * STEP / cells.tau))
    moved = np.where(after >= 1.0, after - v, 1.0)
    return after, np.where((after >= 1.0) & (free > 0.0), free * (1.0 - v) / moved, np.inf)


def _rising(cells: Cells, v: F64, free: F64, drive: F64) -> tuple[F64, F64]:
    """Likewise, with an upstroke."""
    slope = np.ones(1) if cells.slope is None else cells.slope
    pace = STEP / (slope * cells.tau)
    over = np.where(np.abs(drive - 1.0) < _STILL, _STILL, drive - 1.0)
    y = np.exp((1.0 - v) / slope)
    left = 1.0 + over * y  # below 0 the spike never comes
    part = np.where(left > 0.0, np.log(np.maximum(left, _STILL)) / (over * pace), np.inf)
    moved = (y + 1.0 / over) * np.exp(-np.clip(over * pace * free, -_FAR, _FAR)) - 1.0 / over
    after = 1.0 - slope * np.log(np.clip(moved, _STILL, np.exp(1.0 / slope)))
    return after, np.where(free > 0.0, part, np.inf)


def usual_rates(network: Network, events: Events, duration: float) -> Usual:
    """Return the rates of a network as it was asked for, under events, from rest.

    Parameters
    ----------
    network
        The network.
    events
        Events of its inputs; addresses are channels, one input after the other.
    duration
        For how long it runs, s.
    """
    neurons = rates_of(run(asked(network), events, duration), network.neurons, 0.0, duration)
    channels = np.bincount(events.addresses, minlength=network.channels) / duration
    return Usual(neurons, channels)


def rates_of(trains: Trains, count: int, begin: float, end: float) -> F64:
    """Return the rate of each of `count` neurons between two times (s), Hz."""
    late = (trains.times >= begin) & (trains.times < end)
    return np.asarray(np.bincount(trains.neurons[late], minlength=count)[:count] / (end - begin))


def population_rates(network: Network, rates: F64) -> dict[str, float]:
    """Return the mean rate of each population by name, Hz, of those of all neurons."""
    return {name: float(rates[list(at)].mean()) for name, at in spans(network.populations).items()}


def chosen(trains: Trains, neurons: Sequence[int]) -> Trains:
    """Return the spikes of `neurons`, numbered in their order."""
    place = np.full(max([*neurons, int(trains.neurons.max(initial=0))]) + 1, -1)
    place[list(neurons)] = np.arange(len(neurons))
    mine = place[trains.neurons]
    return Trains(trains.times[mine >= 0], mine[mine >= 0])
