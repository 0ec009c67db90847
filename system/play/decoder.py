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
from dataclasses import dataclass, field
from typing import Protocol, final

import numpy as np
from numpy.typing import ArrayLike

from chips.aer import Events
from circuits.arrays import F64, I64
from circuits.errors import ParameterError

Groups = Sequence[Sequence[int]]


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
class _Choice(ABC):
    """The number of one of the groups, and the last one again where the events choose none.

    groups : addresses of each group.
    """

    groups: Groups
    _last: int = field(default=0, init=False)

    def begin(self) -> None:
        """Forget the last choice."""
        self._last = 0

    def action(self, events: Events, start: float, window: float) -> int:
        """Return the number of the group that is chosen.

        events: what the chip sent in the window; start, window: its begin and length, s.
        """
        chosen = self._chosen(events)
        self._last = self._last if chosen is None else chosen
        return self._last

    @abstractmethod
    def _chosen(self, events: Events) -> int | None:
        """Number of the group that the events choose; None, which is counted, where they choose none."""


@final
@dataclass(slots=True)
class VoteDecoder(_Choice):
    """The number of the group that is most active.

    Attributes
    ----------
    ties : int
        How often the last choice was taken, for want of a winner.
    """

    ties: int = 0

    def _chosen(self, events: Events) -> int | None:
        counts = counts_of(self.groups, events)
        winners = np.flatnonzero(counts == counts.max())
        if winners.size == 1:
            return int(winners[0])
        self.ties += 1
        return None


@final
@dataclass(slots=True)
class LatencyDecoder(_Choice):
    """The number of the group that is the first.

    Attributes
    ----------
    silent : int
        How often none came.
    """

    silent: int = 0

    def _chosen(self, events: Events) -> int | None:
        first = [events.times[np.isin(events.addresses, list(g))].min(initial=math.inf) for g in self.groups]
        if math.isfinite(min(first)):
            return int(np.argmin(first))
        self.silent += 1
        return None


@dataclass(slots=True)
class PopulationDecoder:
    """The mean of the values for which groups stand.

    Attributes
    ----------
    groups : sequence of sequence of int
        Addresses of each group.
    values : array
        What each group stands for, float64[groups], in the action's unit.
    silent : int
        How often none came.

    Raises
    ------
    ParameterError
        There are not as many values as groups.
    """

    groups: Groups
    values: F64
    silent: int = 0
    _last: float = 0.0

    def __post_init__(self) -> None:
        if len(self.values) != len(self.groups):
            raise ParameterError(
                f"decoder: {len(self.values)} values and {len(self.groups)} groups, must be as many"
            )

    def begin(self) -> None:
        """Forget the last value."""
        self._last = 0.0

    def action(self, events: Events, start: float, window: float) -> F64:
        """Return the value, float64[1], in the unit of the values.

        events: what the chip sent in the window; start, window: its begin and length, s.
        """
        counts = counts_of(self.groups, events)
        if counts.sum() > 0.0:
            self._last = float(np.average(np.asarray(self.values), weights=counts))
        else:
            self.silent += 1
        return np.array([self._last])


def counts_of(groups: Groups, events: Events) -> F64:
    """Return events an address of each group, float64[groups]."""
    found: I64 = events.addresses
    return np.array([np.isin(found, list(group)).sum() / max(len(group), 1) for group in groups])
