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


class Running:
    """Equations that go on from rest by one time after the other.

    Parameters
    ----------
    dynamics
        The equations.
    """

    def __init__(self, dynamics: Dynamics) -> None:
        cells, filters = dynamics.cells, dynamics.filters
        self._cells, self._filters, self._done = cells, filters, 0
        self._v, self._wait = np.zeros((2, cells.tau.size))
        self._state = np.zeros((len(filters), cells.tau.size))
        self._fall = np.exp(-STEP / np.array([f.tau for f in filters]))[:, None]
        self._inner = [np.ascontiguousarray(f.neurons.T) for f in filters]
        self._outer = [np.ascontiguousarray(f.channels.T) for f in filters]
        self._fired = np.empty(0, dtype=np.int64)

    def advance(self, events: Events, duration: float) -> Trains:
        """Go on for `duration` s with events of channels; times are since the start."""
        steps = range(self._done, self._done + round(duration / STEP))
        bounds = np.searchsorted(events.times, np.array([*steps, steps.stop]) * STEP - 1e-9)
        times: list[F64] = [np.empty(0)]
        who: list[I64] = [np.empty(0, dtype=np.int64)]
        for k, begin, end in zip(steps, bounds[:-1], bounds[1:], strict=True):
            share = self._take(events.addresses[begin:end])
            if self._fired.size:
                times.append((k + share) * STEP)
                who.append(self._fired)
        self._done = steps.stop
        found, neurons = np.concatenate(times), np.concatenate(who)
        order = np.argsort(found, kind="stable")
        return Trains(found[order], neurons[order])

    def _take(self, come: I64) -> F64:
        """Take a step in which events of these channels come; when the neurons spiked, in shares of it."""
        cells, state, fired = self._cells, self._state, self._fired
        state *= self._fall
        for f in range(len(self._filters)):
            if fired.size:
                state[f] += self._inner[f][fired].sum(axis=0)
            if come.size:
                state[f] += self._outer[f][come].sum(axis=0)
        each = (f.current(s) for f, s in zip(self._filters, state, strict=True))
        drive = sum(each, np.zeros(cells.tau.size)) / cells.unit
        spiked, share = move(cells, self._v, self._wait, drive)
        self._fired = np.flatnonzero(spiked)
        return np.asarray(share[self._fired])


def run(dynamics: Dynamics, events: Events, duration: float) -> Trains:
    """Run equations from rest for `duration` s; addresses of the events are channels."""
    return Running(dynamics).advance(events, duration)


def move(cells: Cells, v: F64, wait: F64, drive: F64, step: float = STEP) -> tuple[Bools, F64]:
    """Move v and wait by a step of `step` s; which neurons spiked, and when, in shares of the step.

    Arrays are of neurons, of several runs at once too, on axes before.
    """
    free = np.clip(1.0 - wait / step, 0.0, 1.0)  # share of the step in which a neuron listens
    rule = _plain if cells.slope is None else _rising
    after, part = rule(cells, v, free, drive, step)
    fired = part <= free
    share = np.where(fired, 1.0 - free + part, 1.0)
    held = np.maximum(cells.refractory - (1.0 - share) * step, 0.0)
    wait[...] = np.where(fired, held, np.maximum(wait - step, 0.0))
    v[...] = np.where(fired, 0.0, after)
    return fired, share


def _plain(cells: Cells, v: F64, free: F64, drive: F64, step: float) -> tuple[F64, F64]:
    """Voltage after a step, and the share of a step until it comes to 1, infinite where it does not."""
    straight = np.maximum(v + (drive - 1.0) * free * step / cells.tau, 0.0)
    after = np.where(cells.constant, straight, drive + (v - drive) * np.exp(-free * step / cells.tau))
    moved = np.where(after >= 1.0, after - v, 1.0)
    return after, np.where((after >= 1.0) & (free > 0.0), free * (1.0 - v) / moved, np.inf)


def _rising(cells: Cells, v: F64, free: F64, drive: F64, step: float) -> tuple[F64, F64]:
    """Likewise, with an upstroke."""
    slope = np.ones(1) if cells.slope is None else cells.slope
    pace = step / (slope * cells.tau)
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
