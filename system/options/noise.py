"""Noise of a chip's devices in a run, as the command line asks for it."""

from __future__ import annotations

from typing import Literal

from chips.noise import SiliconNoise
from circuits.devices.noise import WHITE_ONLY
from circuits.errors import ParameterError

Noisy = Literal["off", "white", "all"]
NOISY: tuple[Noisy, ...] = ("off", "white", "all")


def silicon_noise(noisy: str, seed: int) -> SiliconNoise | None:
    """Noise of a run's seed: `white`, or `all` with flicker too; None for `off`."""
    if noisy not in NOISY:
        raise ParameterError(f"--silicon-noise: {noisy}, must be {' or '.join(NOISY)}")
    if noisy == "off":
        return None
    return SiliconNoise(seed, flicker=WHITE_ONLY if noisy == "white" else None)


def check_noise(noisy: str, seed: int | None) -> None:
    """Refuse what is no noise, and a seed of noise (None for the run's own) that is off."""
    silicon_noise(noisy, 0)
    if seed is not None and noisy == "off":
        raise ParameterError(f"--noise-seed: {seed}, there is no noise; give --silicon-noise white or all")
