"""A network of values that a task plays with: the equations that were asked for, or the NEF chip on a die.

In a window inputs stand still. An output is the mean of what its probe shows at the end of each step of 1 ms.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from typing import final

from chips.nef.build import Built, drawn_anew, noisy
from chips.nef.network.kernel import DT
from chips.nef.simulation import Simulation
from chips.noise import SiliconNoise
from circuits.arrays import F64
from system.mapping.certify.ends import ends_of, outputs_of
from system.mapping.certify.player import Player
from system.mapping.nef.equations import Equations
from system.mapping.nef.network import ValueNetwork


class ValuePlayer(Player):
    """A network of values that goes on by windows.

    Parameters
    ----------
    network
        The network; the numbers that its probes show are the outputs.

    Raises
    ------
    ParameterError
        It has no probe.
    """

    def __init__(self, network: ValueNetwork) -> None:
        super().__init__(ends_of(network))
        self._inputs = [(one.name, one.size) for one in network.inputs]
        self._probes = [name for name, _ in outputs_of(network)]

    def _go_on(self, inputs: F64, window: float) -> F64:
        running, first = self._runs(), 0
        for name, size in self._inputs:
            running.set(name, inputs[first : first + size])
            first += size
        steps = round(window / DT)
        return running.summed(self._probes, steps) / steps

    @abstractmethod
    def _runs(self) -> Equations | Simulation:
        """Return what runs."""


@final
class AskedPlayer(ValuePlayer):
    """The network as it was asked for, without neurons."""

    def __init__(self, network: ValueNetwork) -> None:
        super().__init__(network)
        self._network = network
        self._rest(0)

    def _rest(self, number: int) -> None:
        self._running = Equations(self._network)

    def _runs(self) -> Equations:
        return self._running


@final
class NeuronPlayer(ValuePlayer):
    """The network on neurons.

    Parameters
    ----------
    network
        The network; the numbers that its probes show are the outputs.
    built
        The same on ideal neurons, or on a die.
    noise
        Of the die's devices; None for none.

    Raises
    ------
    ParameterError
        It has no probe.
    """

    def __init__(self, network: ValueNetwork, built: Built, noise: SiliconNoise | None = None) -> None:
        super().__init__(network)
        self._built, self._noise = noisy(built, noise) if noise else built, noise
        self._rest(0)

    def _rest(self, number: int) -> None:
        noise = self._noise
        built = self._built if noise is None else drawn_anew(self._built, replace(noise, trial=number))
        self._running = Simulation(built)

    def _go_on(self, inputs: F64, window: float) -> F64:
        before = self._dropped()
        found = super()._go_on(inputs, window)
        self.lost += self._dropped() - before
        return found

    def _runs(self) -> Simulation:
        return self._running

    def _dropped(self) -> int:
        """Spikes that the router has dropped since the network was at rest."""
        return self._running.counters.get("dropped", 0)
