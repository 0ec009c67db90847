"""What a run of the Bug robot is asked to do: agent, brain, map, and the silicon of a brain on a chip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from chips.nef.calibration import NAME
from circuits.errors import ParameterError
from circuits.silicon.process import check_temperature
from system.bug.body import STEP
from system.bug.brain import AGENTS
from system.option import check_options, option
from system.options.codes import Coded, check_codes
from system.options.noise import Noisy, check_device_noise, noise_option, noise_seed_option

BRAINS = ("reference", "ideal", "chip")
DEFAULT_MAP = "bug-spiral"
DURATION = 200.0  # s, after which a run ends; ours


@dataclass(frozen=True, slots=True)
class Scenario(Coded):
    """One drive of a robot from a start to a goal.

    `design` is of Bug 2's network, and `neurons` is how many there are in all, about. `start` and `goal` are
    numbers from 0 in reading order, or `X,Y` in map units. The seed draws the network's neurons. Of a chip:
    the temperature at which its decoders were solved, where it was calibrated unless given; the area of its
    devices over the usual one, and their noise, drawn from `noise_seed`, which is `seed` unless given; and a
    course of its temperature, pairs of time (s) and degC, instead of `temperature_c`.
    """

    CALIBRATED: ClassVar[tuple[str, ...]] = (NAME,)

    agent: str = option("bug2", "Which of the three", choices=AGENTS, study=True)
    brain: str = option("reference", "A program, or neurons: ideal, or chip", choices=BRAINS)
    design: str = option("published", "Of Bug 2's neurons: published or improved", study=True)
    neurons: int | None = option(None, "How many in all, about; the design's unless given", study=True)
    map: str = option(
        DEFAULT_MAP, "Or a file of # S G and spaces", metavar="MAP", study=True, names="system.bug.map:MAPS"
    )
    start: str = option("0", "Number of the S, from 0, or a place", metavar="N|X,Y", study=True)
    goal: str = option("0", "As the start, of a G", metavar="N|X,Y", study=True)
    duration: float = option(
        DURATION, "After which the run ends", unit="s", least=STEP, below=1e6, study=True
    )
    solved_c: float | None = option(
        None, "Where its decoders were solved; where it was calibrated unless given", name="solved",
        unit="degC", study=True, silicon=True, key="solved_C",
    )  # fmt: skip
    area: float = option(1.0, "Of the chip's devices, relative", unit="", study=True, silicon=True)
    silicon_noise: Noisy = noise_option()
    noise_seed: int | None = noise_seed_option()

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self, no_silicon(self))
        if self.brain == "reference" and (self.neurons is not None or self.design != "published"):
            name = "design" if self.neurons is None else "neurons"
            raise ParameterError(f"{name}: a reference has no neurons; add `brain=ideal`, or leave it out")
        check_temperature(self.temperature_c)
        check_temperature(self.calibrated_c)
        check_temperature(self.solved)
        check_codes(self)
        check_device_noise(self)

    @property
    def solved(self) -> float:
        """Temperature at which decoders were solved, degC."""
        return self.calibrated_c if self.solved_c is None else self.solved_c


def no_silicon(scenario: Scenario) -> str:
    """Say what puts a chip into the loop.

    The text is empty where a chip is in the loop.
    """
    return "" if scenario.brain == "chip" else "add `brain=chip`"


def check_seed(scenario: Scenario) -> None:
    """Refuse a seed where the brain is a program, which draws nothing."""
    if scenario.brain == "reference" and scenario.seed != 0:
        raise ParameterError(f"seed: {scenario.seed}, a reference has no neurons to draw; leave it out")
