"""What a run of the sonar head is asked to do: motion of the target, wiring of the neurons, and silicon."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from chips.codes import Calibration, Codes
from chips.lso.calibration import NAME, Design, calibrate, currents_of
from chips.lso.model import Head, head_on
from chips.lso.noise import LsoNoise, noise_of
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500
from system.head.ear import SPEED
from system.head.loop import WIRINGS
from system.head.numbers import Motion, SonarHead
from system.head.world import MOTIONS
from system.option import check_options, option
from system.options.codes import Coded, check_codes
from system.options.noise import Noisy, check_device_noise, device_noise, noise_option, noise_seed_option

DURATION = 20.0  # s, two periods of the sine; ours


@dataclass(frozen=True, slots=True)
class Scenario(Coded):
    """A target that the head follows for a time (s), by one of `MOTIONS`, with one of `WIRINGS`.

    `area` is that of the chip's devices over the circuits'. Their noise is drawn from `noise_seed`, which is
    `seed` unless given.
    """

    CALIBRATED: ClassVar[tuple[str, ...]] = (NAME,)

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
        check_device_noise(self)
        check_codes(self)
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

    @property
    def chip_codes(self) -> Codes | None:
        """Codes of its chip, None for those of the design; raises as `Coded.codes_of`."""
        return self.codes_of(NAME, setup=design_of(self.head, self.area))

    def chip(self, temperature_c: float) -> tuple[Head, LsoNoise | None]:
        """Return the chip on its die at a temperature, degC, and its noise, None where there is none."""
        silicon, codes = self.silicon_at(temperature_c), self.chip_codes
        currents = () if codes is None else currents_of(codes)
        chip = head_on(silicon, self.bias_kind, self.area, currents)
        noise = device_noise(self)
        return chip, None if noise is None else noise_of(
            chip, silicon, noise, self.area, self.bias_kind, currents
        )

    @property
    def balance(self) -> float:
        """What the board takes from a count of left less right, spikes; that of the chip's codes."""
        codes = self.chip_codes
        return 0.0 if codes is None else codes.trims["balance"][0]


def design_of(numbers: SonarHead, area: float = 1.0) -> Design:
    """Return what the chip of a head is calibrated for; area: of its devices over the circuits'."""
    return Design(numbers.thresholds, area)


CALIBRATION = Calibration(
    name=NAME,
    summary="spikes a decibel of the sonar head's two neurons, and where left and right agree",
    process=AMI_1500,
    calibrate=calibrate,
    setup=design_of(SonarHead()),
)
