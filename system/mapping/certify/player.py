"""A network that a task plays with, window after window: mapped on a die, or the equations that were asked.

    network = Player(...)
    network.begin(3)                            at rest, with the noise of sample 3
    spikes = network(rates, window)             of each output, over a window

A call gives each channel evenly spaced events at its rate, whose phases go on from window to window, and
returns how often the neurons of each output spiked. A task sees no more, so that it cannot tell a die from
the ideal. A die's noise is that of the sample's number under the run's seed, whatever was run before it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from chips.aer import Events
from chips.noise import SiliconNoise
from chips.rolls.chip import STEP, RollsChip
from circuits.arrays import F64, I64
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.silicon import Silicon
from system.mapping.clock import outside, with_own_rates
from system.mapping.dynamics import Running, Trains, asked
from system.mapping.network import Network, spans
from system.mapping.rolls.mapped import Mapped

MOST = 1e4  # Hz of a channel; ours


def check_window(window: float) -> None:
    """Raise `ParameterError` for a window, s, that is not whole steps of the chip."""
    steps = round(window / STEP) if np.isfinite(window) else 0
    if steps < 1 or abs(steps * STEP - window) > 1e-9:
        raise ParameterError(f"task.window: {window:g} s, must be whole steps of {STEP:g} s; round it")


class Player(ABC):
    """A network that goes on by windows.

    Parameters
    ----------
    network
        The network; its probes are the outputs.

    Raises
    ------
    ParameterError
        It has no probe.
    """

    def __init__(self, network: Network) -> None:
        if not network.probes:
            raise ParameterError("program: no probe, must have one for each output; add them and map again")
        self._network, self.channels, self.lost = network, outside(network).size, 0
        at = spans(network.populations)
        self._outputs = [at[probe.population] for probe in network.probes]
        self._phase, self._time, self._number = self._start(), 0.0, -1

    @property
    def outputs(self) -> int:
        """How many outputs it has."""
        return len(self._outputs)

    def begin(self, number: int | None = None) -> None:
        """Put the network to rest, where a sample begins.

        Parameters
        ----------
        number
            That of the sample, from 0 on, by which its noise is drawn; the next one unless given.

        Raises
        ------
        ParameterError
            The number is not whole, or below 0.
        """
        number = self._number + 1 if number is None else number
        if number != round(number) or number < 0:
            raise ParameterError(f"task.begin: sample {number}, must be a whole number from 0 on")
        self._number = round(number)
        self._phase, self._time = self._start(), 0.0
        self._rest(self._number)

    def __call__(self, rates: ArrayLike, window: float) -> F64:
        """Go on for a window with events of all channels at some rates, and return spikes of each output.

        Parameters
        ----------
        rates
            Of each channel of outside, Hz, float64[channels].
        window
            How long, s, in whole steps of the chip of 0.4 ms.

        Raises
        ------
        ParameterError
            There are not as many rates as channels, one is below 0 or above 10 kHz, or the window is none.
        """
        given = np.asarray(rates, dtype=np.float64).ravel()
        if given.size != self.channels or not ((given >= 0.0) & (given <= MOST)).all():
            raise ParameterError(
                f"task.rates: {given.size} from {given.min(initial=0.0):g} to {given.max(initial=0.0):g} Hz,"
                f" must be {self.channels} from 0 to {MOST:g} Hz, one each channel"
            )
        check_window(window)
        trains = self._advance(self._events(with_own_rates(self._network, given), window), window)
        self._time += window
        counts = np.bincount(trains.neurons, minlength=max(at.stop for at in self._outputs))
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
    def _rest(self, number: int) -> None:
        """Put what runs to rest, with the noise of sample `number`."""

    @abstractmethod
    def _advance(self, events: Events, window: float) -> Trains:
        """Go on, and return the spikes, numbered as in the network."""


@final
class IdealPlayer(Player):
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
class ChipPlayer(Player):
    """A mapped network on a die."""

    def __init__(self, mapped: Mapped, silicon: Silicon, kind: BiasKind, noise: SiliconNoise | None) -> None:
        super().__init__(mapped.network)
        self._mapped, self._chip = mapped, RollsChip(mapped.program, silicon, kind, noise=noise)
        self._place: I64 = np.full(256, -1)
        self._place[mapped.neurons] = np.arange(mapped.network.neurons)
        self._first = self._state = self._chip.at_rest()

    def _rest(self, number: int) -> None:
        self._chip, self._state = self._chip.in_trial(number), self._first

    def _advance(self, events: Events, window: float) -> Trains:
        spikes, self._state = self._chip.run(self._state, window, self._mapped.events(events))
        self.lost += spikes.lost_in + spikes.lost_out
        mine = self._place[spikes.neurons]
        return Trains(spikes.times[mine >= 0], mine[mine >= 0])
