"""The equations of a network, run: of the one that was asked for, and of the one that a chip makes of it.

    filter k of a neuron:  tau_k ds/dt = -s,  s + weight at each event
                           i_k = pivot_k (s / pivot_k)^power_k,  as s where power_k is 1
    neuron, i = sum of sign_k i_k / unit:
        membrane leak      tau dv/dt = i - v
        constant leak      tau dv/dt = i - 1,  v >= 0
        with an upstroke   tau dv/dt = i - 1 + e^((v - 1) / slope),  v >= 0
    spike where v comes to 1, with an upstroke to infinity; then v = 0 for the refractory period

A network that was asked for has unit 1 and powers 1; a chip's has currents in A and upstrokes
(`system.mapping.rolls`). Steps are of `STEP`, in which currents stay at their mean, with all events of the
step as if they came at its begin; a spike's time within its step is that of the equation, with an upstroke
exactly, else of a straight line. It is heard in the next step. With
y = e^((1 - v) / slope) an upstroke is linear: slope tau dy/dt = -(i - 1) y - 1, and a spike at y = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from chips.aer import Events
from circuits.arrays import F64, I64, Bools, in_rows
from circuits.errors import DataError, ParameterError
from system.mapping.clock import with_own
from system.mapping.kernel import CellArrays, FilterArrays, Sent, StateArrays, move_all, run_steps
from system.mapping.network import Network, matrix_of, spans

STEP = 1e-4  # s; ours
MOST = 1000  # steps for whose spikes there is room at once; ours


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
        cells, n = dynamics.cells, dynamics.cells.tau.size
        own = _arrays(cells, (n,))
        self._cells = CellArrays(
            in_rows(own.tau), in_rows(own.refractory), in_rows(own.constant), in_rows(own.slope)
        )
        self._filters = _bank(dynamics)
        self._state = StateArrays(
            np.zeros(n), np.zeros(n), np.zeros((len(dynamics.filters), n)), np.zeros(n, np.bool_), np.zeros(n)
        )
        self._done = 0

    def advance(self, events: Events, duration: float) -> Trains:
        """Go on for `duration` s with events of channels; times are since the start.

        Raises `DataError` as `check_addresses`.
        """
        if self._filters.fall.size:
            check_addresses(events, self._filters.channels.shape[1])
        first, end = self._done, self._done + round(duration / STEP)
        bounds = np.searchsorted(events.times, np.arange(first, end + 1) * STEP - 1e-9)
        parts = [self._some(k, events, bounds[k - first :][: MOST + 1]) for k in range(first, end, MOST)]
        self._done = end
        found = np.concatenate([np.empty(0), *(p.times for p in parts)])
        neurons = np.concatenate([np.empty(0, dtype=np.int64), *(p.neurons for p in parts)])
        order = np.argsort(found, kind="stable")
        return Trains(found[order], neurons[order])

    def _some(self, first: int, events: Events, bounds: I64) -> Sent:
        room = (bounds.size - 1) * self._state.v.size
        found = Sent(np.empty(room), np.empty(room, dtype=np.int64))
        count = run_steps(
            self._cells, self._filters, self._state, in_rows(events.addresses), bounds, first, STEP, found
        )
        return Sent(found.times[:count].copy(), found.neurons[:count].copy())


def _arrays(cells: Cells, shape: tuple[int, ...]) -> CellArrays:
    def whole(values: F64) -> F64:
        return np.broadcast_to(values, shape)

    slope = np.zeros(1) if cells.slope is None else cells.slope
    constant = np.broadcast_to(cells.constant, shape)
    return CellArrays(whole(cells.tau), whole(cells.refractory), constant, whole(slope))


def _bank(dynamics: Dynamics) -> FilterArrays:
    filters, n = dynamics.filters, dynamics.cells.tau.size
    channels = max((f.channels.shape[1] for f in filters), default=0)
    inner, outer = np.zeros((len(filters), n, n)), np.zeros((len(filters), channels, n))
    for k, f in enumerate(filters):
        inner[k], outer[k] = f.neurons.T, f.channels.T
    shares = STEP / np.array([f.tau for f in filters])  # of a time constant
    falls = shares * np.array([f.power for f in filters])  # of a current, in logarithms
    return FilterArrays(
        fall=np.exp(-shares),
        mean=-np.expm1(-falls) / falls,
        sign=np.array([f.sign for f in filters]),
        power=np.array([f.power for f in filters]),
        pivot=np.array([f.pivot for f in filters]),
        neurons=inner,
        channels=outer,
        unit=dynamics.cells.unit,
    )


def check_addresses(events: Events, channels: int, where: str = "events", of: str = "") -> None:
    """Raise `DataError` for an event on a channel that is not there.

    channels: how many there are; where: the events' file; of: whose channels they are, in words.
    """
    wrong = np.flatnonzero((events.addresses < 0) | (events.addresses >= channels))
    if wrong.size:
        k = int(wrong[0])
        raise DataError(
            f"{where}: event {k} of address {events.addresses[k]}, must be 0 to {channels - 1}, the"
            f" channels{of}"
        )


def run(dynamics: Dynamics, events: Events, duration: float) -> Trains:
    """Run equations from rest for `duration` s; addresses of the events are channels."""
    return Running(dynamics).advance(events, duration)


def move(cells: Cells, v: F64, wait: F64, drive: F64, step: float) -> tuple[Bools, F64]:
    """Move v and wait by a step of `step` s; which neurons spiked, and when, in shares of the step.

    Arrays are of neurons, of several runs at once too, on axes before.
    """
    fired, share = np.empty(v.shape, np.bool_), np.empty(v.shape)
    move_all(_arrays(cells, v.shape), v, wait, drive, step, fired, share)
    return fired, share


def usual_rates(network: Network, events: Events, duration: float) -> Usual:
    """Return the rates of a network as it was asked for, under events, from rest.

    Parameters
    ----------
    network
        The network.
    events
        Events of its inputs from outside; addresses are channels, one input after the other.
    duration
        For how long it runs, s.

    Raises
    ------
    ParameterError
        That is less than a step of 0.1 ms.
    """
    if not STEP <= duration < np.inf:
        raise ParameterError(f"duration: {duration:g} s, must be at least a step of {STEP:g} s")
    every = with_own(network, events, 0.0, duration)
    neurons = rates_of(run(asked(network), every, duration), network.neurons, 0.0, duration)
    channels = np.bincount(every.addresses, minlength=network.channels) / duration
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
