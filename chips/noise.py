"""Noise of a chip in a run: that it makes any, and what the mean of a slow process leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.devices.noise import NoiseModel
from circuits.errors import ParameterError


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


def mean_variance(length: F64) -> F64:
    """Variance of the mean of a relaxation of variance 1 over `length` of its time constants."""
    return np.asarray(2.0 * (length + np.expm1(-length)) / length**2)
