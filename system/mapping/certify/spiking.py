"""A network of populations that a task plays with: the equations that were asked, or ROLLS on a die.

A window gives each channel evenly spaced events at its rate, whose phases go on from window to window.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import partial
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from chips.aer import Events
from chips.noise import SiliconNoise
from chips.rolls.chip import Inputs, RollsChip, Spikes
from circuits.arrays import F64, I64
from circuits.circuit import BiasKind
from circuits.silicon.silicon import Silicon
from system.mapping.certify.encoding import wiring_of
from system.mapping.certify.ends import ends_of
from system.mapping.certify.player import Player
from system.mapping.clock import with_own_rates
from system.mapping.dynamics import Running, Trains, asked
from system.mapping.network import Network, spans
from system.mapping.rolls.mapped import Mapped


class SpikingPlayer(Player):
    """A network of populations that goes on by windows.

    Parameters
    ----------
    network
        The network; its probes are the outputs, each as its population spikes.

    Raises
    ------
    ParameterError
        It has no probe.
    """

    def __init__(self, network: Network) -> None:
        super().__init__(ends_of(network))
        self._network, at = network, spans(network.populations)
        self._outputs = [at[probe.population] for probe in network.probes]
        self._phase, self._time = self._start(), 0.0

    def begin(self, number: int | None = None) -> None:
        """Put the network to rest, as of any player."""
        super().begin(number)
        self._phase, self._time = self._start(), 0.0

    def _go_on(self, inputs: F64, window: float) -> F64:
        trains = self._advance(self._events(with_own_rates(self._network, inputs), window), window)
        self._time += window
        return self._counted(trains.neurons)

    def _counted(self, neurons: I64) -> F64:
        """How many spikes of these neurons of the network are each output's, float64[outputs]."""
        counts = np.bincount(neurons, minlength=max(at.stop for at in self._outputs))
        return np.array([counts[at.start : at.stop].sum() for at in self._outputs], dtype=np.float64)

    def _events(self, rates: F64, window: float) -> Events:
        end = self._phase + rates * window
        counts = np.floor(end).astype(np.int64)
        channels = np.repeat(np.arange(rates.size), counts)
        number = np.arange(channels.size) - np.repeat(np.cumsum(counts) - counts, counts) + 1
        times = self._time + (number - self._phase[channels]) / rates[channels]
        self._phase = end - counts
        order = np.argsort(times, kind="stable")
        latest = np.nextafter(self._time + window, -np.inf)
        return Events(np.minimum(times[order], latest), channels[order])

    def _start(self) -> F64:
        return np.linspace(0.0, 1.0, self._network.channels, endpoint=False)

    @abstractmethod
    def _advance(self, events: Events, window: float) -> Trains:
        """Go on, and return the spikes, numbered as in the network."""


@final
class IdealPlayer(SpikingPlayer):
    """The network as it was asked for."""

    def __init__(self, network: Network) -> None:
        super().__init__(network)
        self._dynamics = asked(network)
        self._rest(0)

    def _rest(self, number: int) -> None:
        self._running = Running(self._dynamics)

    def _advance(self, events: Events, window: float) -> Trains:
        return self._running.advance(events, window)


@final
class ChipPlayer(SpikingPlayer):
    """A mapped network on a die; of the chip runs what its neurons need."""

    def __init__(self, mapped: Mapped, silicon: Silicon, kind: BiasKind, noise: SiliconNoise | None) -> None:
        super().__init__(mapped.network)
        whole, used = RollsChip(mapped.program, silicon, kind, noise=noise), int(mapped.neurons.max()) + 1
        self._mapped, self._wiring = mapped, wiring_of(mapped, whole.bus, whole.step)
        self._chip, self._first = whole.of_first(used, whole.at_rest())
        self._place: I64 = np.full(256, -1)
        self._place[mapped.neurons] = np.arange(mapped.network.neurons)
        self._state = self._first

    def answer(self, number: int, inputs: ArrayLike, window: float) -> F64:
        """Return the outputs over a window from rest, as of any player."""
        given = self._given(inputs, window)
        self.begin(number)
        rates = with_own_rates(self._network, given)
        events = partial(self._inputs, rates, window)
        encoded = self._wiring.encoded(rates, window, events)
        spikes = None if encoded is None else self._chip.run_encoded(self._first, encoded)
        if spikes is None:
            return super().answer(number, inputs, window)
        return self._counted(self._mine(spikes).neurons)

    def _inputs(self, rates: F64, window: float) -> Inputs:
        events = self._events(rates, window)
        self._phase = self._start()
        return self._mapped.events(events)

    def _rest(self, number: int) -> None:
        self._chip, self._state = self._chip.in_trial(number), self._first

    def _advance(self, events: Events, window: float) -> Trains:
        spikes, self._state = self._chip.run(self._state, window, self._mapped.events(events))
        return self._mine(spikes)

    def _mine(self, spikes: Spikes) -> Trains:
        """The network's spikes among the chip's, whose losses are counted."""
        self.lost += spikes.lost_in + spikes.lost_out
        mine = self._place[spikes.neurons]
        return Trains(spikes.times[mine >= 0], mine[mine >= 0])
