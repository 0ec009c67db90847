"""Codes by which a chip's events become an action: by rate, by latency, by a population.

A decoder makes an action of the events of a window of time, by groups of addresses:

    rate         counts of each group an address and second, low-passed, through a matrix: real numbers
    vote         number of the group with the most events an address; the last one again where none came
    latency      number of the group whose first event is the soonest; the last one again where none came
    population   mean of the groups' values, weighted with their counts; the last one again where none came
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from chips.aer import Events
from circuits.arrays import F64, I64
from circuits.errors import ParameterError

Groups = Sequence[Sequence[int]]


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

        Parameters
        ----------
        events
            What the chip sent in the window.
        start, window
            When the window began, and how long it was, s.
        """
        now = counts_of(self.groups, events) / window
        if self._rates.size != now.size:
            self.begin()
        keep = math.exp(-window / self.tau) if self.tau > 0.0 else 0.0
        self._rates = keep * self._rates + (1.0 - keep) * now
        return np.asarray(self.matrix @ self._rates + self.offset)


@dataclass(slots=True)
class VoteDecoder:
    """The number of the group that is most active.

    Attributes
    ----------
    groups : sequence of sequence of int
        Addresses of each group.
    ties : int
        How often the last choice was taken, for want of a winner.
    """

    groups: Groups
    ties: int = 0
    _last: int = 0

    def begin(self) -> None:
        """Forget the last choice."""
        self._last = 0

    def action(self, events: Events, start: float, window: float) -> int:
        """Return the number of the group.

        Parameters
        ----------
        events
            What the chip sent in the window.
        start, window
            When the window began, and how long it was, s.
        """
        counts = counts_of(self.groups, events)
        winners = np.flatnonzero(counts == counts.max())
        if winners.size == 1:
            self._last = int(winners[0])
        else:
            self.ties += 1
        return self._last


@dataclass(slots=True)
class LatencyDecoder:
    """The number of the group that is the first.

    Attributes
    ----------
    groups : sequence of sequence of int
        Addresses of each group.
    silent : int
        How often none came.
    """

    groups: Groups
    silent: int = 0
    _last: int = 0

    def begin(self) -> None:
        """Forget the last choice."""
        self._last = 0

    def action(self, events: Events, start: float, window: float) -> int:
        """Return the number of the group.

        Parameters
        ----------
        events
            What the chip sent in the window.
        start, window
            When the window began, and how long it was, s.
        """
        first = [events.times[np.isin(events.addresses, list(g))].min(initial=math.inf) for g in self.groups]
        if math.isfinite(min(first)):
            self._last = int(np.argmin(first))
        else:
            self.silent += 1
        return self._last


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

        Parameters
        ----------
        events
            What the chip sent in the window.
        start, window
            When the window began, and how long it was, s.
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
