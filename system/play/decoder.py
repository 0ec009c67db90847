"""Codes by which a chip's events become an action: by rate, by latency, by a population.

A decoder makes an action of the events of a window of time, by groups of addresses:

    rate         counts of each group an address and second, low-passed, through a matrix: real numbers
    vote         number of the group with the most events an address; the last one again where none came
    latency      number of the group whose first event is the soonest; the last one again where none came
    population   mean of the groups' values, weighted with their counts; the last one again where none came
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeVar, final

import numpy as np
from numpy.typing import ArrayLike

from chips.aer import Events
from circuits.arrays import F64, I64
from circuits.errors import ParameterError

Groups = Sequence[Sequence[int]]
T = TypeVar("T")


class Decoder(Protocol):
    """Makes an action of events."""

    def begin(self) -> None:
        """Forget what was before."""

    def action(self, events: Events, start: float, window: float) -> ArrayLike:
        """Return the action of a window of time.

        Parameters
        ----------
        events
            What the chip sent in the window.
        start, window
            When the window began, and how long it was, s.
        """


@dataclass(slots=True)
class RateDecoder:
    """Real numbers of low-passed rates.

    Attributes
    ----------
    groups : sequence of sequence of int
        Addresses of each group.
    matrix : array
        What a rate counts for in each number, float64[numbers, groups], in the number's unit a Hz.
    tau : float
        Time constant of the low-pass, s; 0 for none.
    offset : float
        Added to every number, in its unit.
    """

    groups: Groups
    matrix: F64
    tau: float = 0.0
    offset: float = 0.0
    _rates: F64 = field(default_factory=lambda: np.empty(0))

    def begin(self) -> None:
        """Forget the rates."""
        self._rates = np.zeros(len(self.groups))

    def action(self, events: Events, start: float, window: float) -> F64:
        """Return the numbers, float64[numbers], each in its own unit.

        events: what the chip sent in the window; start, window: its begin and length, s.
        """
        now = counts_of(self.groups, events) / window
        if self._rates.size != now.size:
            self.begin()
        keep = math.exp(-window / self.tau) if self.tau > 0.0 else 0.0
        self._rates = keep * self._rates + (1.0 - keep) * now
        return np.asarray(self.matrix @ self._rates + self.offset)


@dataclass(slots=True)
class _Lasting(ABC, Generic[T]):
    """What the events of a window tell, and what was told last where they tell nothing.

    groups : addresses of each group; silent : how often what was told last was told again.
    """

    groups: Groups
    silent: int = field(default=0, init=False)
    _last: T | None = field(default=None, init=False)

    def begin(self) -> None:
        """Forget what was told."""
        self._last = None

    def action(self, events: Events, start: float, window: float) -> T:
        """Return what is told, or was last; before anything was, what stands for 0.

        events: what the chip sent in the window; start, window: its begin and length, s.
        """
        told = self._told(events)
        if told is None:
            self.silent += 1
            return self._first() if self._last is None else copy(self._last)
        self._last = copy(told)  # whoever is told may write to it
        return told

    @abstractmethod
    def _first(self) -> T:
        """What is told before the events tell anything."""

    @abstractmethod
    def _told(self, events: Events) -> T | None:
        """What the events tell, None where they tell nothing."""


class _Choice(_Lasting[int]):
    """The number of one of the groups."""

    __slots__ = ()

    def _first(self) -> int:
        return 0


@final
class VoteDecoder(_Choice):
    """The number of the group that is most active."""

    __slots__ = ()

    @property
    def ties(self) -> int:
        """How often the last choice was taken, for want of a winner."""
        return self.silent

    def _told(self, events: Events) -> int | None:
        counts = counts_of(self.groups, events)
        winners = np.flatnonzero(counts == counts.max())
        return int(winners[0]) if winners.size == 1 else None


@final
class LatencyDecoder(_Choice):
    """The number of the group that is the first; `silent` counts windows in which none came."""

    __slots__ = ()

    def _told(self, events: Events) -> int | None:
        first = [events.times[np.isin(events.addresses, list(g))].min(initial=math.inf) for g in self.groups]
        return int(np.argmin(first)) if math.isfinite(min(first)) else None


@final
@dataclass(slots=True)
class PopulationDecoder(_Lasting[F64]):
    """The mean of the values for which groups stand, float64[1].

    Attributes
    ----------
    values : array
        What each group stands for, float64[groups], in the action's unit.

    Raises
    ------
    ParameterError
        There are not as many values as groups.
    """

    values: F64

    def __post_init__(self) -> None:
        if len(self.values) != len(self.groups):
            raise ParameterError(
                f"decoder: {len(self.values)} values and {len(self.groups)} groups, must be as many"
            )

    def _first(self) -> F64:
        return np.zeros(1)

    def _told(self, events: Events) -> F64 | None:
        counts = counts_of(self.groups, events)
        if counts.sum() == 0.0:
            return None
        return np.array([np.average(np.asarray(self.values), weights=counts)])


def counts_of(groups: Groups, events: Events) -> F64:
    """Return events an address of each group, float64[groups]."""
    found: I64 = events.addresses
    return np.array([np.isin(found, list(group)).sum() / max(len(group), 1) for group in groups])
