"""A sampling plan says which standard normal draws the dies of a study have.

`random` is every die's own keyed draw: an edit elsewhere, another number of samples, a subset change nothing.
`lhs` and `sobol` spread all dies of the study over the space of all draws together (scipy.stats.qmc): better
means for as many samples, but the rows belong to the whole. Another number of samples, another transistor or
another first die gives other dies, and such a study cannot be extended.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.errors import ParameterError
from circuits.silicon.sampling import Sampling

special, qmc = later("scipy.special"), later("scipy.stats.qmc")

Method = Literal["random", "lhs", "sobol"]
METHODS: tuple[Method, ...] = ("random", "lhs", "sobol")
_DIES = 10**12  # numbers that a chunk's file has twelve digits for; ours
_SEEDS = 2**63  # ours; generators take any of them
WORLDS = 1000
"""Worlds that a die meets in a study of worlds of its own, at most, and runs in each of them; ours."""
_LARGEST = 21_201  # dimensions that scipy's Sobol sequence has
_EDGE = 2.0**-54  # a Sobol point may be 0, whose normal is infinite


@dataclass(frozen=True, slots=True)
class Plan:
    """A sampling plan: which dies a study measures, and how their deviations are drawn.

    Attributes
    ----------
    method : str
        How they are drawn, one of `METHODS`.
    seed : int
        Seed of the draws.
    first : int
        Number of the first die.
    count : int
        How many dies there are.

    Raises
    ------
    ParameterError
        The method is not known, no die has such numbers, or no generator takes the seed.
    """

    method: Method
    seed: int
    first: int
    count: int

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.method not in METHODS:
            raise ParameterError(f"plan: {self.method}, must be {', '.join(METHODS)}")
        if not 0 <= self.seed < _SEEDS:
            raise ParameterError(f"seed: {self.seed}, must be a whole number from 0 to {_SEEDS - 1}")
        if self.count < 0 or self.first < 0:
            raise ParameterError(
                f"samples: {self.count} from die {self.first}, must be 0 or more from die 0 on"
            )
        if self.first + self.count > _DIES:
            raise ParameterError(
                f"first_die: {self.count} dies from {self.first} on, must end before {_DIES}"
            )

    @property
    def name(self) -> str:
        """Name of the plan, as it stands in a die's name: `lhs/0`."""
        return f"{self.method}/{self.seed}"

    @property
    def extensible(self) -> bool:
        """Whether more dies leave the others as they are."""
        return self.method == "random"


def seeds_of(die: int, trial: int, noises: int) -> tuple[int, int | None]:
    """Seed of the world of a trial, and seed of its noise, where every die meets worlds of its own.

    Trials of a die go through its worlds, and through `noises` runs in each. No two dies or worlds share a
    seed. With one run in a world the noise has that of the world, which None says.
    """
    world, noise = divmod(trial, noises)
    seed = WORLDS * die + world
    return seed, None if noises == 1 else WORLDS * seed + noise


def sampling(plan: Plan, labels: Sequence[str], start: int, stop: int) -> Sampling | None:
    """The plan's draws of dies `start` to `stop - 1`; None where these have their own.

    labels: of all draws of the target, in order. Raises `ParameterError` for a target without draws, or with
    more than a Sobol sequence has.
    """
    if plan.method == "random":
        return None
    if not labels:
        raise ParameterError(f"plan: {plan.method}, nothing varies; use random")
    columns = {label: k for k, label in enumerate(labels)}
    rows = _rows(plan, len(labels), start - plan.first, stop - plan.first)
    return Sampling(plan.name, start, columns, special.ndtri(np.clip(rows, _EDGE, 1.0 - _EDGE)))


def _rows(plan: Plan, dimensions: int, start: int, stop: int) -> F64:
    if plan.method == "lhs":
        # all of it belongs together, so that a part needs the whole
        return _hypercube(dimensions, plan.seed, plan.count)[start:stop]
    if dimensions > _LARGEST:
        raise ParameterError(f"plan: sobol, {dimensions} draws, must be at most {_LARGEST}; use lhs")
    points = qmc.Sobol(dimensions, scramble=True, rng=plan.seed)
    with warnings.catch_warnings():
        # balance needs powers of two, which a part of the sequence need not be; the command says so
        warnings.filterwarnings("ignore", message="The balance properties", category=UserWarning)
        if start:
            points.fast_forward(start)
        return np.asarray(points.random(stop - start))


@lru_cache(maxsize=1)
def _hypercube(dimensions: int, seed: int, count: int) -> F64:
    return np.asarray(qmc.LatinHypercube(dimensions, rng=seed).random(count))
