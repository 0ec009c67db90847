"""What is written to ROLLS' plastic array: which synapses let pulses in, and their first weights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from chips.rolls.program.address import NEURONS
from circuits.arrays import Bools
from circuits.errors import ParameterError


@dataclass(frozen=True, slots=True, eq=False)
class PlasticArray:
    """Which plastic synapses are in use, and how their weights begin.

    Smaller squares hold for the first neurons. Arrays are copied and cannot be written.

    Attributes
    ----------
    latches : array
        Whether a synapse lets pulses in, bool[post, pre].
    weights : array or None
        Whether its weight is high to begin with, bool[post, pre]; all are low unless given.

    Raises
    ------
    ParameterError
        An array is not a square of at most 256, or has values that are not 0 or 1.
    """

    latches: Bools
    weights: Bools | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "latches", binary("latches", self.latches))
        start = np.zeros((1, 1), np.bool_) if self.weights is None else self.weights
        object.__setattr__(self, "weights", binary("weights", start))

    def start(self) -> Bools:
        """Return the weights to begin with, bool[post, pre]."""
        return binary("weights", np.zeros((1, 1)) if self.weights is None else self.weights)


def binary(name: str, values: ArrayLike) -> Bools:
    """Return values of 0 or 1 as bool[256, 256]; raises `ParameterError` for others, calling them `name`."""
    given = np.asarray(values)
    if given.ndim != 2 or given.shape[0] != given.shape[1] or given.shape[0] > NEURONS:
        shape = " x ".join(map(str, given.shape))
        raise ParameterError(
            f"plastic.{name}: {shape}, must be a square of (post, pre), {NEURONS} x {NEURONS} at most"
        )
    wrong = (given != 0) & (given != 1)
    if wrong.any():
        post, pre = np.argwhere(wrong)[0]
        raise ParameterError(
            f"plastic.{name}[{post}, {pre}]: {given[post, pre]}, must be 0 or 1; the array is binary"
        )
    placed = np.zeros((NEURONS, NEURONS), dtype=np.bool_)
    placed[: given.shape[0], : given.shape[1]] = given != 0
    placed.flags.writeable = False
    return placed
