"""What a run of the sonar head is asked to do: motion of the target, wiring of the neurons, and silicon."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from chips.lso.model import Head, head_on
from chips.lso.noise import LsoNoise, noise_of
from circuits.errors import ParameterError
from system.head.ear import SPEED
from system.head.loop import WIRINGS
from system.head.numbers import Motion, SonarHead
from system.head.world import MOTIONS
from system.option import (
    check_options,
    option,
)
from system.options.noise import Noisy, check_noise, noise_option, noise_seed_option, silicon_noise
from system.options.on_silicon import OnSilicon

DURATION = 20.0  # s, two periods of the sine; ours


@dataclass(frozen=True, slots=True)
class Scenario(OnSilicon):
    """A target that the head follows for a time (s), by one of `MOTIONS`, with one of `WIRINGS`.

    `area` is that of the chip's devices over the circuits'. Their noise is drawn from `noise_seed`, which is
    `seed` unless given.
    """

    head: SonarHead = field(default_factory=SonarHead)
    target: Motion = field(default_factory=Motion)
    motion: str = option(MOTIONS[0], "Of the target", choices=MOTIONS, study=True)
    wiring: str = option(
        WIRINGS[0],
        "Excitation has no inhibition, one-ear is against what is usual",
        choices=WIRINGS,
        study=True,
    )
    duration: float = option(DURATION, "Length of the run", unit="s", study=True)
    area: float = option(1.0, "Of the chip's devices, relative, from 1/16", unit="", above=0.0, study=True)
    silicon_noise: Noisy = noise_option()
    noise_seed: int | None = noise_seed_option()

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self)
        check_noise(self.silicon_noise, self.noise_seed)
        if not self.head.period <= self.duration < math.inf:
            raise ParameterError(
                f"duration: {self.duration:g} s, must be at least a ping's period,"
                f" {self.head.period:g} s, and finite"
            )
        self._check_delay()

    def _check_delay(self) -> None:
        """Refuse pings that come before the last one's echo was counted."""
        farthest = self.target.distance + self.target.swing
        delay, last = 2.0 * farthest / SPEED, self.head.decision * self.head.period
        if delay >= last:
            raise ParameterError(
                f"ping_rate: {self.head.ping_rate:g} Hz, an echo from {farthest:g} m takes {delay:.3g} s,"
                f" must be below {self.head.decision:g} of a period, {last:.3g} s; ping less often"
            )

    def chip(self, temperature_c: float) -> tuple[Head, LsoNoise | None]:
        """Return the chip on its die at a temperature, degC, and its noise, None where there is none."""
        silicon = self.silicon_at(temperature_c)
        chip = head_on(silicon, self.bias_kind, self.area)
        seed = self.seed if self.noise_seed is None else self.noise_seed
        noise = silicon_noise(self.silicon_noise, seed)
        return chip, None if noise is None else noise_of(chip, silicon, noise, self.area)
