"""Which network runs on the Pushbot's chip, on which die, and with which biases."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from chips.codes import Codes
from chips.noise import SiliconNoise
from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.program.network import Network, network_program
from chips.rolls.program.population import Population, all_to_all, neural_field
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.pushbot.body import Pushbot
from system.pushbot.drive import Readings
from system.pushbot.frame import Frame, Relay, ring_chip
from system.pushbot.loop import Brain
from system.pushbot.network.biases import LEVELS, STEP
from system.pushbot.network.calibration import without
from system.pushbot.network.codes import MODIFIED, PLAIN, biases_of, gone_of, network_of, table_of
from system.pushbot.network.plain import PushbotLayout
from system.pushbot.wiring import fan_out, merged

GYRO_ANGLE = 2e-3  # rad an event: 500 events a second at 1 rad/s; ours
RELAYS = (254, 255)  # neurons whose synapses take a second chip's spikes; they are in no population
SECOND = "-second"  # behind the lot's name, of the second chip's silicon
STRONG = 4  # level
FIELD_SCENES = ("target", "chase", "obstacle-against-target")  # in which the field gets events
_NOMINAL = Silicon(ROLLS_180_IDEAL)


@dataclass(frozen=True, slots=True)
class Architecture:
    """Which network is on the chip.

    Attributes
    ----------
    modified : bool
        Whether it is the modified architecture instead of the plain one.
    target : bool
        Whether the target field gets events.
    exc : int
        How many neurons are in exc, 8 or 16 by the sources.
    frame : bool
        Whether the field drives through a second chip that keeps its orientation; of the plain network only.
    raised : bool
        Whether lateral weights are raised while the target is lost from view; of the plain network only.

    Raises
    ------
    ParameterError
        `frame` or `raised` is asked for without a target, or of the modified architecture.
    """

    modified: bool = False
    target: bool = False
    exc: int = 16
    frame: bool = False
    raised: bool = False

    def __post_init__(self) -> None:
        for name, given in (("frame", self.frame), ("raise_lateral", self.raised)):
            if given and self.modified:
                raise ParameterError(f"{name}: with `modified`, must be without; its chip is full")
            if given and not self.target:
                raise ParameterError(f"{name}: without a target, must have one; give `target`")

    @property
    def layout(self) -> PushbotLayout:
        """How many neurons its populations have."""
        return PushbotLayout(exc=self.exc)

    @property
    def calibration(self) -> str:
        """Name of the calibration whose codes it takes."""
        return MODIFIED if self.modified else PLAIN


def brain_of(
    architecture: Architecture, silicon: Silicon = _NOMINAL, kind: BiasKind = "ideal",
    *, codes: Codes | None = None, noise: SiliconNoise | None = None,
) -> Brain:  # fmt: skip
    """Make a chip with an architecture on it.

    Parameters
    ----------
    architecture
        Which network is on the chip.
    silicon
        Process, temperature and die of the chip.
    kind
        Kind of its biases.
    codes
        What the architecture's calibration found on the die; the table of the nominal die unless given.
    noise
        Noise of the devices of every chip; none unless given.

    Raises
    ------
    ParameterError
        The chip has no room for the network.
    """
    name = architecture.calibration
    biases = table_of(name, silicon) if codes is None else biases_of(codes)
    gone = frozenset[int]() if codes is None else gone_of(codes)
    whole = network_of(name, architecture.layout)
    network = without(whole, gone)
    if architecture.frame:
        network = _with_relays(network)
    chip = RollsChip(network_program(network, biases), silicon, kind, step=STEP, noise=noise)
    if not architecture.modified:
        strong, frame = None, None
        if architecture.raised:
            raised = network_program(strengthened(network), biases)
            strong = RollsChip(raised, silicon, kind, step=STEP, noise=noise)
        if architecture.frame:
            die = replace(silicon.die, lot=f"{silicon.die.lot}{SECOND}")
            second = ring_chip(replace(silicon, die=die), kind, noise)

            def frame() -> Frame:
                return Frame(second, _relay_of(network), second.at_rest())

        return Brain(
            network,
            chip,
            target=architecture.target,
            synapses=LEVELS.dvs_synapses,
            strong=strong,
            frame=frame,
        )
    synapses = LEVELS.dvs_synapses

    def turning() -> GyroInputs:
        return GyroInputs(network, synapses)

    return Brain(network, chip, "graded", architecture.target, synapses, turning)


def _with_relays(network: Network) -> Network:
    """The network whose field drives nothing; synapses of two idle neurons take a second chip's spikes."""
    kept = tuple(p for p in network.projections if not p.source.name.startswith("target["))
    left, right = Population("relay_left", (RELAYS[0],)), Population("relay_right", (RELAYS[1],))
    level = LEVELS.target_to_drive
    relays = all_to_all(left, network["DL"], level), all_to_all(right, network["DR"], level)
    return replace(network, populations=(*network.populations, left, right), projections=(*kept, *relays))


def _relay_of(network: Network) -> Relay:
    """Where the second chip's spikes go in a network with relays."""
    drives = network["DL"].neurons, network["DR"].neurons
    return Relay(*drives, *RELAYS, network["target"].neurons)


def strengthened(network: Network) -> Network:
    """The network with the strongest exciting level between neighbours of the field."""
    field = network["target"]
    near = (STRONG,) * len(LEVELS.field_near)
    others = tuple(p for p in network.projections if (p.source.name, p.target.name) != (field.name,) * 2)
    return replace(network, projections=(*others, neural_field(field, near, LEVELS.field_far)))


@dataclass(slots=True, eq=False)
class GyroInputs:
    """Events of the gyro: one a GYRO_ANGLE that the robot has turned, to all neurons of its side.

    angle: turned since the last event, rad, left is positive; rate: the last sample, rad/s.
    """

    network: Network
    synapses: int
    angle: float = 0.0
    rate: float = 0.0

    def __call__(self, readings: Readings, begin: float, end: float) -> Inputs:
        """Inputs from `begin` to `end` s; the rate is held between samples."""
        times = [begin, *readings.gyro[:, 0].tolist(), end]
        rates = [self.rate, *readings.gyro[:, 1].tolist()]
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
