"""Noise of a chip in a run: that it has any, and what averaging over a time leaves of a slow process."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.devices.noise import NoiseModel, noise_model
from circuits.errors import ParameterError
from circuits.generator.ripple import Ripple
from circuits.silicon.die import Die
from circuits.silicon.process import Process


@dataclass(frozen=True, slots=True)
class SiliconNoise:
    """The choice that a chip's devices are noisy in a run.

    Two runs of one die with the same seed and trial have the same noise.

    Raises `ParameterError` for a seed or a trial below 0.

    Attributes
    ----------
    seed, trial
        Two numbers that key the noise, 0 or more.
    flicker
        The flicker noise of the devices, that of the process if None,
        `circuits.devices.noise.WHITE_ONLY` for white noise alone.
    ripple
        What the supply of the bias generators does; it stands unless given.
    """

    seed: int = 0
    trial: int = 0
    flicker: NoiseModel | None = None
    ripple: Ripple | None = None

    def __post_init__(self) -> None:
        """Refuse negative numbers."""
        for name, value in (("seed", self.seed), ("trial", self.trial)):
            if value < 0:
                raise ParameterError(f"noise.{name}: {value}, must be at least 0; give a whole number")

    def flicker_in(self, process: Process) -> NoiseModel:
        """Return the flicker noise of devices in `process`, its own unless another was chosen."""
        return noise_model(process) if self.flicker is None else self.flicker


def die_name(name: str, die: Die) -> str:
    """Return the name by which a chip's noise is drawn on a die, as `latency_chip of A/3`."""
    return f"{name} of {die.lot}/{die.number}"


def mean_variance(length: F64) -> F64:
    """Return the variance of the mean of a relaxation (Ornstein-Uhlenbeck) process of variance 1.

    length: of the averaging, in time constants of the process; the result has its shape.
    """
    return np.asarray(2.0 * (length + np.expm1(-length)) / length**2)
