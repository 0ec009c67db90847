"""Noise of a chip in a run: that it makes any, and what the mean of a slow process leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.devices.noise import NoiseModel, noise_model
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import Process


@dataclass(frozen=True, slots=True)
class SiliconNoise:
    """That a chip makes noise.

    flicker: None for that of the process, `circuits.devices.noise.WHITE_ONLY` for none.
    """

    seed: int = 0
    trial: int = 0
    flicker: NoiseModel | None = None

    def __post_init__(self) -> None:
        """Refuse negative numbers."""
        for name, value in (("seed", self.seed), ("trial", self.trial)):
            if value < 0:
                raise ParameterError(f"noise.{name}: {value}, must be at least 0; give a whole number")

    def flicker_in(self, process: Process) -> NoiseModel:
        """Flicker of devices in `process`: the one that was chosen, else the process's own."""
        return noise_model(process) if self.flicker is None else self.flicker


def die_name(name: str, die: Die) -> str:
    """Return the chip `name` with its die, as `latency_chip of A/3`, by which its noise is drawn."""
    return f"{name} of {die.lot}/{die.number}"


def mean_variance(length: F64) -> F64:
    """Variance of the mean of a relaxation of variance 1 over `length` of its time constants."""
    return np.asarray(2.0 * (length + np.expm1(-length)) / length**2)
