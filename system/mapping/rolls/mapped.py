"""A network as it stands on ROLLS: where its neurons are, what they and the filters do, and its program.

Events of an input go to virtual synapses, so many a neuron as the weight asks for: the first four at once,
each on a synapse of its own, the next four `SPACING` later, when the pulses before have ended.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from chips.aer import Events
from chips.rolls.chip import Inputs
from chips.rolls.circuit import FILTERS
from chips.rolls.program.address import VIRTUAL_LINES
from chips.rolls.program.program import Program, VirtualInput
from circuits.arrays import F64, I64
from circuits.compiled import compiled
from system.mapping.clock import own_rates, with_own
from system.mapping.dynamics import Cells, Dynamics, Filter, check_addresses
from system.mapping.network import Network
from system.mapping.report import Finding

SPACING = 0.2e-3  # s, two and a half times a pulse; ours
SERVICE = 0.2e-6  # s between two events of one that reaches many: twice what the bus takes; ours
_compiled = compiled()


@dataclass(frozen=True, slots=True)
class Placed:
    """Where a population stands, and what its neurons are on the nominal die.

    name : its name; first : its first neuron on the chip, the others follow; slow : whether its leak is
    IF_TAU1; tau : T of the integrator, s; slope : d of its upstroke; rheobase : least current that makes it
    fire, A; refractory : for how long it does not listen after a spike, s; current : A that stand for 1 in
    the network.
    """

    name: str
    first: int
    slow: bool
    tau: float
    slope: float
    rheobase: float
    refractory: float
    current: float


@dataclass(frozen=True, slots=True)
class PlacedFilter:
    """What a filter does on the nominal die.

    name : its name; tau : time constant, s; power : of its current over what comes in; pivot : current at
    which both are alike, A; weights : of levels 1 to 4, or of an event of a virtual synapse, A.
    """

    name: str
    tau: float
    power: float
    pivot: float
    weights: tuple[float, ...]

    def rate(self, current: float, weight: float) -> float:
        """Events a second of a weight that bring a current, both A."""
        strength = self.pivot * (current / self.pivot) ** (1.0 / self.power)
        return float(strength / (weight * self.tau))


@dataclass(frozen=True, slots=True, eq=False)
class Mapped:
    """A network on ROLLS.

    network : what was asked for.
    placed : its populations on the chip.
    filters : those that are in use.
    program : what is written to the chip.
    excite, inhibit : events of a virtual synapse that stand for one of a channel, int64[channels, neurons].
    findings : what is exact and what is approximate.
    """

    network: Network
    placed: tuple[Placed, ...]
    filters: tuple[PlacedFilter, ...]
    program: Program
    excite: I64
    inhibit: I64
    findings: tuple[Finding, ...]

    @property
    def neurons(self) -> I64:
        """Neurons of the chip, in the order of the network's, int64[n]."""
        sizes = {p.name: p.size for p in self.network.populations}
        return np.concatenate([np.arange(p.first, p.first + sizes[p.name]) for p in self.placed])

    def dynamics(self) -> Dynamics:
        """Return the equations of the network as the nominal die has them."""
        sizes = [p.size for p in self.network.populations]
        tau, unit, refractory, slope = (
            np.repeat([getattr(p, name) for p in self.placed], sizes)
            for name in ("tau", "rheobase", "refractory", "slope")
        )
        cells = Cells(tau, unit, refractory, np.ones(self.network.neurons, dtype=np.bool_), slope)
        return Dynamics(cells, tuple(self._filter(f) for f in self.filters))

    def events(self, events: Events) -> Inputs:
        """Return the chip's events that stand for those of the network's channels.

        Raises `DataError` for an event on a channel that the network does not have.
        """
        check_addresses(events, self.network.channels)
        burst = _burst(self)
        count = int(np.diff(burst.begin)[events.addresses].sum())
        times, words = np.empty(count), np.empty(count, np.int64)
        _spread(events.times, events.addresses, *burst, times, words)
        return Inputs(times, words & 255, words >> 8)

    def _filter(self, one: PlacedFilter) -> Filter:
        n, at = self.network.neurons, self.neurons
        sign = -1.0 if "inhibitory" in one.name else 1.0
        neurons: F64 = np.zeros((n, n))
        channels: F64 = np.zeros((n, self.network.channels))
        if one.name in FILTERS[:2]:
            levels = int(sign) * self.program.levels[np.ix_(at, at)].astype(np.int64)
            neurons = np.concatenate(([0.0], one.weights))[np.maximum(levels, 0)]
        else:
            channels += one.weights[0] * (self.inhibit if sign < 0.0 else self.excite).T
        return Filter(sign, one.tau, neurons, channels, one.power, one.pivot)


@dataclass(frozen=True, slots=True)
class OwnEvents:
    """What a mapped network's inputs send by themselves, as events of a live chip.

    mapped : the network; longest : s that an event's last one on the chip is behind its first.
    """

    mapped: Mapped
    longest: float

    def __call__(self, begin: float, end: float) -> tuple[F64, I64]:
        """Return times, s, from `begin` until before `end`, and addresses of synapses."""
        nothing = Events(np.empty(0), np.empty(0, dtype=np.int64))
        found = self.mapped.events(
            with_own(self.mapped.network, nothing, max(begin - self.longest, 0.0), end)
        )
        mine = (found.times >= begin) & (found.times < end)
        return found.times[mine], (found.neurons + (found.columns << 8))[mine]


def own_events(mapped: Mapped) -> OwnEvents | None:
    """Return what the inputs of a mapped network send by themselves; None where all events are of outside."""
    if not own_rates(mapped.network).any():
        return None
    return OwnEvents(mapped, float(_burst(mapped).later.max(initial=0.0)))


def virtual_inputs(size: int, excite: I64, inhibit: I64) -> tuple[VirtualInput, ...]:
    """Return what a program states of the virtual synapses of its first `size` neurons, those in use."""
    return tuple(
        VirtualInput(name, tuple(range(size)), VIRTUAL_LINES, inhibitory=name == "inhibit")
        for name, counts in (("excite", excite), ("inhibit", inhibit))
        if counts.any()
    )


def fan_out(mapped: Mapped) -> Mapping[str, int]:
    """Return how many events of the chip the busiest channel of each input becomes."""
    found, first = {}, 0
    for each in mapped.network.inputs:
        rows = slice(first, first + each.size)
        found[each.name] = int((mapped.excite[rows] + mapped.inhibit[rows]).sum(axis=1).max())
        first += each.size
    return found


class _Burst(NamedTuple):
    """What one event of each channel becomes: those of channel c stand from `begin[c]` to `begin[c + 1]`.

    begin : int64[channels + 1]; later : s after the event, rising; words : neuron + (column << 8), int64.
    """

    begin: I64
    later: F64
    words: I64


@lru_cache(maxsize=8)
def _burst(mapped: Mapped) -> _Burst:
    virtual, signs = mapped.program.virtual, ((mapped.excite, False), (mapped.inhibit, True))
    parts = [
        _sign(counts, virtual.columns(inhibitory=inhibitory).start, mapped.neurons)
        for counts, inhibitory in signs
    ]
    channel, later, words = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.lexsort((later, channel))
    begin = np.searchsorted(channel[order], np.arange(mapped.network.channels + 1))
    return _Burst(begin, later[order], words[order])


def _sign(counts: I64, column: int, at: I64) -> tuple[I64, F64, I64]:
    """Channels, times after it and words of what one sign makes of one event of each channel."""
    channel, neuron = np.nonzero(counts)
    repeats = counts[channel, neuron]
    channel, neuron = np.repeat(channel, repeats), np.repeat(neuron, repeats)
    place = np.arange(channel.size) - np.repeat(np.cumsum(repeats) - repeats, repeats)  # of an event's own
    begin = np.searchsorted(channel, np.arange(counts.shape[0] + 1))
    later = (place // VIRTUAL_LINES) * SPACING + (np.arange(channel.size) - begin[channel]) * SERVICE
    return channel, later, at[neuron] + ((column + place % VIRTUAL_LINES) << 8)


@_compiled
def _spread(
    times: F64, channels: I64, begin: I64, later: F64, words: I64, all_times: F64, all_words: I64
) -> None:
    """Fill `all_times` and `all_words` with what events of channels become, in the order of their times.

    Of what comes at one time the earlier event's is first. What an event becomes is in order, and is merged
    from its last one on into what stands there, of which few are later.
    """
    count = 0
    for k in range(times.size):
        first, j = begin[channels[k]], begin[channels[k] + 1] - 1
        before, count = count - 1, count + j + 1 - first
        at = count - 1
        while j >= first:
            mine = times[k] + later[j]
            if before >= 0 and all_times[before] > mine:
                all_times[at], all_words[at] = all_times[before], all_words[before]
                before -= 1
            else:
                all_times[at], all_words[at] = mine, words[j]
                j -= 1
            at -= 1
