"""The noise of a chip's devices in the run of a robot, as the command line asks for it.

It is on unless a run is asked to be without: white and flicker noise, drawn from the run's seed. Where no
chip is in the loop the word changes nothing. What is at transistor level makes none in a run of a robot, and
the account of the run says so (`NOISELESS`).
"""

from __future__ import annotations

from typing import Any, Literal, Protocol

from chips.noise import SiliconNoise
from circuits.circuit import BiasKind
from circuits.devices.noise import WHITE_ONLY
from circuits.errors import ParameterError
from circuits.generator.ripple import Ripple
from circuits.units import parse_quantity
from system.option import option

Noisy = Literal["off", "white", "all"]
NOISY: tuple[Noisy, ...] = ("off", "white", "all")
USUAL: Noisy = "all"
NOISELESS = "noiseless"
"""Entry of what a run was on: the parts at transistor level, whose devices make no noise in it."""


def silicon_noise(noisy: str, seed: int, ripple: Ripple | None = None) -> SiliconNoise | None:
    """Give the noise of a run by its seed: `white`, or `all` with flicker noise too; None for `off`.

    ripple: of the generators' supply. Raises `ParameterError` for another word.
    """
    if noisy not in NOISY:
        raise ParameterError(f"silicon_noise: {noisy}, must be {' or '.join(NOISY)}")
    if noisy == "off":
        return None
    return SiliconNoise(seed, flicker=WHITE_ONLY if noisy == "white" else None, ripple=ripple)


class NoisyRun(Protocol):
    """A scenario whose chips' devices make noise."""

    @property
    def silicon_noise(self) -> str:
        """Which noise they make."""

    @property
    def seed(self) -> int:
        """Seed of the run."""

    @property
    def noise_seed(self) -> int | None:
        """Seed of the noise where it is another than the run's."""

    @property
    def ripple(self) -> Ripple | None:
        """Sine on the supply of the bias generators."""

    @property
    def bias_kind(self) -> BiasKind:
        """Kind of its chips' biases."""


def device_noise(scenario: NoisyRun) -> SiliconNoise | None:
    """Give the noise of the devices in a scenario's run; None where there is none."""
    seed = scenario.seed if scenario.noise_seed is None else scenario.noise_seed
    return silicon_noise(scenario.silicon_noise, seed, scenario.ripple)


def check_device_noise(scenario: NoisyRun) -> None:
    """Raise `ParameterError` for noise of devices, or a ripple of it, that a scenario's run cannot have."""
    check_noise(scenario.silicon_noise, scenario.noise_seed)
    check_ripple(scenario.ripple, scenario.bias_kind, scenario.silicon_noise)


def check_noise(noisy: str, seed: int | None) -> None:
    """Raise `ParameterError` for a word that is no noise, and for a seed of noise where noise is off.

    seed: of the noise; None where the noise has the seed of the run.
    """
    silicon_noise(noisy, 0)
    if seed is not None and noisy == "off":
        raise ParameterError(f"noise_seed: {seed}, there is no noise; give `silicon_noise=white` or all")


def check_ripple(ripple: Ripple | None, bias_kind: BiasKind, noisy: str) -> None:
    """Raise `ParameterError` for a ripple that nothing in a run has.

    bias_kind: of its chips; noisy: whose run has the lines move.
    """
    if ripple is None:
        return
    if bias_kind != "generator":
        raise ParameterError(
            f"ripple: {ripple}, biases of kind {bias_kind} have no supply; take bias_kind generator"
        )
    if noisy == "off":
        raise ParameterError(
            f"ripple: {ripple}, comes with the chip's noise, which is off; give `silicon_noise=white` or all"
        )


def read_ripple(text: str, name: str) -> Ripple:
    """Return the ripple of a text as `10mV@50Hz`; raises `ParameterError` for another text."""
    volts, found, hertz = text.partition("@")
    if not found:
        raise ParameterError(f'{name}: "{text}", must be VOLTS@HERTZ; write as in 10mV@50Hz')
    return Ripple(parse_quantity(volts.strip(), "V", name), parse_quantity(hertz.strip(), "Hz", name))


def write_ripple(ripple: Ripple) -> str:
    """Return the text by which `read_ripple` gives a ripple, to the bit."""
    return f"{ripple.amplitude!r}V@{ripple.frequency!r}Hz"


def ripple_option() -> Any:
    """The field of a scenario for a sine on the supply of its chips' bias generators."""
    return option(
        None, "A sine on the supply of the bias generators, its peak and frequency, as 10mV@50Hz",
        read=read_ripple, write=write_ripple, metavar="VOLTS@HERTZ", silicon=True, study=True,
    )  # fmt: skip


def noise_option(**stated: Any) -> Any:
    """The field of a scenario for the noise of its chips' devices, of the scenario's seed."""
    about = "Of the chip's devices, by the seed: off, white, or all with flicker"
    return option(USUAL, about, **{"study": True, "silicon": True, "anywhere": True, **stated})


def noise_seed_option(**stated: Any) -> Any:
    """The field of a scenario for the seed of that noise where it is another than the scenario's."""
    return option(None, "Of the noise of the chip's devices", study=True, run=False, key="", **stated)
