"""Codes by which numbers become events of a chip: by rate, by latency, by a population.

An encoder makes the events of a window of time of the numbers of an observation, each a share of its range:

    s = (x - low) / (high - low), cut off at 0 and 1; what was cut off is counted

    rate         each address of a number gets s times `most` events a second, evenly spaced, on from window
                 to window
    latency      each address gets one event, (1 - s) of the window after its beginning; none at s = 0
    population   the addresses of a number have centres evenly spaced over its range; each gets `most`
                 exp(-(x - centre)^2 / (2 width^2)) events a second, width in spacings of the centres
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol, final

import numpy as np

from circuits.arrays import F64, I64
from circuits.errors import ParameterError

Groups = Sequence[Sequence[int]]
Train = tuple[F64, I64]


class Encoder(Protocol):
    """Makes events of numbers."""

    def begin(self) -> None:
        """Forget what was before."""

    def events(self, values: F64, start: float, window: float) -> Train:
        """Return times (s), float64[m], and addresses, int64[m], of the events of a window.

        Parameters
        ----------
        values
            The numbers, float64[n], in the units of their ranges.
        start, window
            When the window begins, and how long it is, s.
        """


@dataclass(frozen=True, slots=True)
class Ranges:
    """What numbers are coded.

    Attributes
    ----------
    low, high : sequence of float
        Values at the ends of each number's range, in its unit.
    addresses : sequence of sequence of int
        Addresses of each number on the chip.

    Raises
    ------
    ParameterError
        There are not as many of each, or a range is none.
    """

    low: Sequence[float]
    high: Sequence[float]
    addresses: Groups

    def __post_init__(self) -> None:
        if not len(self.low) == len(self.high) == len(self.addresses):
            counts = f"{len(self.low)} low, {len(self.high)} high and {len(self.addresses)} addresses"
            raise ParameterError(f"encoder: {counts}, must be as many, one a number")
        for k, (low, high) in enumerate(zip(self.low, self.high, strict=True)):
            if not low < high < np.inf or not low > -np.inf:
                raise ParameterError(f"encoder[{k}]: {low:g} to {high:g}, must be finite and rise")

    def shares(self, values: F64) -> tuple[F64, int]:
        """Return shares of the ranges, float64[n], and how many values were cut off.

        `values`: float64[n], in the units of the ranges. Raises `ParameterError` for another count of them.
        """
        found = np.asarray(values, dtype=np.float64).ravel()
        low, high = np.array(self.low), np.array(self.high)
        if found.shape != low.shape:
            raise ParameterError(f"encoder: {found.size} numbers, must be {low.size}; name those to code")
        share = (found - low) / (high - low)
        return share.clip(0.0, 1.0), int(((share < 0.0) | (share > 1.0)).sum())


@dataclass(slots=True)
class _Code(ABC):
    """A code of numbers, each a share of its range; what is cut off is counted.

    ranges : numbers and their addresses.
    clipped : how many numbers were cut off so far.
    """

    ranges: Ranges
    clipped: int = field(default=0, kw_only=True)

    @abstractmethod
    def begin(self) -> None:
        """Forget what was before."""

    def events(self, values: F64, start: float, window: float) -> Train:
        """Return times (s), float64[m], and addresses, int64[m], of the events of a window.

        values: the numbers, float64[n], in the units of their ranges; start, window: begin and length, s.
        """
        share, cut = self.ranges.shares(values)
        self.clipped += cut
        return self._train(share, start, window)

    @abstractmethod
    def _train(self, share: F64, start: float, window: float) -> Train:
        """Events of a window, of shares from 0 to 1."""


@dataclass(slots=True)
class _EvenCode(_Code):
    """Evenly spaced events, whose phases go on from window to window.

    most : events a second of an address at the most, Hz.
    """

    most: float
    _phase: F64 = field(default_factory=lambda: np.empty(0), kw_only=True)

    def begin(self) -> None:
        """Forget how far the next events were."""
        self._phase = np.empty(0)

    @abstractmethod
    def _rates(self, share: F64) -> tuple[F64, Groups]:
        """Rates (Hz), and the addresses that have each."""

    def _train(self, share: F64, start: float, window: float) -> Train:
        rates, groups = self._rates(share)
        if self._phase.size != rates.size:
            self._phase = np.linspace(0.0, 1.0, rates.size, endpoint=False)
        times, addresses = [], []
        for k, (rate, group) in enumerate(zip(rates.tolist(), groups, strict=True)):
            phase = float(self._phase[k])
            end = phase + rate * window
            count = int(np.floor(end))
            if count:
                when = start + (np.arange(1, count + 1) - phase) / rate
                times.append(np.repeat(np.minimum(when, np.nextafter(start + window, -np.inf)), len(group)))
                addresses.append(np.tile(np.asarray(group, dtype=np.int64), count))
            self._phase[k] = end - count
        return _ordered(times, addresses)


@final
@dataclass(slots=True)
class RateCode(_EvenCode):
    """Evenly spaced events, the more the larger a number.

    Attributes
    ----------
    most : float
        Events a second of an address at the upper end of a range, Hz.
    """

    def _rates(self, share: F64) -> tuple[F64, Groups]:
        return share * self.most, self.ranges.addresses


@final
@dataclass(slots=True)
class PopulationCode(_EvenCode):
    """Each address answers to values about a centre of its own.

    Attributes
    ----------
    ranges : Ranges
        Numbers and their addresses, whose centres are evenly spaced in this order.
    most : float
        Events a second of an address whose centre is met, Hz.
    width : float
        Of the tuning, in spacings of the centres, a number above 0.
    """

    width: float = 1.0

    def _rates(self, share: F64) -> tuple[F64, Groups]:
        rates, groups = [], []
        for s, group in zip(share.tolist(), self.ranges.addresses, strict=True):
            apart = (np.linspace(0.0, 1.0, len(group)) - s) * max(len(group) - 1, 1) / self.width
            rates.append(self.most * np.exp(-0.5 * apart**2))
            groups += [(address,) for address in group]
        return np.concatenate(rates), groups


@final
@dataclass(slots=True)
class LatencyCode(_Code):
    """One event a window, the sooner the larger a number."""

    def begin(self) -> None:
        """Nothing is kept from window to window."""

    def _train(self, share: F64, start: float, window: float) -> Train:
        times, addresses = [], []
        for s, group in zip(share.tolist(), self.ranges.addresses, strict=True):
            if s > 0.0:
                times.append(np.full(len(group), start + (1.0 - s) * window))
                addresses.append(np.asarray(group, dtype=np.int64))
        return _ordered(times, addresses)


def _ordered(times: list[F64], addresses: list[I64]) -> Train:
    when = np.concatenate([np.empty(0), *times])
    where = np.concatenate([np.empty(0, dtype=np.int64), *addresses])
    order = np.argsort(when, kind="stable")
    return when[order], where[order]
