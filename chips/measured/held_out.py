"""Dies on which a model is judged, none of which was used to build it, and how far off it is on them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon

DIES = tuple(range(500, 508))  # of lot 0
TEMPERATURES = 0.0, 27.0, 60.0  # degC
KINDS: tuple[BiasKind, ...] = ("gate", "ideal")


def every_silicon(
    process: Process = AMI_1500_IDEAL, dies: Sequence[int] = DIES
) -> Iterator[tuple[int, Silicon]]:
    """Return each die's number with its silicon at each of `TEMPERATURES`, dies of lot 0."""
    for number in dies:
        for celsius in TEMPERATURES:
            yield number, Silicon(process, celsius, Die("0", number))


def silicon_in_turn(
    dies: Sequence[int], process: Process = AMI_1500_IDEAL
) -> Iterator[tuple[int, BiasKind, Silicon]]:
    """Return each die's number once, with a kind of bias and its silicon at a temperature.

    Both kinds of bias, and `TEMPERATURES` from pair of dies to pair of dies, take turns.
    """
    for k, number in enumerate(dies):
        celsius = TEMPERATURES[k // len(KINDS) % len(TEMPERATURES)]
        yield number, KINDS[k % len(KINDS)], Silicon(process, celsius, Die(number=number))


def of_dies(dies: Sequence[int]) -> dict[str, float]:
    """Return what a record says of the dies themselves: how many, and the number of the first."""
    return {"dies": float(len(dies)), "first_die": float(dies[0])}


def rms_and_max(name: str, errors: ArrayLike, unit: str) -> dict[str, float]:
    """Return the root mean square and the largest magnitude of errors, as `NAME_rms_UNIT`, `NAME_max_UNIT`.

    errors: numbers in `unit`, of any shape; unit: the end of both names, none if empty.
    """
    off, end = np.asarray(errors, dtype=np.float64), f"_{unit}" if unit else ""
    return {
        f"{name}_rms{end}": float(np.sqrt(np.square(off).mean())),
        f"{name}_max{end}": float(np.abs(off).max()),
    }
