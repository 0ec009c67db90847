"""What a task meets of a network: how many inputs it takes, in what unit, and how many outputs it has.

on ROLLS     an input is a rate; a number that is seen drives two channels, by what it is above and below 0
             over its reach, and one channel more is always on; an output is a probe's population
on the NEF   an input is a value, a number over its reach one of them; the outputs are the numbers that
             probes show, one probe after the other
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from chips.nef.network.kernel import DT
from chips.nef.population import evaluate
from chips.rolls.chip import STEP
from circuits.arrays import F64
from circuits.errors import ParameterError
from system.mapping.clock import outside
from system.mapping.nef.network import ValueNetwork
from system.mapping.network import Network

MOST = 1e4  # Hz of a channel; ours
LARGEST = 1e6  # value of an input, in its own unit; ours
HIGHEST, ALWAYS = 1600.0, 0.15  # Hz of a number at its reach; share of it that is always on; ours


@dataclass(frozen=True, slots=True)
class Ends:
    """Inputs and outputs of a network.

    channels, outputs : how many; noun, unit, least, most : of an input; step : s, of which windows are whole;
    of_shares : inputs that stand for numbers from -1 to 1.
    """

    channels: int
    outputs: int
    noun: str
    unit: str
    least: float
    most: float
    step: float
    of_shares: Callable[[F64], F64]

    @property
    def limits(self) -> str:
        """The least and the largest input, in words."""
        return f"from {self.least:g} to {self.most:g}{self.unit}"

    def inside(self, inputs: F64) -> bool:
        """Whether all inputs are within their limits."""
        return bool(((inputs >= self.least) & (inputs <= self.most)).all())

    def check_channels(self, asked: int, what: str) -> None:
        """Raise `ParameterError` for a network without outputs, or with other channels than `what` asks."""
        if not self.outputs:
            raise ParameterError("probe: none, must be one for each output; add them")
        if asked != self.channels:
            raise ParameterError(f"task.{what}: {asked} channels, must be the network's {self.channels}")

    def check_window(self, window: float) -> None:
        """Raise `ParameterError` for a window, s, that is not whole steps of the chip."""
        steps = round(window / self.step) if np.isfinite(window) else 0
        if steps < 1 or abs(steps * self.step - window) > 1e-9:
            raise ParameterError(
                f"task.window: {window:g} s, must be whole steps of {self.step:g} s; round it"
            )


def ends_of(network: Network | ValueNetwork) -> Ends:
    """Return the ends of a network."""
    if isinstance(network, Network):
        count = outside(network).size
        return Ends(count, len(network.probes), "rate", " Hz", 0.0, MOST, STEP, _rates)
    count = sum(size for _, size in outputs_of(network))
    return Ends(network.channels, count, "value", "", -LARGEST, LARGEST, DT, _values)


def outputs_of(network: ValueNetwork) -> tuple[tuple[str, int], ...]:
    """Return each probe's name and how many numbers it shows."""
    sizes = {e.name: e.dimensions for e in network.ensembles}
    return tuple(
        (p.name, evaluate(p.lowered().function, np.zeros((1, sizes[p.ensemble])), p.name).shape[1])
        for p in network.probes
    )


def output_names(network: ValueNetwork) -> tuple[str, ...]:
    """Return the names of the outputs: that of a probe, with a number where it shows several."""
    return tuple(
        name if size == 1 else f"{name}[{k}]" for name, size in outputs_of(network) for k in range(size)
    )


def _rates(shares: F64) -> F64:
    both = np.stack([shares, -shares], axis=1).clip(0.0, 1.0).ravel()
    return HIGHEST * np.append(both, ALWAYS)


def _values(shares: F64) -> F64:
    return shares
