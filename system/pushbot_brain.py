"""Which network is on the Pushbot's chip, on which die, with which biases."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chips.pushbot_biases import LEVELS, pushbot_biases
from chips.pushbot_modified import field_network, modified_network
from chips.pushbot_network import PushbotLayout
from chips.rolls_chip import Inputs, RollsChip
from chips.rolls_network import Network, network_program
from circuits.circuit import BiasKind
from circuits.die import NOMINAL, Die
from circuits.process import ROLLS_180
from circuits.silicon import Silicon
from system.pushbot_drive import Glance
from system.pushbot_loop import Brain
from system.pushbot_robot import Pushbot
from system.pushbot_wiring import fan_out, merged

F64 = NDArray[np.float64]

GYRO_ANGLE = 1e-3  # rad an event, so 1,000 events a second at 1 rad/s; ours
FIELD_SCENES = ("target", "chase", "obstacle-against-target")  # in which the field gets events


@dataclass(frozen=True, slots=True)
class Architecture:
    """Plain or modified; whether the target field gets events; neurons of exc, 8 or 16 by the sources."""

    modified: bool = False
    target: bool = False
    exc: int = 16


def brain_of(
    architecture: Architecture, die: Die = NOMINAL, temperature_c: float = 27.0, kind: BiasKind = "generator"
) -> Brain:
    """A chip with an architecture; biases have one table for all dies, set at 27 degC.

    Raises `ParameterError` for a network that the chip has no room for.
    """
    layout, biases = PushbotLayout(exc=architecture.exc), pushbot_biases()
    if architecture.modified:
        network = modified_network(LEVELS, biases, layout)
    else:
        network = field_network(layout, LEVELS)
    silicon = Silicon(ROLLS_180, temperature_c, die)
    chip = RollsChip(network_program(network, biases), silicon, kind)
    if not architecture.modified:
        return Brain(network, chip, target=architecture.target, synapses=LEVELS.dvs_synapses)
    synapses = LEVELS.dvs_synapses

    def turning() -> GyroInputs:
        return GyroInputs(network, synapses)

    return Brain(network, chip, "graded", architecture.target, synapses, turning)


@dataclass(slots=True, eq=False)
class GyroInputs:
    """Events of the gyro: one a GYRO_ANGLE that the robot has turned, to all neurons of its side.

    angle: turned since the last event, rad, left is positive; rate: the last sample, rad/s.
    """

    network: Network
    synapses: int
    angle: float = 0.0
    rate: float = 0.0

    def __call__(self, glance: Glance, begin: float, end: float) -> Inputs:
        """Inputs from `begin` to `end` s; the rate is held between samples."""
        times = [begin, *glance.gyro[:, 0].tolist(), end]
        rates = [self.rate, *glance.gyro[:, 1].tolist()]
        found: dict[str, list[float]] = {"GL": [], "GR": []}
        for start, stop, rate in zip(times[:-1], times[1:], rates, strict=True):
            self.rate = rate
            if stop > start:
                self._turn(start, stop, rate, found)
        return merged([self._to(name, np.array(sent)) for name, sent in found.items()])

    def _turn(self, start: float, stop: float, rate: float, found: dict[str, list[float]]) -> None:
        self.angle += rate * (stop - start)
        count = int(abs(self.angle) / GYRO_ANGLE)
        side = "GL" if self.angle > 0.0 else "GR"
        self.angle -= math.copysign(count * GYRO_ANGLE, self.angle)
        found[side] += [start + (stop - start) * (k + 0.5) / count for k in range(count)]

    def _to(self, name: str, times: F64) -> Inputs:
        neurons = np.array(self.network[name].neurons)
        times = times + Pushbot().latency
        return fan_out(np.repeat(times, neurons.size), np.tile(neurons, times.size), self.synapses)
