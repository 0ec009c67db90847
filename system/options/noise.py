"""The noise of a chip's devices in the run of a robot, as the command line asks for it.

It is on unless a run is asked to be without: white and flicker noise, drawn from the run's seed. Where no
chip is in the loop the word changes nothing. What is at transistor level makes none in a run of a robot, and
the account of the run says so (`NOISELESS`).
"""

from __future__ import annotations

from typing import Any, Literal

from chips.noise import SiliconNoise
from circuits.devices.noise import WHITE_ONLY
from circuits.errors import ParameterError
from system.option import option

Noisy = Literal["off", "white", "all"]
NOISY: tuple[Noisy, ...] = ("off", "white", "all")
USUAL: Noisy = "all"
NOISELESS = "noiseless"
"""Entry of what a run was on: the parts at transistor level, whose devices make no noise in it."""


def silicon_noise(noisy: str, seed: int) -> SiliconNoise | None:
    """Give the noise of a run by its seed: `white`, or `all` with flicker noise too; None for `off`.

    Raises `ParameterError` for another word.
    """
    if noisy not in NOISY:
        raise ParameterError(f"silicon_noise: {noisy}, must be {' or '.join(NOISY)}")
    if noisy == "off":
        return None
    return SiliconNoise(seed, flicker=WHITE_ONLY if noisy == "white" else None)


def check_noise(noisy: str, seed: int | None) -> None:
    """Raise `ParameterError` for a word that is no noise, and for a seed of noise where noise is off.

    seed: of the noise; None where the noise has the seed of the run.
    """
    silicon_noise(noisy, 0)
    if seed is not None and noisy == "off":
        raise ParameterError(f"noise_seed: {seed}, there is no noise; give `silicon_noise=white` or all")


def noise_option(**stated: Any) -> Any:
    """The field of a scenario for the noise of its chips' devices, of the scenario's seed."""
    about = "Of the chip's devices, by the seed: off, white, or all with flicker"
    return option(USUAL, about, **{"study": True, "silicon": True, "anywhere": True, **stated})


def noise_seed_option(**stated: Any) -> Any:
    """The field of a scenario for the seed of that noise where it is another than the scenario's."""
    return option(None, "Of the noise of the chip's devices", study=True, run=False, key="", **stated)
