"""What a die of ROLLS is driven with: biases, regular events of every neuron, and the silicon."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from chips.codes import Codes
from chips.rolls.chip import STEP
from chips.rolls.program.bias_file import BiasTable
from circuits.errors import ParameterError
from system.option import check_options, option
from system.options.codes import check_codes
from system.options.noise import Noisy, check_device_noise, noise_option, noise_seed_option
from system.options.rolls.process import MadeIn
from system.rolls.codes import INPUT_RATE, NAME
from system.rolls.options import bias_table

SETTLING = 0.1  # s, before rates are counted; ours
STUDY_DURATION = 4.0  # s, unless asked


@dataclass(frozen=True, slots=True)
class Scenario(MadeIn):
    """A die and its drive: events at `input_rate` (Hz) for every neuron, for `duration` s.

    Phases of the events are drawn from the seed, and noise from `noise_seed`, which is `seed` unless given.
    `course` has pairs of time (s) and degC that the temperature follows instead of `temperature_c`.
    """

    CALIBRATED: ClassVar[tuple[str, ...]] = (NAME,)

    bias_file: str | None = option(
        None, "Codes: rolls_default, rolls_parallella or a CSV; the first unless given", metavar="FILE",
        study=True,
    )  # fmt: skip
    input_rate: float = option(
        INPUT_RATE, "Of events a neuron, 0Hz for none", unit="Hz", least=0.0, study=True
    )
    duration: float = option(1.0, "Of the run", unit="s", study=True)
    step: float = option(STEP, "Of the chip's model, short for bursts", unit="s", least=1e-6, study=True)
    silicon_noise: Noisy = noise_option()
    noise_seed: int | None = noise_seed_option()

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self)
        if not self.duration > SETTLING:
            raise ParameterError(
                f"duration: {self.duration:g} s, must be > {SETTLING:g} s, after which rates are counted"
            )
        check_device_noise(self)
        check_codes(self)

    @property
    def table(self) -> BiasTable:
        """Codes of its file, before any calibration; raises `DataError` for a file of biases that is none."""
        return bias_table(self.bias_file)

    @property
    def found(self) -> Codes | None:
        """What the calibration found; None for the codes of the file. Raises as `Coded.codes_of`."""
        return self.codes_of(NAME, self.made_in, setup=self.table)


def check_table(scenario: Scenario) -> None:
    """Raise `DataError` for a file of biases that is none."""
    _ = scenario.table
