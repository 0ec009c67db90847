"""What the numbers of an observation or an action are: names, units and bounds, and the check of one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circuits.arrays import F64
from circuits.errors import ParameterError

Kind = Literal["real", "whole", "frame"]
Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Channel:
    """One number of an observation or action, or several alike.

    Attributes
    ----------
    name : str
        What it is, in words.
    unit : str
        Unit of the values, empty for none.
    low, high : float
        Least and greatest value, in the channel's unit; infinite for none.
    shape : tuple of int
        Numbers along each axis; a single number where it is empty.
    """

    name: str
    unit: str
    low: float
    high: float
    shape: tuple[int, ...] = ()

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return math.prod(self.shape)


@dataclass(frozen=True, slots=True)
class Signals:
    """What an observation or an action is made of.

    Attributes
    ----------
    channels : tuple of Channel
        Its numbers, in their order.
    kind : str
        `real` for float64[n] of all channels one after the other, `whole` for int64[n], `frame` for a single
        channel that is a picture of bytes in its shape.
    """

    channels: tuple[Channel, ...]
    kind: Kind = "real"

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return sum(channel.size for channel in self.channels)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of its array."""
        return self.channels[0].shape if self.kind == "frame" else (self.size,)

    @property
    def low(self) -> F64:
        """Least values, float64[n] or in the shape of a frame, each in its channel's unit."""
        return self._spread([channel.low for channel in self.channels])

    @property
    def high(self) -> F64:
        """Greatest values, float64[n] or in the shape of a frame, each in its channel's unit."""
        return self._spread([channel.high for channel in self.channels])

    def table(self) -> list[tuple[str, str, str, float, float]]:
        """Return a row of each channel: index, name, unit, least and greatest value."""
        rows, at = [], 0
        for channel in self.channels:
            last = at + channel.size - 1
            index = str(at) if channel.size == 1 else f"{at}..{last}"
            rows.append((index, channel.name, channel.unit or "-", channel.low, channel.high))
            at = last + 1
        return rows

    def checked(self, value: ArrayLike, path: str) -> Array:
        """Return an array that was given for these signals.

        Parameters
        ----------
        value
            Numbers in the units of the channels, in the shape of `shape`.
        path
            What errors call it.

        Raises
        ------
        ParameterError
            It has another shape, or a number is not finite, not whole or out of bounds.
        """
        try:
            given = np.asarray(value)
            found = given.astype(np.float64, casting="unsafe" if given.dtype.kind == "O" else "same_kind")
        except (TypeError, ValueError):
            raise ParameterError(f"{path}: {value!r:.80}, must be {self.size} numbers") from None
        if found.shape == () and self.size == 1 and self.kind != "frame":
            found = found.reshape(1)
        if found.shape != self.shape:
            raise ParameterError(f"{path}: an array of shape {found.shape}, must be {self.shape}")
        inside = (found >= self.low) & (found <= self.high)
        if self.kind != "real":
            inside &= found == np.rint(found)
        wrong = np.flatnonzero(~inside.ravel())
        if wrong.size:
            raise self._refused(found.ravel(), int(wrong[0]), path)
        return found if self.kind == "real" else found.astype(np.int64 if self.kind == "whole" else np.uint8)

    def _spread(self, values: list[float]) -> F64:
        sizes = [channel.size for channel in self.channels]
        return np.repeat(np.array(values, dtype=np.float64), sizes).reshape(self.shape)

    def _refused(self, values: F64, at: int, path: str) -> ParameterError:
        begins = np.cumsum([0, *(channel.size for channel in self.channels)])
        channel = self.channels[int(np.searchsorted(begins, at, side="right")) - 1]
        kind = "a number" if self.kind == "real" else "a whole number"
        unit = f" {channel.unit}" if channel.unit else ""
        return ParameterError(
            f"{path}[{at}] ({channel.name}): {values[at]:g}{unit}, must be {kind} from {channel.low:g} to"
            f" {channel.high:g}"
        )


def gathered(*parts: ArrayLike) -> F64:
    """Return numbers and arrays one after the other, float64[n]."""
    return np.concatenate([np.ravel(np.asarray(part, dtype=np.float64)) for part in parts])


def padded(rows: F64, count: int, filler: float) -> F64:
    """Return the first rows of a table, float64[count, columns]; what is missing is `filler`."""
    table = np.full((count, rows.shape[1]), filler)
    kept = rows[:count]
    table[: len(kept)] = kept
    return table
