"""What is not known of the chip and its bench: numbers with a mean and a spread before a measurement.

A number is of the process (`n.v_t0`), of one device's deviation on this die
(`differential_pair.m1.v_t0`), or a nuisance of the bench (`s 30 nA`, the factor of a master current). One
that must be above zero is its logarithm.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError

Kind = Literal["process", "device", "nuisance"]
FREE = 0.9
"""Spread after the fit over that before it above which a number is said to be free; ours."""


@dataclass(frozen=True, slots=True)
class Unknown:
    """A number that is not known, normal before anything is measured.

    name: its name. mean, sd: mean and standard deviation before, in its unit. unit: its unit; `ln` for the
    logarithm of a ratio or of a number in SI units. kind: whether it is of the process, of a device of this
    die, or a nuisance of the bench. why: where its mean and spread come from.
    """

    name: str
    mean: float
    sd: float
    unit: str
    kind: Kind
    why: str = "ours"


class Theta(Mapping[str, float]):
    """Values of unknowns by name, which remembers what was read of it."""

    def __init__(self, values: Mapping[str, float]) -> None:
        """Hold values; nothing has been read."""
        self._values = dict(values)
        self.read: set[str] = set()

    def __getitem__(self, name: str) -> float:
        """The value of an unknown."""
        self.read.add(name)
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        """Names of the unknowns."""
        return iter(self._values)

    def __len__(self) -> int:
        """How many there are."""
        return len(self._values)


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """What is known after a fit: a normal of all unknowns together.

    Attributes
    ----------
    unknowns : tuple of Unknown
        The unknowns, as they were before.
    mean : array
        Mean of each, float64[n], in its unit.
    covariance : array
        Float64[n, n].
    """

    unknowns: tuple[Unknown, ...]
    mean: F64
    covariance: F64

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return tuple(each.name for each in self.unknowns)

    @property
    def sd(self) -> F64:
        """Standard deviation of each, float64[n]."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> F64:
        """Correlation of all, float64[n, n]."""
        return self.covariance / np.outer(self.sd, self.sd)

    def values(self) -> dict[str, float]:
        """Means by name."""
        return dict(zip(self.names, self.mean.tolist(), strict=True))

    def free(self) -> tuple[str, ...]:
        """Unknowns that the fit told nothing of: their spread is what it was before."""
        return tuple(u.name for u, sd in zip(self.unknowns, self.sd, strict=True) if sd > FREE * u.sd)

    def draws(self, normals: F64) -> list[dict[str, float]]:
        """Values of all unknowns, by name, for standard normals float64[draws, n]."""
        level, vectors = np.linalg.eigh(self.covariance)
        root = vectors * np.sqrt(np.maximum(level, 0.0))
        return [dict(zip(self.names, row.tolist(), strict=True)) for row in self.mean + normals @ root.T]


def before(unknowns: Iterable[Unknown]) -> Posterior:
    """What is known before any fit; raises `ParameterError` for a name that is there twice."""
    known = tuple(unknowns)
    names = [each.name for each in known]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ParameterError(f"{twice}: an unknown that is there twice, must be there once")
    sd = np.array([each.sd for each in known])
    return Posterior(known, np.array([each.mean for each in known]), np.diag(sd**2))
