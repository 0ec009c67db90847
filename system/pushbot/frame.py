"""A target frame that moves with the robot but keeps its orientation, on a second ROLLS joined by AER.

Milde et al. 2017, section 4, wish for it, so that the robot can "turn back to a target that has been lost
from sight due to an obstacle avoidance maneuver"; there is no room for it beside the network. Here a ring of
180 neurons, two degrees each, holds a bump where the target is from the robot, in a frame that does not turn:

    spikes of the target field -> ring     by column and heading, one virtual synapse each
    spikes of the ring -> DL, DR           by direction and heading, to the drive left or right of it

The heading is the sum of the gyro's samples; the Parallella's table of addresses shifts with it. The ring's
spikes reach the first chip a look later. Size, levels and the dead angle ahead are ours; the second chip is a
die of its own with the table of codes, not calibrated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from chips.noise import SiliconNoise
from chips.rolls.chip import ChipState, Inputs, RollsChip, Spikes
from chips.rolls.program.address import NONPLASTIC
from chips.rolls.program.network import Network, PopulationInput, network_program
from chips.rolls.program.population import Population, neural_field
from circuits.arrays import I64, Bools
from circuits.circuit import BiasKind
from circuits.silicon.silicon import Silicon
from system.pushbot.drive import Readings
from system.pushbot.network.biases import STEP, pushbot_biases
from system.pushbot.wiring import fan_out

RING = 180  # neurons
NEAR, FAR = (2, 3, 3), -1  # levels of the ring, those of the target field
AHEAD = math.radians(4.0)  # either side of the heading that drives nothing: half of 16 columns
COLUMN = math.tan(math.radians(30.0)) / 64.0  # tangent of a column of the sensor


def _ring_network() -> Network:
    """A ring field with one input."""
    ring = Population("ring", tuple(range(RING)))
    lateral = neural_field(ring, NEAR, FAR, boundary="ring")
    return Network((ring,), (lateral,), (PopulationInput("field", ring),), (ring,))


def ring_chip(silicon: Silicon, kind: BiasKind, noise: SiliconNoise | None = None) -> RollsChip:
    """Return the second chip, which has the ring field."""
    program = network_program(_ring_network(), pushbot_biases(law=silicon.process.effects))
    return RollsChip(program, silicon, kind, step=STEP, noise=noise)


@dataclass(frozen=True, slots=True)
class Relay:
    """Where the ring's spikes go on the first chip: neurons of DL and DR, and the columns of their synapses.

    field: first neuron of the target field, which has its neurons in the order of the sensor's columns.

    left : neurons of DL.
    right : neurons of DR.
    left_column : of their synapses.
    right_column : of their synapses.
    """

    left: tuple[int, ...]
    right: tuple[int, ...]
    left_column: int
    right_column: int
    field: tuple[int, ...]


@dataclass(slots=True, eq=False)
class Frame:
    """State: the second chip's, heading (rad) by the gyro, and inputs of the first chip that wait.

    rate: last sample of the gyro, rad/s; spikes: of the ring so far.

    relay : where the ring's spikes go.
    state : of the second chip.
    """

    chip: RollsChip
    relay: Relay
    state: ChipState
    heading: float = 0.0
    rate: float = 0.0
    spikes: int = 0

    def follow(self, readings: Readings, begin: float, end: float) -> None:
        """Turn with the robot from `begin` to `end` s; the rate is held between samples."""
        times = [begin, *readings.gyro[:, 0].tolist(), end]
        rates = [self.rate, *readings.gyro[:, 1].tolist()]
        for start, stop, rate in zip(times[:-1], times[1:], rates, strict=True):
            self.rate = rate
            self.heading += rate * max(stop - start, 0.0)

    def look(self, spikes: Spikes, duration: float, temperature_c: float | None = None) -> Inputs:
        """Hear the first chip's spikes of a look; inputs for it, timed as those spikes were.

        temperature_c : of both chips, the second one's own unless given.
        """
        place = np.full(256, -1)
        place[list(self.relay.field)] = np.arange(len(self.relay.field))
        column = place[spikes.neurons]
        seen = column >= 0
        to = ring_neurons(column[seen], self.heading, len(self.relay.field))
        times = np.maximum(spikes.times[seen], self.state.time)
        heard, self.state = self.chip.run(self.state, duration, fan_out(times, to, 1), temperature_c)
        self.spikes += heard.times.size
        return self._back(heard)

    def _back(self, heard: Spikes) -> Inputs:
        """Each spike to all neurons of the drive on its side."""
        left, right = sides(heard.neurons, self.heading)
        parts = [
            (heard.times[mine], drive, column)
            for mine, drive, column in (
                (left, self.relay.left, self.relay.left_column),
                (right, self.relay.right, self.relay.right_column),
            )
        ]
        times = np.concatenate([np.repeat(t, len(drive)) for t, drive, _ in parts])
        order = np.argsort(times, kind="stable")
        neurons = np.concatenate([np.tile(np.array(drive), t.size) for t, drive, _ in parts])
        columns = np.concatenate([np.full(t.size * len(drive), NONPLASTIC + c) for t, drive, c in parts])
        return Inputs(times[order], neurons[order].astype(np.int64), columns[order].astype(np.int64))


def ring_neurons(columns: I64, heading: float, size: int) -> I64:
    """Neuron of the ring for columns of a field of `size` neurons, seen at a heading (rad)."""
    angle = np.arctan((0.5 * (size - 1) - columns) * COLUMN * 128.0 / size) + heading
    return np.asarray(np.round(angle / (2.0 * math.pi) * RING), dtype=np.int64) % RING


def sides(neurons: I64, heading: float) -> tuple[Bools, Bools]:
    """Which neurons of the ring lie left and right of a heading (rad), beyond AHEAD."""
    off = neurons * (2.0 * math.pi / RING) - heading
    off = (off + math.pi) % (2.0 * math.pi) - math.pi
    return off > AHEAD, off < -AHEAD
