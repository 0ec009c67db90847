"""Drain currents of one polarity at known voltages, sizes and temperatures: what a fit reads."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from circuits.arrays import F64, Bools
from circuits.errors import ParameterError
from circuits.silicon.process import Polarity

AXES = ("width", "length", "temperature_c", "v_d", "v_g", "v_s", "current")


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Drain currents; all arrays are float64[n].

    Attributes
    ----------
    polarity : str
        `n` or `p`.
    width, length : array
        Size of the device, m.
    temperature_c : array
        Temperature, degC.
    v_d, v_g, v_s : array
        Voltages of drain, gate and source to the bulk, V, a pFET's mirrored.
    current : array
        Magnitude of the drain's current, A, above zero.

    Raises
    ------
    ParameterError
        Arrays of different lengths, or a current that is not finite and above zero.
    """

    polarity: Polarity
    width: F64
    length: F64
    temperature_c: F64
    v_d: F64
    v_g: F64
    v_s: F64
    current: F64

    def __post_init__(self) -> None:
        for name in AXES:
            value = np.asarray(getattr(self, name), dtype=np.float64).ravel()
            object.__setattr__(self, name, value)
            if value.size != self.width.size:
                raise ParameterError(f"points.{name}: {value.size} values, must be {self.width.size}")
        if not np.all((self.current > 0.0) & np.isfinite(self.current)):
            raise ParameterError(
                f"points.current: {self.current.min():g} A, must be > 0; leave such points out"
            )

    def __len__(self) -> int:
        return int(self.width.size)

    def where(self, mask: Bools) -> Points:
        """The points at which `mask`, bool[n], is true."""
        chosen: dict[str, Any] = {name: getattr(self, name)[mask] for name in AXES}
        return Points(self.polarity, **chosen)

    def between(self, low: float, high: float) -> Points:
        """The points whose current is from `low` to `high` A."""
        return self.where((self.current >= low) & (self.current <= high))

    def sizes(self) -> list[tuple[float, float]]:
        """Each (width, length), m, once, in order."""
        return sorted(set(zip(self.width.tolist(), self.length.tolist(), strict=True)))

    def of_size(self, size: tuple[float, float]) -> Points:
        """The points of devices of a (width, length), m."""
        return self.where((self.width == size[0]) & (self.length == size[1]))


def joined(parts: Iterable[Points]) -> Points:
    """Points of several, one after the other; raises `ParameterError` for none, or for both polarities."""
    every = list(parts)
    if len({part.polarity for part in every}) != 1:
        raise ParameterError("points: none, or of both polarities, must be of one; fit each by itself")
    chosen: dict[str, Any] = {name: np.concatenate([getattr(p, name) for p in every]) for name in AXES}
    return Points(every[0].polarity, **chosen)
